"""What files say of their own errors, measured again elsewhere, on the starter job."""

import re
import time

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.builder.build import build
from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job
from skyshine.mat.measure.sampling import random_places
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import ScatteringGrid
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import compiled_band
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.sources import source_irradiance
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.table import temperature_table
from skyshine.mat.tables.gridded import AXES, FIELDS, QUANTITIES, Gridded
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.loader import open_table
from skyshine.materials.library import load_library
from skyshine.schemas.documents import read_yaml
from skyshine.schemas.errors import CheckFailed

pytestmark = pytest.mark.validation
POINTS, MANY_POINTS = 1000, 10_000


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
    state, response = atmospheric_state(job.site, job.states[0]), response_of(job.bands[band - 1])
    points = band_points(absorption_table().points(*response.wavenumber_range), response)
    compiled, _ = compiled_band(loaded, job.states[0], response, state, points)
    sun = source_irradiance(job, "sun", compiled.band.wavenumber, compiled.band.width)
    return BandAtmosphere.of(state, compiled.band), sun, base, Scale.kelvin(response)


def fresh_points(air, sun, base, points, sky_points):
    """Random points of the job's own axes that lie above the ground, and the quantities there; sky light at the first
    of them.
    """
    generator = np.random.default_rng(987654)
    places = [random_places(getattr(base, name), points, generator) for name in FIELDS]
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


def rising(table, places):
    """Where the source rises inside the cell of direct light that is read: a step there is in no linear cell."""
    lit = (table.root.variables["direct_radiance"].data > 0).astype(float)
    share = interpolate(lit, table.rules("direct_radiance"), {axis: places[axis] for axis in AXES[:4]})
    return (share > 0) & (share < 1)


def test_what_cannot_be_held_is_refused_in_one_line(tmp_path):
    """3-5 um at 0.1 K with three million nodes: the quantity, its axes, the error reached; no file is left."""

    def change(job):
        job["bands"] = job["bands"][:1]
        job["atmosphere_grid"] |= {"tolerance": {"path_radiance_ratio": "0.1 K"}, "most_nodes": 3_000_000}

    with pytest.raises(CheckFailed) as raised:
        starter(tmp_path / "demo", change)
    print(f"\n{raised.value}")
    words = (
        r"tolerance 0.1 cannot be held for path_radiance_ratio with 3,000,000 nodes: it takes more than .* after an"
        r" error of .*, most for the"
    )
    assert re.search(words, str(raised.value)) and "\n" not in str(raised.value)
    assert not list((tmp_path / "demo").rglob("*.atmq.h5*"))


def uniform_grid(grid, counts, nodes):
    """Equally spaced axes (ranges in their logarithm) between the same ends, in the proportions of `counts`, with as
    many nodes or more.
    """

    def shape(factor):
        return [max(2, round(factor * n)) if n > 1 else 1 for n in counts]

    factor = 0.01
    while np.prod(shape(factor)) < nodes:
        factor *= 1.005
    ends = [(axis[0], axis[-1]) for axis in grid]
    return ScatteringGrid(
        np.geomspace(*ends[0], shape(factor)[0]),
        *(np.linspace(*end, n) for end, n in zip(ends[1:], shape(factor)[1:], strict=True)),
    )


@pytest.mark.parametrize(("band", "tolerance"), [("8-12", 0.5), ("8-12", 0.1), ("3-5", 0.5)])
def test_tolerance_holds_at_fresh_points(band, tolerance, tmp_path):
    """99 % of 1000 points within it, the worst within twice; a uniform grid with three times the nodes is worse at the
    same points.
    """

    def change(job):
        job["bands"] = [one for one in job["bands"] if one["wavelength_um"][0] == float(band.split("-")[0])]
        job["atmosphere_grid"] |= {"tolerance": f"{tolerance} K", "layout": "classic"}

    loaded = starter(tmp_path / "demo", change)
    file = tmp_path / "demo" / "built" / "s01b01.atmq.h5"
    table, (air, sun, base, scale) = open_table(file), rebuilt(loaded, 1)
    places, exact = fresh_points(air, sun, base, POINTS, POINTS)
    errors = errors_of(table, places, exact, scale)
    worst, steps = np.max(np.abs(list(errors.values())), axis=0), rising(table, places)
    print(
        f"\n{band} um, {tolerance} K: {file.stat().st_size / 1e6:.1f} MB; all: 99 % {np.percentile(worst, 99):.3f} K,"
        f" worst {worst.max():.3f} K"
    )
    for name, error in errors.items():
        nodes = table.root.variables[name].data.size
        print(
            f"  {name}: {nodes:,} nodes, 99 % {np.percentile(np.abs(error), 99):.3f} K, worst"
            f" {np.abs(error).max():.3f} K"
        )
    off = np.where(
        steps, np.max(np.abs([error for name, error in errors.items() if name != "direct_radiance"]), axis=0), worst
    )
    print(
        f"  {np.count_nonzero(steps)} points with the sunrise in their cell; the worst of all but direct light there"
        f" {off.max():.3f} K"
    )
    assert np.percentile(worst, 99) <= tolerance and off.max() <= 2 * tolerance

    ratio = table.root.variables["path_radiance_ratio"]
    counts = [
        int(n) for n in str(table.root.groups["accuracy"].attributes["path_radiance_ratio_uniform_nodes"]).split(",")
    ]
    placed = np.abs(errors["path_radiance_ratio"])
    # In the proportions that each axis needs by itself, and in those of the placed nodes.
    for proportions in (counts, ratio.data.shape):
        grid = uniform_grid([table.root.axes[name].values for name in ratio.dims], proportions, 3 * ratio.data.size)
        even = Gridded.all_of(air.table(grid, sun, wanted=("path_radiance_ratio",)), grid)["path_radiance_ratio"]
        error = scale.error(
            "path_radiance_ratio",
            even.read(places),
            exact["path_radiance_ratio"],
            exact["transmittance"],
            places["range"],
        )
        p99, maximum = np.percentile(np.abs(error), 99), np.abs(error).max()
        print(
            f"  uniform {' x '.join(str(n) for n in grid.shape)} = {even.values.size:,} nodes: 99 % {p99:.3f} K, worst"
            f" {maximum:.3f} K"
        )
        assert p99 > np.percentile(placed, 99) and maximum > placed.max()


def test_stated_errors_agree_with_another_measurement(tmp_path):
    """Root mean square of each quantity within a factor of 1.5, where the errors matter (over 0.02 K)."""
    loaded = starter(tmp_path / "demo")
    wrong = []
    for band in (1, 2):
        table = open_table(tmp_path / "demo" / "built" / f"s01b{band:02d}.atmq.h5")
        air, sun, base, scale = rebuilt(loaded, band)
        errors = errors_of(table, *fresh_points(air, sun, base, MANY_POINTS, POINTS), scale)
        for name, error in errors.items():
            stated, again = table.error(name)["rms_kelvin"], float(np.sqrt(np.mean(error**2)))
            print(f"\nband {band} {name}: stated {stated:.3f} K, measured again {again:.3f} K", end="")
            if max(stated, again) > 0.02 and not 1 / 1.5 <= stated / again <= 1.5:
                wrong.append((band, name, stated, again))
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
        "atmosphere_grid": {"tolerance": f"{tolerance} K", "layout": "channels"},
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
    truth = air.at_points(*low, sun)
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
