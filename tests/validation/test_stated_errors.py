"""What files say of their own errors, measured again elsewhere.

python -m pytest -m validation -s tests/validation/test_stated_errors.py
"""

import time

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.builder.build import build
from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job
from skyshine.mat.measure.sampling import random_coordinates
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import compiled_band
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.ground import over_ground
from skyshine.mat.scene.sources import source_irradiance
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.table import temperature_table
from skyshine.mat.tables.gridded import AXES, FIELDS, QUANTITIES
from skyshine.mat.tables.loader import open_table
from skyshine.materials.library import load_library
from skyshine.schemas.documents import read_yaml

pytestmark = pytest.mark.validation
POINTS = 1000


def starter(folder, change=None):
    """The starter job without its texture and pictures, changed, built."""
    CliRunner().invoke(main, ["init", str(folder)], standalone_mode=False, catch_exceptions=False)
    job = dict(read_yaml(folder / "job.yaml").data)
    job.pop("textures")
    job |= {
        "materials": ["asphalt_road", "grass_green", "conifer"],
        "sources": ["sun"],
        "output": {"folder": "built", "pictures": False},
    }
    if change:
        change(job)
    file = folder / "job.yaml"
    file.write_text(yaml.safe_dump(job), encoding="utf-8")
    loaded = load_job(file)
    build(loaded, jobs=2)
    return loaded


def rebuilt(loaded, band):
    """The physics that a file was computed with, sunlight, the job's axes, and the scale of errors."""
    job, base = loaded.trimmed, path_grid(loaded.trimmed)
    response = response_of(job.bands[band - 1])
    state = over_ground(atmospheric_state(job.site, job.states[0]), job.states[0], response, load_library())
    points = points_of_band(absorption_table(), response)
    compiled, _ = compiled_band(loaded, job.states[0], response, state, points)
    sun = source_irradiance(job, "sun", compiled.band.wavenumber, compiled.band.width)
    return BandAtmosphere.of(state, compiled.band), sun, base, Scale.kelvin(response)


def fresh_points(air, sun, base, points, sky_points):
    """Random points of the job's own axes that lie above the ground, and the quantities there; sky light at the first
    of them.
    """
    generator = np.random.default_rng(987654)
    places = [random_coordinates(getattr(base, name), points, generator) for name in FIELDS]
    distance, altitude, elevation, *source = places
    truth = air.along_lines(
        distance[:, None], altitude, elevation, *(a[:, None] for a in source), np.zeros(sky_points, int), sun
    )
    exact = {name: np.ravel(value) for name, value in vars(truth).items()}
    above = exact.pop("valid")
    exact["ambient"] = np.append(exact["ambient"], np.full(points - sky_points, np.nan))
    return {name: place[above] for name, place in zip(AXES, places, strict=True)}, {
        name: value[above] for name, value in exact.items()
    }


def errors_of(table, places, exact, scale):
    """Errors of each quantity of a file in kelvin, read as a runtime does; those of ambient where it is known."""
    found = {}
    for name, (key, count) in QUANTITIES.items():
        read = table.value(name, **{axis: places[axis] for axis in AXES[:count]})
        error = scale.error(name, read, exact[key], exact["transmittance"], places["range"])
        found[name] = error[np.isfinite(error)]
    return found


# That end near the ground, and of each other region; with sky light, which takes five seconds a line at all points.
LINES, OTHER_LINES, SKY_LINES = 500, 150, 12
RADIUS_KM = 6371.0
# Kelvin below which a stated error is no promise: the file's own digits.
FLOOR_K = 0.01


def straight_end(height, sine, distance):
    """Height [km] of the end of a straight line over a round Earth."""
    start = RADIUS_KM + height
    return np.sqrt(start**2 + distance**2 + 2 * start * distance * sine) - RADIUS_KM


