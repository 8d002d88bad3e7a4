"""Many sites in one job: lists, tables, tiles with altitude, texts by site, and what one site that fails does."""

import json

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.builder.build import Outcome, _batches
from skyshine.mat.builder.parts import Part
from skyshine.mat.builder.tasks import _context
from skyshine.mat.job.load import job_sites, load_job
from skyshine.mat.products.table import PRODUCTS
from skyshine.schemas.errors import InputError

JOB = """\
skyshine: 1
name: sites
site: {date: 2026-06-28, utc_offset_h: -5}
sites: SITES
states:
  - profile: midlatitude_summer
    weather: {air_temperature_c: [22, 33]}
    series: {table: "weather/{site}.csv"}
bands: []
materials: [asphalt_road]
output: {folder: built, pictures: false}
surface_grid: {azimuth_deg: [0, 180], slope_deg: [0, 45], time: [00:00, 12:00]}
"""
TWO = (
    "[{name: a, latitude_deg: 29.7, longitude_deg: -82},"
    " {name: b, latitude_deg: 45, longitude_deg: -82, altitude_km: 1}]"
)
DAYS = 'date, weather.air_temperature_c\n2026-06-28, "[22, 33]"\n2026-12-28, "[1, 9]"\n'


def written(folder, sites, *names):
    (folder / "weather").mkdir(exist_ok=True)
    for name in names:
        (folder / "weather" / f"{name}.csv").write_text(DAYS, encoding="utf-8")
    (folder / "job.yaml").write_text(JOB.replace("SITES", sites), encoding="utf-8")
    return folder / "job.yaml"


@pytest.fixture
def job(tmp_path):
    return lambda sites, *names: written(tmp_path, sites, *names)


@pytest.fixture(scope="module")
def skies(builds_here, tmp_path_factory):
    """The four clear skies of both sites, computed once for the tests that build."""
    skyshine.mat.build(written(tmp_path_factory.mktemp("skies"), TWO, "a", "b"))


def test_a_site_has_its_own_place_and_weather_and_what_site_says_for_all(job):
    sites = job_sites(job(TWO, "a", "b"))
    assert sites.names == ("a", "b")
    loaded = sites.load(1)
    assert loaded.site_name == "b" and loaded.trimmed.site.altitude_km == 1 and loaded.trimmed.site.utc_offset_h == -5
    assert [state.date.month for state in loaded.trimmed.states] == [6, 12]


def test_a_table_has_a_site_in_each_row(job, tmp_path):
    rows = "name, latitude_deg, longitude_deg, utc_offset_h\na, 29.7, -82,\n7, 45, 8, 1\n"
    (tmp_path / "sites.csv").write_text(rows, encoding="utf-8")
    sites = job_sites(job("sites.csv", "a", "7"))
    assert sites.names == ("a", "7")
    assert [sites.load(number).trimmed.site.utc_offset_h for number in (0, 1)] == [-5, 1]
    (tmp_path / "sites.csv").write_text(rows.replace("29.7", "97"), encoding="utf-8")
    with pytest.raises(InputError, match=r"sites\.csv:2: latitude_deg: found 97"):
        job_sites(tmp_path / "job.yaml")


def test_tiles_have_the_mean_height_of_their_raster(job, tmp_path):
    rasterio = pytest.importorskip("rasterio")
    heights = np.repeat(np.repeat([[430.0, 1020.0], [-10.0, 2000.0]], 5, 0), 5, 1).astype("float32")
    transform = rasterio.transform.from_origin(8, 48, 0.1, 0.1)
    settings = {"width": 10, "height": 10, "count": 1, "dtype": "float32", "crs": "EPSG:4326", "transform": transform}
    with rasterio.open(tmp_path / "dem.tif", "w", driver="GTiff", **settings) as raster:
        raster.write(heights, 1)
    tiles = "{tiles: {latitude_deg: [47, 48], longitude_deg: [8, 9], step_deg: 0.5, elevation: dem.tif}}"
    names = ("n47.25e8.25", "n47.25e8.75", "n47.75e8.25", "n47.75e8.75")
    sites = job_sites(job(tiles, *names))
    assert sites.names == names
    assert [sites.load(number).trimmed.site.altitude_km for number in range(4)] == [0, 2, 0.45, 1]
    with pytest.raises(InputError, match=r"dem\.tif: has no height in the tile at latitude 48.25"):
        job_sites(job(tiles.replace("[47, 48]", "[48, 49]"), *names))


