"""What the choice between the water vapour continua of MT_CKD changes in the bands of a job.

Measured radiation does not decide between them everywhere (`atmospheres/continuum/README.md`): their spread is an
error of every file.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from skyshine.mat.atmosphere.band.sample import Sample, SampledLine
from skyshine.mat.atmosphere.gases.absorption import available_water_continua, packaged_water_continuum
from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.optics import gas_absorption, spectral_optics
from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.mat.atmosphere.transfer.thermal_light import ThermalLight
from skyshine.mat.atmosphere.transfer.thermal_source import ThermalSource
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.job.warnings import merged
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.mat.scene.air_cells import air_cell
from skyshine.mat.scene.assessed_points import assessed_points
from skyshine.mat.scene.atmosphere import air_key, atmospheric_state
from skyshine.mat.scene.bands import response_of
from skyshine.mat.scene.grids import path_grid
from skyshine.schemas.arrays import Floats

NAMED_KELVIN = 0.3  # above which `mat check` names the spread
_PUBLIC = "lowtran7"  # chosen for its terms, not for what was measured
_LINES, _SEED = 16, 0  # lines of sight
_BACKGROUND = 300.0  # K


def other_continua(job: Job) -> list[str]:
    """Names of the continua of MT_CKD in the package besides the job's."""
    names = available_water_continua(packaged_water_continuum())
    return [name for name in names if name not in (job.water_continuum, _PUBLIC)]


def spread_warnings(loaded: LoadedJob) -> list[str]:
    """A line for each band in which the continua differ by more than `NAMED_KELVIN`, with the states it concerns."""
    job = loaded.trimmed
    others, spread, lines = other_continua(job), dict[tuple[object, ...], float](), []
    if not others:
        return []
    for band in job.needed_bands:
        response = response_of(job.bands[band - 1])
        for number, state in enumerate(job.states, 1):
            # States of one cell of weather have about the same water.
            key = band, air_cell(job.site, state) or air_key(state)
            if key not in spread:
                spread[key] = spread_kelvin(job, atmospheric_state(job.site, state), response, others)
            if spread[key] > NAMED_KELVIN:
                lines.append(
                    (
                        number,
                        f"water vapour continua of MT_CKD differ by {spread[key]:.1f} K on lines of sight of "
                        f"b{band:02d}"
                        f" before 300 K (95 %); measurements do not decide: {job.water_continuum} is taken,"
                        f" {' and '.join(others)} may be (water_continuum)",
                    )
                )
    return merged(lines)


def spread_kelvin(job: Job, state: AtmosphericState, response: SpectralResponse, others: list[str]) -> float:
    """Largest difference of other continua from the job's, 95 % of random lines of sight before a black body [K].

    Parameters
    ----------
    state : AtmosphericState
        Its particles are passed over.
    others : list of str
        Names of continua.
    """
    clear = replace(state, aerosols=(), hydrometeors=())
    band = assessed_points(response, job.water_continuum)
    wavenumber, weight = band.wavenumber, band.radiance_weight
    optics = spectral_optics(clear, band.points, band.gases)
    shells = Shells.of(clear.altitude, clear.number_density, float(np.average(wavenumber, weights=band.weight)))
    lines = Sample.for_test(shells, path_grid(job), _LINES, np.random.default_rng(_SEED)).lines
    emitted = ThermalLight(ThermalSource(clear.altitude, optics.emission, None), float)
    background = planck_wavenumber(wavenumber, _BACKGROUND)

    def radiance(line: SampledLine, extinction: Floats) -> float:
        """Radiance of a band at the observer of a black body at the end of the first segments of a line."""
        end, depth = int(line.node[-1]), line.segments.column(extinction)
        air = emitted.of_segments(line.segments, Depths(depth))[:end].sum(axis=0)
        return float((np.exp(-depth[:end].sum(axis=0)) * background + air) @ weight)

    radiances = []
    for name in (job.water_continuum, *others):
        points = assessed_points(response, name).points
        continuum = gas_absorption(clear, points, [CONTINUUM])[CONTINUUM]
        extinction = optics.extinction - optics.absorption[CONTINUUM] + continuum
        radiances.append([radiance(line, extinction) for line in lines])
    step = (
        planck_wavenumber(wavenumber, _BACKGROUND + 0.5) - planck_wavenumber(wavenumber, _BACKGROUND - 0.5)
    ) @ weight
    change = np.abs(np.array(radiances[1:]) - radiances[0]).max(axis=0) / step
    return float(np.percentile(change, 95))