def own_lines(region, base, ground_km, count, generator):
    """Lines of a region by plain geometry, without refraction: height above the ground [km], sine of the elevation,
    range [km].
    """
    highest, longest = base.altitude_km[-1] - ground_km, base.range_km[-1]
    height = np.exp(generator.uniform(np.log(0.05), np.log(highest), count))
    sine = generator.uniform(-1, 1, count)
    distance = np.exp(generator.uniform(np.log(0.1), np.log(longest), count))
    if region == "ground":  # 20 m above it, as pixels of walls and vehicles
        sine = -np.abs(sine)
        start, end = RADIUS_KM + height, RADIUS_KM + 0.02
        inside = (start * sine) ** 2 - start**2 + end**2
        distance = np.where(inside > 0, -start * sine - np.sqrt(np.maximum(inside, 0)), np.inf)
    elif region == "limb":
        dip = np.arccos(RADIUS_KM / (RADIUS_KM + height))
        sine = -np.sin(dip * generator.uniform(0.02, 0.9, count))
    elif region == "sky":
        sine, distance = np.abs(sine), np.full(count, longest)
    end = straight_end(height, sine, np.minimum(distance, longest))
    keep = (distance <= longest) & (end > 0.01)
    if region == "sky":
        keep &= end > 20
    if region == "air":
        keep &= (end < 20) & (sine > -np.sqrt(2 * height / RADIUS_KM)) | (sine < -0.05)
    return height[keep], sine[keep], distance[keep]


def own_truth(loaded, band, region, count):
    """Places of own lines and the quantities there at all spectral points of the band; ambient on the first."""
    job = loaded.trimmed
    response = response_of(job.bands[band - 1])
    state = over_ground(atmospheric_state(job.site, job.states[0]), job.states[0], response, load_library())
    points = points_of_band(absorption_table(), response)
    air, sun = BandAtmosphere.of(state, points), source_irradiance(job, "sun", points.wavenumber, points.width)
    base, generator, ground = path_grid(job), np.random.default_rng(20260727), job.site.altitude_km
    height, sine, distance = (values[:count] for values in own_lines(region, base, ground, 4 * count, generator))
    altitude, elevation = ground + height, np.degrees(np.arcsin(sine))
    keep = (
        (altitude >= base.altitude_km[0]) & (elevation >= base.elevation_deg[0]) & (elevation <= base.elevation_deg[-1])
    )
    altitude, elevation, distance = altitude[keep], elevation[keep], distance[keep]
    lowest, highest = base.source_elevation_deg[[0, -1]]
    spans = [(0, highest), (0, highest), (max(-6, lowest), 0), (lowest, max(-6, lowest + 1))]
    source = np.array([generator.uniform(*spans[number % 4]) for number in range(altitude.size)])
    azimuth = generator.uniform(0, 180, altitude.size)
    sky = min(SKY_LINES, altitude.size)
    truth = air.along_lines(
        distance[:, None], altitude, elevation, source[:, None], azimuth[:, None], np.zeros(sky, int), sun
    )
    places = dict(zip(AXES, (distance, altitude, elevation, source, azimuth), strict=True))
    return places, truth, response


def own_errors(table, places, truth, response):
    """Errors (k,) of each quantity as kelvin of a black body at 300 K behind the path, with where they are."""
    wavenumber = np.linspace(*response.wavenumber_range, 4000)
    weight = np.interp(1e4 / wavenumber, response.wavelength, response.response, left=0.0, right=0.0)
    low, middle, high = (np.trapezoid(weight * planck_wavenumber(wavenumber, t), wavenumber) for t in (299, 300, 301))
    per_radiance = 2.0 / (high - low)
    tau = truth.transmittance[:, 0]
    read = {
        name: table.clamped().value(name, **{axis: places[axis] for axis in AXES[:n]})
        for name, (_, n) in QUANTITIES.items()
    }
    sky = len(truth.ambient)
    radiance = {
        "beta_star": (np.exp(-5.5 * places["range"] / read["beta_star"]) - tau) * middle,
        "path_radiance_ratio": (read["path_radiance_ratio"] - truth.path_radiance_ratio[:, 0, 0]) * (1 - tau),
        "direct_radiance": (read["direct_radiance"] - truth.direct[:, 0, 0]) * tau * 0.3,
        "ambient_radiance": (read["ambient_radiance"][:sky] - truth.ambient) * tau[:sky] * 0.3,
    }
    valid = truth.valid[:, 0]
    return {name: (error * per_radiance, valid[: error.size]) for name, error in radiance.items()}


