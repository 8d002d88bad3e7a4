"""Sizes of a job: known before anything is computed, limited by its own keys, in check and build alike."""

import h5py
import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.mat.job.atmosphere import AtmosphereGrid
from skyshine.mat.job.default_nodes import OBSERVER_HEIGHTS_KM
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.physics import STATES, physics_left_out
from skyshine.mat.plan.plan import Kind, make_plan
from skyshine.mat.plan.size import check_size
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group, Header, open_database, write_file

NODES = 512
JOB = {
    "skyshine": 1,
    "name": "large",
    "site": {"latitude_deg": 30, "longitude_deg": 0, "date": "2026-06-21", "utc_offset_h": 0},
    "states": [{"profile": "us_standard", "weather": {"air_temperature_c": 15}}],
    "bands": [{"wavelength_um": [8, 12]}],
    "materials": ["asphalt_road"],
    "surface_grid": {"altitude_km": [0], "azimuth_deg": [0], "slope_deg": [0], "time": ["12:00"]},
}
SMALL = {"range_km": [1], "altitude_km": [0.1], "elevation_deg": [0], "source_elevation_deg": [30]}
SMALL |= {"source_azimuth_deg": [0]}
FIRST_TO_LAST = {"first": "2001-01-01", "last": "2028-05-17"}  # 9,999 days


def axis(low, high):
    return [low + (high - low) * k / (NODES - 1) for k in range(NODES)]


def written(folder, **changes):
    (folder / "job.yaml").write_text(yaml.safe_dump(JOB | changes, sort_keys=False), encoding="utf-8")
    return folder / "job.yaml"


@pytest.fixture
def huge(tmp_path):
    """512 nodes on each of five axes: 3.5e13 values."""
    names = ("range_km", "altitude_km", "elevation_deg", "source_elevation_deg", "source_azimuth_deg")
    ends = ((0, 100), (0, 10), (-90, 90), (-90, 90), (0, 180))
    grid = {name: axis(*limits) for name, limits in zip(names, ends, strict=True)}
    return written(tmp_path, atmosphere_grid=grid)


@pytest.mark.parametrize("command", ["check", "build"])
def test_a_table_beyond_memory_is_one_clear_line(huge, command):
    result = CliRunner().invoke(main, [command, str(huge)])
    lines = result.output.splitlines()
    assert result.exit_code == 2 and len(lines) == 1
    assert "1.41e+05 GB, in s01b01.atmq.h5" in lines[0] and "output.max_file_gigabytes" in lines[0]
    assert not (huge.parent / "built").exists()


def test_many_small_tables_are_limited_together(tmp_path):
    states = [JOB["states"][0] | {"series": {"first": "2001-01-01", "last": "2003-09-26"}}]  # 999 days
    defaults = AtmosphereGrid()
    grid = {name: getattr(defaults, name) for name in ("elevation_deg", "source_elevation_deg", "source_azimuth_deg")}
    grid |= {"range_km": [0.1 * number for number in range(160)], "altitude_km": list(OBSERVER_HEIGHTS_KM)}
    loaded = load_job(written(tmp_path, states=states, atmosphere_grid=grid, output={"max_gigabytes": 50}))
    plan = make_plan(loaded, load_library())
    # Channels of two sources, tables of them on the five axes; a surface and its response to shade at 24 hours.
    lines = 160 * 12 * 25
    air = 300_000 + lines + 2 * lines * 13 + lines * 13 * 13
    assert plan.bytes == 999 * 4 * (2 * air + 1 + 24 * (14 + 29 + 3))
    with pytest.raises(InputError, match=r"found 77.\d GB of tables in 2,998 files.*output.max_gigabytes"):
        check_size(loaded, plan)
    loaded = load_job(written(tmp_path, states=states, atmosphere_grid=grid, output={"max_gigabytes": 200}))
    check_size(loaded, make_plan(loaded, load_library()))


def test_a_table_of_temperature_has_the_numbers_that_its_plan_counts(small_job, small_build):
    task = next(task for task in make_plan(load_job(small_job), load_library()).tasks if task.kind is Kind.TEMPERATURE)
    with h5py.File(small_build / task.files[0]) as file:
        arrays = [entry for entry in file.values() if isinstance(entry, h5py.Dataset) and entry.ndim > 1]
        size = sum(array.size for array in arrays if array.dims[0][0] == file["material"])
    assert size == task.values


def test_of_thousands_of_states_a_few_are_looked_at_and_the_check_says_so(tmp_path):
    states = [JOB["states"][0] | {"series": FIRST_TO_LAST}]
    loaded = load_job(written(tmp_path, states=states, atmosphere_grid=SMALL, sources=["moon"]))
    left_out = [item.what for item in physics_left_out(loaded)]
    assert any(f"({STATES} of 9,999 states looked at)" in what for what in left_out)


def test_a_job_text_of_a_megabyte_is_kept_with_its_file(tmp_path):
    text = "weather: [1.5, 2.5]\n" * 60_000
    write_file(tmp_path / "a.h5", Group(), Header("band", "1", text))
    with open_database(tmp_path / "a.h5", "band") as file:
        assert file.attrs["job"] == text
