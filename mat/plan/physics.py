"""What a job leaves out of the physics of its atmospheric tables, with bounds."""

from __future__ import annotations

import itertools
from dataclasses import replace

from skyshine.mat.atmosphere.band.compile import negligible_gases
from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.bounds import Bounds, Scattering
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.plan.left_out import LeftOut
from skyshine.mat.scene.atmosphere import air_key, atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import MAX_POINTS
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.omission import Omission
from skyshine.mat.scene.sources import irradiance_of_sources
from skyshine.mat.tables.files import state_label


def physics_left_out(loaded: LoadedJob) -> list[LeftOut]:
    """Points, gases, particles and scattered light that bands of states do not need, with what each changes at most.

    Of states of one air, the first stands for all but their light. Bounds of particles and light are those at all
    points of a band; a build takes those at the points that it computes tables from, which differ little.
    """
    job, whole, grid = loaded.trimmed, loaded.requested, path_grid(loaded.requested)
    bands, found, faint, known = {}, [], {}, {}
    for number in job.needed_bands:
        response = response_of(job.bands[number - 1])
        bands[number] = (
            response,
            band_points(absorption_table(job.water_continuum).points(*response.wavenumber_range), response),
        )
        found += _points(job, bands[number][1].weight.size, number)
    for (number, state), band in itertools.product(enumerate(job.states, 1), bands):
        key = band, air_key(state)
        place = f"{state_label(number, len(job.states))}b{band:02d}"
        air, (response, everything) = atmospheric_state(job.site, state), bands[band]
        irradiance = irradiance_of_sources(whole.on_date_of_state(number), everything)
        if key not in known:
            whole_air = SpectralAir.of(air, everything.points, everything.gases, everything.weight)
            gases = negligible_gases(
                whole_air, everything, grid, tolerance=job.accuracy.spectral_tolerance, seed=job.accuracy.seed
            )
            if gases:
                found.append(_gases(gases, place))
            known[key] = Bounds.of(whole_air, grid, irradiance, everything.radiance_weight), Scattering.of(whole_air)
        bounds, scattering = known[key]
        bounds = replace(bounds, scattered=scattering.radiance(irradiance, everything.radiance_weight))
        left_out = Omission.of(job, whole.sources, air, response, bounds)
        changes = {
            f"scattered light of the {source}": left_out.scattered[source]
            for source in job.sources
            if source in left_out.scattered
        }
        for what, change in (
            changes | {f"particles ({name})": change for name, change in left_out.names(air).items()}
        ).items():
            faint.setdefault(what, []).append((change, change * left_out.radiance, place))
    return found + [_faint(what, cases) for what, cases in faint.items()]


_RESTORE_SPECTRUM = "a smaller accuracy.spectral_tolerance"


def _points(job: Job, count: int, band: int) -> list[LeftOut]:
    """Spectral points of a band, which has so many."""
    bound = f"about {job.accuracy.spectral_tolerance:g} of a value, rms; the file holds what is measured"
    what = f"all but {MAX_POINTS} or fewer of {count:,} spectral points in b{band:02d}"
    return [LeftOut(what, "a few stand for all", bound, _RESTORE_SPECTRUM)] if count > MAX_POINTS else []


def _gases(gases: dict[str, float], place: str) -> LeftOut:
    bound = f"at most {max(gases.values()):.1e} in transmittance"
    return LeftOut(
        f"{', '.join(gases)} in {place}", "they absorb less than the tolerance in this band", bound, _RESTORE_SPECTRUM
    )


def _faint(what: str, cases: list[tuple[float, float, str]]) -> LeftOut:
    """Particles or light that can be left out at some places."""
    kelvin, radiance, _ = max(cases)
    places = [place for *_, place in cases]
    more = f" and {len(places) - 3} more" if len(places) > 3 else ""
    return LeftOut(
        f"{what} in {', '.join(places[:3])}{more}",
        "too faint to be seen",
        f"at most {kelvin:.1e} K or {radiance:.1e} W m^-2 sr^-1 of what is seen",
        "a smaller accuracy.negligible_k; 0 leaves nothing out",
    )