def stated_in(table, quantity, region):
    """99 % and largest stated error [K] of a quantity in a region, and the largest of all."""
    accuracy = table.root.groups["accuracy"]
    row = list(accuracy.axes["quantity"].values).index(quantity)
    column = list(accuracy.axes["region"].values).index(region)
    p99, largest = (float(accuracy.variables[f"region_{name}_kelvin"].data[row, column]) for name in ("p99", "maximum"))
    return p99, largest, float(accuracy.variables["maximum_kelvin"].data[row])


def compare(loaded, folder, band):
    """Print measured and stated errors by region; names of those that exceed the largest stated one by over a fifth."""
    table, wrong = open_table(folder / f"s01b{band:02d}.atmq.h5"), []
    for region in ("ground", "air", "sky", "limb"):
        places, truth, response = own_truth(loaded, band, region, LINES if region == "ground" else OTHER_LINES)
        for name, (error, valid) in own_errors(table, places, truth, response).items():
            source = places["source_elevation"][: error.size]
            when = {"": np.ones(error.size, bool)}
            if name != "beta_star":
                when |= {"day": source > 0, "twilight": (source <= 0) & (source > -6), "night": source <= -6}
            for part, rows in when.items():
                some = np.abs(error[rows & valid])
                if some.size < 10:
                    continue
                measured = float(np.percentile(some, 99))
                p99, largest, whole = stated_in(table, name, part or region)
                print(
                    f"  band {band} {region:6} {part:8} {name:20} {some.size:4} lines: 99 % {measured:.3f} K; stated"
                    f" 99 % {p99:.3f}, largest {largest:.3f}, of all {whole:.3f} K"
                )
                if measured > 1.2 * max(largest if not part else whole, FLOOR_K):
                    wrong.append((band, region, part, name, measured, largest, whole))
    return wrong


@pytest.mark.parametrize("band", [1, 2])
def test_the_largest_stated_error_is_exceeded_by_no_more_than_a_fifth(band, tmp_path):
    """By 99 % of own lines, 500 of them to the ground, at all spectral points; ten minutes a band."""
    loaded = starter(tmp_path / "demo", lambda job: job.update(bands=[job["bands"][band - 1]]))
    wrong = compare(loaded, tmp_path / "demo" / "built", 1)
    assert not wrong, wrong


@pytest.mark.parametrize("tolerance", [1.0, 0.3])
def test_tolerance_of_temperatures_holds_at_fresh_places(tolerance, tmp_path):
    """99 % of all reads within it, 99.9 % within twice, against the heat balance solved at the places themselves."""

    def change(job):
        job["bands"], job["surface_grid"] = job["bands"][1:], {"tolerance": f"{tolerance} K"}

    loaded = starter(tmp_path / "demo", change)
    job, table = loaded.trimmed, open_table(tmp_path / "demo" / "built" / "s01.htt.h5")
    generator, library = np.random.default_rng(24680), load_library()
    ends = (
        (job.surface_altitudes_km[0], job.surface_altitudes_km[-1]),
        (0, 360),
        (0, job.surface_grid.slope_deg[-1]),
        (0, 24),
    )
    altitude, azimuth, slope, time = (
        generator.uniform(*end, count) for end, count in zip(ends, (5, 9, 9, 25), strict=True)
    )
    names = list(table.materials)
    materials = surface_materials([library[name] for name in names], job.operated)
    direct = temperature_table(
        materials, *scene_inputs(job, 1), 1e3 * altitude, azimuth, slope, time, steps=job.accuracy.solver_steps
    )
    mesh = np.meshgrid(np.arange(len(names)), altitude, azimuth, slope, time, indexing="ij", sparse=True)
    where = dict(zip(("altitude", "azimuth", "slope", "time"), mesh[1:], strict=True))
    error = np.abs(
        table.temperature(material=np.array(list(table.materials.values()))[mesh[0]], **where) - direct.temperature
    )
    shape = table.root.variables["temperature"].data.shape
    print(f"\n{tolerance} K: {' x '.join(str(n) for n in shape)} nodes, {error.size:,} reads: ", end="")
    print(
        f"99 % {np.percentile(error, 99):.3f} K, 99.9 % {np.percentile(error, 99.9):.3f} K, worst {error.max():.3f} K"
    )
    assert np.percentile(error, 99) <= tolerance and np.percentile(error, 99.9) <= 2 * tolerance


