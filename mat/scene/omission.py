"""What the air of a state does in a band that is not worth computing: particles, and light of Sun or Moon that is
scattered.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.bounds import Bounds
from skyshine.mat.job.model import Job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.equivalent_temperature import REFERENCE, kelvin_per_radiance

# Of `accuracy.negligible_k` that particles may take together; scattered light may take what they leave.
_PARTICLES_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class Negligible:
    """What is left out of the tables of a state and a band, with the most that each thing changes in what is seen.

    Attributes
    ----------
    particles : dict of int to float
        By place in `AtmosphericState.particles`, K.
    scattered : dict of str to float
        Sources whose light is not scattered, K.
    radiance : float
        That is 1 K, W m^-2 sr^-1: of a black body as warm as the ground, at most 300 K; 0 below 2.5 um, where kelvin
        mean nothing and nothing is left out that is there.
    """

    particles: dict[int, float]
    scattered: dict[str, float]
    radiance: float

    @classmethod
    def of(
        cls, job: Job, sources: Sequence[str], state: AtmosphericState, response: SpectralResponse, bounds: Bounds
    ) -> Negligible:
        """Decide for a job.

        Parameters
        ----------
        sources : sequence of str
            That `bounds` are for.
        bounds : Bounds
            Of the state in the band.
        """
        warmth = kelvin_per_radiance(response, min(state.surface_temperature, REFERENCE))
        tolerance, particles, radiance = job.accuracy.negligible_k, {}, 0.0 if np.isnan(warmth) else 1 / warmth
        if tolerance == 0:
            return cls({}, {}, radiance)
        # Bounds of particles hold at the nodes that a job names, not at those which a tolerance of its grid may place
        # elsewhere.
        allowed = 0.0 if job.atmosphere_grid.tolerances else _PARTICLES_SHARE * tolerance
        for place in np.argsort(bounds.particles, kind="stable"):
            change = float(bounds.particles[place] * warmth) if bounds.particles[place] > 0 else 0.0
            if not sum(particles.values()) + change <= allowed:
                break
            particles[int(place)] = change
        left = tolerance - sum(particles.values())
        scattered = {source: float(bound * warmth) for source, bound in zip(sources, bounds.scattered, strict=True)}
        return cls(particles, {source: change for source, change in scattered.items() if change <= left}, radiance)

    def bound(self, source: str) -> float:
        """Most that all of it changes in the tables of a source, K."""
        return sum(self.particles.values()) + self.scattered.get(source, 0.0)

    def without(self, state: AtmosphericState) -> AtmosphericState:
        """The state without those particles."""
        if not self.particles:
            return state
        count = len(state.aerosols)
        kept = [(k, particle) for k, particle in enumerate(state.particles) if k not in self.particles]
        return replace(
            state,
            aerosols=tuple(particle for k, particle in kept if k < count),
            hydrometeors=tuple(particle for k, particle in kept if k >= count),
        )

    def names(self, state: AtmosphericState) -> dict[str, float]:
        """Names of those particles with the change of each, K; several of a name together."""
        found: dict[str, float] = {}
        for place, change in sorted(self.particles.items()):
            name = state.particles[place].model.name
            found[name] = found.get(name, 0.0) + change
        return found

    def text(self, source: str, state: AtmosphericState) -> str:
        """One line for the tables of a source, empty where they hold everything."""
        things = (
            [f"scattered light of the {source} ({self.scattered[source]:.1e} K)"] if source in self.scattered else []
        )
        return ", ".join(things + [f"{name} ({change:.1e} K)" for name, change in self.names(state).items()])
