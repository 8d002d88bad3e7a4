"""What is omitted from the tables of a state and a band: particles and scattered light below the job's tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.bounds import Bounds
from skyshine.mat.job.model import Job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.equivalent_temperature import REFERENCE, kelvin_per_radiance


@dataclass(frozen=True, eq=False)
class Omission:
    """What is omitted from the tables of a state and a band, with the largest change that each omission makes.

    Attributes
    ----------
    particles : dict of int to float
        Change of apparent temperature [K] by index in `AtmosphericState.particles`.
    scattered : dict of str to float
        Sources whose light is not scattered, K.
    radiance : float
        Equal to 1 K, W m^-2 sr^-1, at a black body as warm as the ground, at most 300 K; 0 below 2.5 um, where
        equivalent temperature is undefined and nothing is omitted.
    """

    particles: dict[int, float]
    scattered: dict[str, float]
    radiance: float

    @classmethod
    def of(
        cls, job: Job, sources: Sequence[str], state: AtmosphericState, response: SpectralResponse, bounds: Bounds
    ) -> Omission:
        """What a job's tolerance allows to omit.

        Parameters
        ----------
        sources : sequence of str
            Light sources that `bounds` cover.
        bounds : Bounds
            Bounds of the state in the band.
        """
        kelvin = kelvin_per_radiance(response, min(state.surface_temperature, REFERENCE))
        tolerance, radiance = job.accuracy.negligible_k, 0.0 if np.isnan(kelvin) else 1 / kelvin
        particles: dict[int, float] = {}
        if tolerance == 0:
            return cls({}, {}, radiance)
        # Bounds of particles are those at the nodes that a job names; between them only 0 is certain.
        allowed = 0.0
        for index in np.argsort(bounds.particles, kind="stable"):
            change = float(bounds.particles[index] * kelvin) if bounds.particles[index] > 0 else 0.0
            if not sum(particles.values()) + change <= allowed:
                break
            particles[int(index)] = change
        remaining = tolerance - sum(particles.values())
        scattered = {source: float(bound * kelvin) for source, bound in zip(sources, bounds.scattered, strict=True)}
        return cls(particles, {source: change for source, change in scattered.items() if change <= remaining}, radiance)

    def bound(self, source: str) -> float:
        """Largest change of all omissions together in the tables of a source, K."""
        return sum(self.particles.values()) + self.scattered.get(source, 0.0)

    def without(self, state: AtmosphericState) -> AtmosphericState:
        """The state without those particles."""
        if not self.particles:
            return state
        count = len(state.aerosols)
        remaining = [(k, particle) for k, particle in enumerate(state.particles) if k not in self.particles]
        return replace(
            state,
            aerosols=tuple(particle for k, particle in remaining if k < count),
            hydrometeors=tuple(particle for k, particle in remaining if k >= count),
        )

    def names(self, state: AtmosphericState) -> dict[str, float]:
        """Names of those particles with the change of each, K; several of a name together."""
        changes: dict[str, float] = {}
        for index, change in sorted(self.particles.items()):
            name = state.particles[index].model.name
            changes[name] = changes.get(name, 0.0) + change
        return changes

    def text(self, source: str, state: AtmosphericState) -> str:
        """One line for the tables of a source, empty where they hold everything."""
        scattered = (
            [f"scattered light of the {source} ({self.scattered[source]:.1e} K)"] if source in self.scattered else []
        )
        return ", ".join(scattered + [f"{name} ({change:.1e} K)" for name, change in self.names(state).items()])