SKY_POINTS, LOW_SUN = 200, 300


def channels_job(edges, tolerance):
    return {
        "skyshine": 1,
        "name": "channels",
        "site": {"latitude_deg": 45, "longitude_deg": 0, "date": "2026-07-15", "utc_offset_h": 0},
        "states": [
            {
                "profile": "midlatitude_summer",
                "aerosol": "rural",
                "visibility_km": 23,
                "weather": {"air_temperature_c": [14, 27], "relative_humidity_percent": 60, "ground_albedo": 0.2},
            }
        ],
        "bands": [{"wavelength_um": list(edges)}],
        "sources": ["sun"],
        "materials": ["concrete"],
        "surface_grid": {"slope_deg": [0]},
        "atmosphere_grid": {"tolerance": f"{tolerance} K"},
        "output": {"folder": "built", "pictures": False},
    }


def along_the_horizon(base, generator):
    """Lines within a degree of the level, towards a Sun within three degrees of the horizon and ten of the line."""
    places = {
        "range": 10 ** generator.uniform(-1, 2.3, LOW_SUN),
        "altitude": generator.uniform(0.13, 1.5, LOW_SUN) ** 3,
        "elevation": generator.uniform(-1, 1, LOW_SUN),
        "source_elevation": generator.uniform(-3, 3, LOW_SUN),
        "source_azimuth": generator.uniform(0, 10, LOW_SUN),
    }
    return [places[name] for name in AXES]


TARGETS = pytest.mark.xfail(reason="refused: direct light on targets in space, .57 K in two reads of ten thousand")
HORIZON = pytest.mark.xfail(reason="1.4 MB hold it but for a low Sun along the horizon, .104 K")
NOT_YET = [pytest.param((3, 5), 0.1, 12.0, marks=TARGETS), pytest.param((8, 12), 0.1, 2.0, marks=HORIZON)]


@pytest.mark.parametrize(("edges", "tolerance", "megabytes"), [((3, 5), 0.5, 2.0), ((8, 12), 0.5, 2.0), *NOT_YET])
def test_channels_hold_at_fresh_points(edges, tolerance, megabytes, tmp_path, monkeypatch):
    """99 % of 1000 points within it, the worst within three times; low Sun along the horizon too."""
    monkeypatch.setenv("SKYSHINE_CACHE", "")
    begin = time.perf_counter()
    loaded = load_job(
        channels_job(edges, tolerance) | {"output": {"folder": str(tmp_path / "built"), "pictures": False}}
    )
    build(loaded, out=tmp_path / "built", jobs=2)
    seconds = time.perf_counter() - begin
    file = tmp_path / "built" / "s01b01.atmq.h5"
    size = file.stat().st_size / 1e6
    print(f"\n{edges[0]}-{edges[1]} um, {tolerance} K: {size:.2f} MB, whole build {seconds:.1f} s on 2 cores")
    table, (air, sun, base, scale) = open_table(file), rebuilt(loaded, 1)
    print(
        "  nodes", table.root.variables["thermal_ratio"].data.shape, "fields", len(table.root.axes["absorber"].values)
    )
    places, exact = fresh_points(air, sun, base, POINTS, SKY_POINTS)
    errors = errors_of(table, places, exact, scale)
    for name, error in errors.items():
        print(f"  {name}: 99 % {np.percentile(np.abs(error), 99):.3f} K, worst {np.abs(error).max():.3f} K")
    low = along_the_horizon(base, np.random.default_rng(5))
    truth = air.at_points(LinesOfSight(*low), sun)
    where = dict(zip(AXES, low, strict=True))
    read = table.value("path_radiance_ratio", **where)
    grazing = np.abs(
        scale.error("path_radiance_ratio", read, truth.path_radiance_ratio, truth.transmittance, where["range"])
    )[truth.valid]
    print(f"  towards a low Sun: 99 % {np.percentile(grazing, 99):.3f} K, worst {grazing.max():.3f} K")
    for error in errors.values():
        assert np.percentile(np.abs(error), 99) <= tolerance and np.abs(error).max() <= 3 * tolerance
    assert np.percentile(grazing, 99) <= tolerance and grazing.max() <= 3 * tolerance
    assert size <= megabytes
