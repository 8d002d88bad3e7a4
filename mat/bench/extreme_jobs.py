"""Random extreme jobs, checked and built whole, and compiled bands beside all their points."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.band.compile import compile_band
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.particles.aerosol_column import BOUNDARY_MODELS
from skyshine.mat.atmosphere.sources.ephemeris import position
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.profiles import PROFILES
from skyshine.mat.bench.extreme_air import random_state, some_points
from skyshine.mat.builder.tasks import run_task
from skyshine.mat.job.aerosols import LAYER_MODELS
from skyshine.mat.job.load import LoadedJob, load_job
from skyshine.mat.plan.cost import estimate
from skyshine.mat.plan.physics import physics_left_out
from skyshine.mat.plan.plan import Plan, make_plan
from skyshine.mat.plan.size import check_size
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table
from skyshine.mat.scene.check import check_scene
from skyshine.mat.scene.summary import state_summaries
from skyshine.mat.tables.verify import problems
from skyshine.materials.library import load_library
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import CheckFailed, InputError

MATERIALS = ("asphalt_road", "grass_green", "concrete", "water_sea", "conifer", "snow_melting", "aluminium_polished")
_SECOND = 0.15  # share of the jobs with a second state, band or source, a wide band, particles, or all lines of sight
_ALONE = 0.4  # share of the jobs without a band
_TOLERANCE = 1e-3  # relative rms of a compiled band, the default of a job
# Rms along few new lines of sight over that which the compiled band states of others, or its tolerance.
_COMPILED_BOUND = 5.0
_LINES_OF_SIGHT = 10  # random lines of each case
_SPECTRAL_POINTS = 10  # from which those of a band are chosen, at most


def job_case(generator: np.random.Generator) -> dict[str, tuple[float, float]] | str:
    """A random job: either the check refuses it, or its tasks, run here, give every file, and none breaks a law."""
    job = random_job(generator)
    try:
        loaded, plan = _checked(job)
    except InputError:
        return "by the check"
    with tempfile.TemporaryDirectory() as folder:
        try:
            for task in plan.tasks:
                run_task(task, loaded, Path(folder), plan.materials, True)
        except CheckFailed as error:
            if "cannot be held" not in str(error):
                raise
            return "tolerances that no affordable grid meets"
        lines = [f"{path.name}: {line}" for path in sorted(Path(folder).glob("*.h5")) for line in problems(path)]
        missing = [name for task in plan.tasks for name in task.files if not Path(folder, name).is_file()]
    if lines or missing:
        raise CheckFailed(f"{job['name']}: {[*lines, *missing][0]}")
    return {"problems of the databases": (0.0, 0.0), "files that are missing": (0.0, 0.0)}


def _checked(job: dict[str, Any]) -> tuple[LoadedJob, Plan]:
    """A job and its plan, after all that `mat check` does."""
    loaded = load_job(job)
    plan = make_plan(loaded, load_library())
    check_size(loaded, plan)
    check_scene(loaded)
    physics_left_out(loaded)
    state_summaries(loaded.trimmed)
    estimate(loaded, plan)
    return loaded, plan


def random_job(generator: np.random.Generator) -> dict[str, Any]:
    """A job as plain data, small in nodes and extreme in everything else.

    Bands lie anywhere from the ultraviolet to 1 mm and may be 0.01 um wide; sites from 500 m below the sea to
    mountains; weather may be measured radiation; materials may be heated from behind, or held at a temperature; there
    may be ground of a material and walls; tolerances are coarse.
    """
    ground = float(generator.choice([-0.5, -0.43, 0.0, round(float(generator.uniform(0, 5.5)), 3)]))
    materials = [str(name) for name in generator.choice(MATERIALS, int(generator.integers(1, 4)), replace=False)]
    job: dict[str, Any] = {
        "skyshine": 1,
        "name": "drawn",
        "site": {
            "latitude_deg": _some(generator, round(float(generator.uniform(-90, 90)), 2), (-90.0, 90.0)),
            "longitude_deg": round(float(generator.uniform(-180, 180)), 2),
            "date": f"{generator.integers(1950, 2050)}-{generator.integers(1, 13):02d}-{generator.integers(1, 29):02d}",
            "utc_offset_h": int(generator.integers(-11, 13)),
            "altitude_km": ground,
        },
        "states": [_state(generator) for _ in range(1 + (generator.random() < _SECOND))],
        "bands": [_band(generator) for _ in range(1 + (generator.random() < _SECOND))],
        "sources": ["sun", "moon"] if generator.random() < _SECOND else [str(generator.choice(["sun", "moon"]))],
        "materials": materials,
        "atmosphere_grid": _air_grid(generator, ground),
        "surface_grid": {
            "altitude_km": [ground],
            "azimuth_deg": [0.0, 180.0],
            "slope_deg": [0.0, 90.0, 180.0],
            "time": ["00:00", "06:00", "12:00", "18:00"],
        },
        "accuracy": {"negligible_k": _some(generator, 0.02, (0.0, 1.0)), "seed": int(generator.integers(100))},
        "output": {"pictures": False},
    }
    if generator.random() < _ALONE:
        job["bands"] = []  # temperatures alone
    _operate(generator, job, materials)
    if generator.random() > _SECOND:  # most read few lines of sight: a build samples no others
        job["needs"] = {"range_km": [0.001, 1.0], "elevation_deg": [0.0, 30.0], "shade": bool(generator.random() < 0.3)}
    if generator.random() < 0.15:
        job["surface_grid"]["tolerance"] = "5 K"
    for state in job["states"]:
        _surround(generator, state)
        if generator.random() > _SECOND and "hourly" in state["weather"]:  # otherwise nonsense, which is refused
            _only_by_day(job["site"], state["weather"]["hourly"])
    return job


def _state(generator: np.random.Generator) -> dict[str, Any]:
    hazy = generator.random() < _SECOND  # light scattered often takes most of a build
    aerosol = str(generator.choice(list(BOUNDARY_MODELS))) if hazy else "none"
    state: dict[str, Any] = {"profile": str(generator.choice(list(PROFILES))), "aerosol": aerosol}
    state["humidity_scale"] = _some(generator, 1.0, (0.0, 3.0))
    if aerosol != "none" and generator.random() < 0.5:
        state["visibility_km"] = round(float(np.exp(generator.uniform(np.log(0.1), np.log(300)))), 3)
    elif aerosol != "none":
        state["aerosol_optical_depth"] = float(generator.choice([0.0, 0.05, 2.0, 100.0]))
    if hazy and generator.random() < 0.3:
        state["angstrom_exponent"] = float(generator.choice([-1.0, 1.3, 4.0]))
    if hazy and generator.random() < 0.3:
        state["aerosol_layers"] = [_aerosol_layer(generator)]
    if hazy and generator.random() < 0.3:
        base = round(float(generator.uniform(0.1, 4.0)), 2)
        depth = float(generator.choice([0.0, 0.1, 10.0, 1000.0]))
        state["clouds"] = [{"height_km": [base, base + 1.0], "optical_depth": depth}]
    elif hazy and generator.random() < 0.2:
        state["rain"] = {"rate_mm_h": float(generator.choice([0.1, 5.0, 50.0]))}
    state["surface_albedo"] = _some(generator, 0.1, (0.0, 1.0))
    sky = generator.random() < 2 * _SECOND  # computed, not measured
    state["weather"] = _weather(generator, "clouds" in state) if sky else _measured(generator)
    return state


def _aerosol_layer(generator: np.random.Generator) -> dict[str, Any]:
    """A layer of any particles that need no file, anywhere."""
    layer: dict[str, Any] = {"optical_depth": float(generator.choice([0.0, 0.2, 100.0]))}
    if generator.random() < 0.5:
        layer["model"] = str(generator.choice(LAYER_MODELS))
    else:
        mode = {
            "median_radius_um": float(generator.choice([0.001, 0.1, 20.0])),
            "geometric_sd": float(generator.choice([1.05, 1.6, 4.0])),
            "refractive_index": [float(generator.choice([0.1, 1.5, 10.0])), float(generator.choice([0.0, 0.01, 10.0]))],
        }
        layer["size_distribution"] = [mode]
    if generator.random() < 0.5:
        bottom = float(generator.choice([0.0, 3.0, 79.9]))
        layer["height_km"] = [bottom, float(generator.choice([bottom + 0.02, 80.0]))]
    else:
        layer["scale_height_km"] = float(generator.choice([0.05, 1.0, 20.0]))
    return layer


def _weather(generator: np.random.Generator, cloudy: bool) -> dict[str, Any]:
    coldest = float(generator.choice([-60.0, -5.0, 10.0, 35.0]))
    weather = {
        "air_temperature_c": [coldest, coldest + float(generator.choice([0.0, 8.0, 20.0]))],
        "relative_humidity_percent": float(generator.choice([0.0, 50.0, 100.0])),
        "wind_speed_m_s": float(generator.choice([0.0, 2.0, 40.0])),
        "ground_albedo": float(generator.choice([0.0, 0.2, 1.0])),
    }
    return weather if cloudy else weather | {"cloud_fraction": float(generator.choice([0.0, 0.5, 1.0]))}


def _measured(generator: np.random.Generator) -> dict[str, Any]:
    """Weather by hour with measured light: a clear day, an overcast one, or nonsense within the limits."""
    hours = np.arange(24)
    height = np.clip(np.sin(2 * np.pi * (hours - 6) / 24), 0, None)
    shape = height if generator.random() < 0.7 else generator.random(24)
    hourly: dict[str, Any] = {
        "time": [f"{hour:02d}:00" for hour in hours],
        "air_temperature_c": np.round(15 + 10 * np.sin(2 * np.pi * (hours - 9) / 24), 2).tolist(),
        "direct_normal_w_m2": np.round(float(generator.choice([0.0, 900.0, 1500.0])) * shape, 1).tolist(),
        "diffuse_w_m2": np.round(float(generator.choice([0.0, 100.0, 600.0])) * shape, 1).tolist(),
    }
    if generator.random() < 0.9:  # without it the sky is computed
        hourly["longwave_down_w_m2"] = [float(generator.choice([20.0, 350.0, 800.0]))] * 24
    return {"hourly": hourly, "radiation": "measured"}


def _only_by_day(site: dict[str, Any], hourly: dict[str, Any]) -> None:
    """No measured light in hours in which the Sun is down at their begin or end."""
    hours = np.arange(-1, 24) - site["utc_offset_h"]
    moments = np.datetime64(site["date"], "s") + hours * np.timedelta64(3600, "s")
    up = position("sun", moments, site["latitude_deg"], site["longitude_deg"]).elevation > 0
    for name in ("direct_normal_w_m2", "diffuse_w_m2"):
        hourly[name] = np.where(up[1:] & up[:-1], hourly[name], 0.0).tolist()


def _band(generator: np.random.Generator) -> dict[str, Any]:
    low = float(np.exp(generator.uniform(*np.log(generator.choice([(0.2, 3.0), (3.0, 14.0), (14.0, 900.0)])))))
    width = (0.1 if generator.random() < _SECOND else 0.003) * low
    return {"wavelength_um": [round(low, 5), round(low + max(width, 0.01), 5)]}


def _air_grid(generator: np.random.Generator, ground: float) -> dict[str, Any]:
    grid: dict[str, Any] = {
        "range_km": [0.001, 1.0, float(generator.choice([5.0, 300.0, 100_000.0]))],
        "altitude_km": [round(ground + 0.002, 6), round(ground + float(generator.choice([1.0, 40.0, 90.0])), 6)],
        "elevation_deg": [-90.0, -1.0, 0.0, 30.0, 90.0],
        "source_elevation_deg": [-20.0, 0.0, 60.0],
        "tolerance": str(generator.choice(["20 K", "20 %"])),
        "most_nodes": 200_000,
    }
    if generator.random() < 0.5:  # with tables on all five axes
        grid["source_azimuth_deg"] = [0.0, 180.0]
    return grid


def _operate(generator: np.random.Generator, job: dict[str, Any], materials: list[str]) -> None:
    """A heated back, or a temperature given by hand, for some of the materials."""
    kinds: tuple[dict[str, Any], ...] = (
        {"kind": "heated", "heat_flux_w_m2": float(generator.choice([-200.0, 50.0, 5000.0]))},
        {"kind": "fixed", "temperature_c": float(generator.choice([-190.0, 20.0, 900.0]))},
        {"kind": "convective", "temperature_c": [20.0 + hour for hour in range(24)], "coefficient_w_m2_k": 25.0},
    )
    if generator.random() < 0.4:
        job["operated"] = {materials[0]: kinds[generator.integers(3)]}
    if len(materials) > 1 and generator.random() < 0.2:
        job["temperatures_c"] = {materials[1]: float(generator.choice([-150.0, 15.0, 1200.0]))}


def _surround(generator: np.random.Generator, state: dict[str, Any]) -> None:
    """Ground of a material, or walls from none to a pit, for some of the states."""
    if generator.random() < 0.2:
        state["ground_material"] = str(generator.choice(MATERIALS))
    if generator.random() < 0.8:
        return
    horizon: list[Any] = [0.0, 30.0, 90.0, [[0.0, 0.0], [90.0, 80.0], [180.0, 90.0]]]
    surroundings: dict[str, Any] = {
        "horizon_deg": horizon[generator.integers(4)],
        "sky_view": _some(generator, 1.0, (0.0, 0.5)),
    }
    if surroundings["horizon_deg"] != 0.0 or surroundings["sky_view"] < 1:
        kinds: tuple[dict[str, Any], ...] = (
            {"material": str(generator.choice(MATERIALS))},
            {"temperature_c": float(generator.choice([-200.0, 20.0, 1500.0]))},
            {"emissivity": float(generator.choice([0.01, 1.0])), "albedo": float(generator.choice([0.0, 0.99]))},
        )
        surroundings["wall"] = kinds[generator.integers(3)]
    state["surroundings"] = surroundings


def _some(generator: np.random.Generator, usual: float, extremes: tuple[float, ...]) -> float:
    return float(generator.choice(extremes)) if generator.random() < 0.3 else usual


def compiled_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """A band of a random state by its chosen points, along new lines of sight, beside all its points."""
    table, state = absorption_table(), random_state(generator)
    low, high = table.coverage[generator.integers(len(table.coverage))]
    start = float(np.exp(generator.uniform(np.log(low), np.log(high * 0.97))))
    response = SpectralResponse.rectangular(1e4 / min(start * 1.02 + 5.0, high), 1e4 / start)
    band = some_points(points_of_band(table, response), generator, _SPECTRAL_POINTS)
    sun = solar_irradiance(band.wavenumber, band.width)
    ground = state.surface_altitude * 1e-3
    grid = PathGrid(
        np.array([0.05, 1.0, 10.0, 100.0]),
        ground + np.array([0.002, 1.0, 10.0]),
        np.array([-90.0, -10.0, 0.0, 10.0, 90.0]),
        np.array([5.0, 60.0]),
        np.array([0.0, 180.0]),
    )
    compiled = compile_band(state, band, grid, sun, tolerance=_TOLERANCE)
    lines = LinesOfSight(
        _between(generator, grid.range_km),
        _between(generator, grid.altitude_km),
        _between(generator, grid.elevation_deg),
        _between(generator, grid.source_elevation_deg),
        _between(generator, grid.source_azimuth_deg),
    )
    # Light scattered more than once, which takes most of the time, is that of the atmospheres and skies above.
    few, everything = (BandAtmosphere.of(state, part) for part in (compiled.band, band))
    chosen, exact = (
        replace(part, air=replace(part.air, scatters=False)).at_points(lines, light)
        for part, light in ((few, sun[compiled.index]), (everything, sun))
    )
    valid = exact.valid
    stated = max(compiled.errors["transmittance"]["rms"], _TOLERANCE)
    differences = chosen.transmittance[valid] - exact.transmittance[valid]
    values = np.concatenate([chosen.transmittance, chosen.path_radiance_ratio, chosen.ambient, chosen.direct])
    return {
        "not finite": (float(np.count_nonzero(~np.isfinite(values))), 0.0),
        "below 0": (max(0.0, -float(values.min())), 0.0),
        "transmittance beside all points, rms over that stated": (
            float(np.sqrt(np.mean(differences**2))) / stated if valid.any() else 0.0,
            _COMPILED_BOUND,
        ),
    }


def _between(generator: np.random.Generator, axis: Floats) -> Floats:
    return np.asarray(generator.uniform(axis[0], axis[-1], _LINES_OF_SIGHT))