def test_a_job_of_many_sites_is_no_job_of_one(job):
    with pytest.raises(InputError, match="found 2 sites; allowed here: a job of one"):
        load_job(job(TWO, "a", "b"))


def test_one_site_that_fails_is_named_and_the_others_are_built(job, skies, tmp_path):
    file = job(TWO, "b")
    with pytest.raises(InputError, match=r"a\.csv.*1 of the sites cannot be read \(a\); the others are complete"):
        skyshine.mat.build(file)
    with pytest.raises(InputError, match=r"1 of the sites cannot be read \(a\)"):
        skyshine.mat.check(file)
    assert {path.parent.name for path in (tmp_path / "built").rglob("*.h5")} == {"b"}
    assert list(json.loads((tmp_path / "built" / "build.json").read_text())["failed"]) == ["a/"]
    built = skyshine.mat.build(job(TWO, "a", "b"))
    assert {name: entry["kept"] for name, entry in built.files.items()} == {
        "a/s01.htt.h5": False,
        "a/s02.htt.h5": False,
        "b/s01.htt.h5": True,
        "b/s02.htt.h5": True,
    }
    catalog = skyshine.mat.open_catalog(built.folder)
    assert catalog.open("htt", site="a", date="2026-12-28").path == built.folder / "a" / "s02.htt.h5"
    assert [entry.file for entry in skyshine.mat.open_catalog(built.folder / "b").entries] == [
        "s01.htt.h5",
        "s02.htt.h5",
    ]
    with pytest.raises(InputError, match="contains no site 'c'"):
        catalog.find(site="c")


def test_parts_are_disjoint_and_the_last_writes_one_catalogue(job, skies, tmp_path):
    file = job(TWO, "a", "b")
    names = set()
    for number in (1, 3, 2):
        assert not (tmp_path / "built" / "catalog.json").exists()
        files = set(skyshine.mat.build(file, part=f"{number}/3").files)
        assert files and not files & names
        names |= files
    assert {entry.file for entry in skyshine.mat.open_catalog(tmp_path / "built").entries} == names
    assert names == {f"{site}/s{state:02d}.htt.h5" for site in "ab" for state in (1, 2)}
    assert set(json.loads((tmp_path / "built" / "build.json").read_text())["files"]) == names
    with pytest.raises(InputError, match="found --part '4/3'"):
        skyshine.mat.build(file, part="4/3")


@pytest.mark.parametrize(("sites", "states", "count"), [(1, 365, 12), (5, 12, 7), (3, 1, 5), (1000, 3, 999), (7, 2, 1)])
def test_each_state_is_in_one_part(sites, states, count):
    parts = [Part(number, count) for number in range(1, count + 1)]
    for site in range(0, sites, max(1, sites // 20)):
        for state in range(1, states + 1):
            having = [part for part in parts if part.has_state(site, sites, state, states)]
            assert len(having) == 1 and having[0].has_site(site, sites)


def test_a_process_is_sent_a_state_and_computes_what_the_job_does(job, tmp_path):
    """The identity of a file contains all that it depends on."""
    file = job(TWO, "a", "b")
    file.write_text(file.read_text().replace("bands: []", "bands: [{wavelength_um: [10, 10.2]}]"), encoding="utf-8")
    for work in next(_batches(job_sites(file), None, Outcome())):
        if work.task.kind.of_state:
            alone = work.loaded.with_state_alone(work.task.index)
            assert len({id(state) for state in alone.trimmed.states}) == 1
            product, materials = PRODUCTS[work.task.kind], ("asphalt_road",)
            identities = [
                [identity.header for identity in product.identity(_context(work.task, loaded, materials))]
                for loaded in (work.loaded, alone)
            ]
            assert identities[0] == identities[1]
