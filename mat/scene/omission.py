"""What is omitted from the tables of a state and a band: scattered light of a source below the job's tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.model import Job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.equivalent_temperature import REFERENCE, kelvin_per_radiance
from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class Omission:
    """What is omitted from the tables of a state and a band, with the largest change that each omission makes.

    Attributes
    ----------
    scattered : dict of str to float
        Sources whose light is not scattered, K.
    radiance : float
        Equal to 1 K, W m^-2 sr^-1, at a black body as warm as the ground, at most 300 K; 0 below 2.5 um, where
        equivalent temperature is undefined and nothing is omitted.
    """

    scattered: dict[str, float]
    radiance: float

    @classmethod
    def of(
        cls, job: Job, sources: Sequence[str], state: AtmosphericState, response: SpectralResponse, light: Floats
    ) -> Omission:
        """What a job's tolerance allows to omit.

        Parameters
        ----------
        sources : sequence of str
            Light sources.
        light : (B,) array
            Bounds of their scattered light in the band, W m^-2 sr^-1.
        """
        kelvin = kelvin_per_radiance(response, min(state.surface_temperature, REFERENCE))
        tolerance, radiance = job.accuracy.negligible_k, 0.0 if np.isnan(kelvin) else 1 / kelvin
        changes = {source: float(bound * kelvin) for source, bound in zip(sources, light, strict=True)}
        return cls(
            {source: change for source, change in changes.items() if tolerance > 0 and change <= tolerance}, radiance
        )

    def bound(self, source: str) -> float:
        """Largest change of the tables of a source, K."""
        return self.scattered.get(source, 0.0)

    def text(self, source: str) -> str:
        """One line for the tables of a source, empty where they contain everything."""
        return f"scattered light of the {source} ({self.scattered[source]:.1e} K)" if source in self.scattered else ""
