"""Nodes that states of similar air share: the same whoever asks first, tried in each air, left where they fail."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import make_plan
from skyshine.mat.products import shared_nodes as module
from skyshine.mat.products.atmosphere import AtmosphereProduct
from skyshine.mat.products.channel_tables import SharedNodes
from skyshine.mat.products.product import Context, TaskReport
from skyshine.mat.products.shared_nodes import shared_nodes
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.materials.library import load_library
from skyshine.schemas.kept_arrays import CACHE_VARIABLE

pytestmark = pytest.mark.usefixtures("builds_here")  # nodes are placed on few lines of sight
TOLERANCE, FINE = 2.0, 0.8  # K


def day(low, high, humidity=60):
    weather = {"air_temperature_c": [low, high], "relative_humidity_percent": humidity}
    return {"profile": "midlatitude_summer", "weather": weather}


WARM, COOL, COLD = day(14, 24), day(10, 18), day(-6, 0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("kept")


@pytest.fixture
def job_of(tmp_path, folder, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(folder))
    monkeypatch.setattr(module, "_by_key", {})

    def of(*states, tolerance=TOLERANCE):
        job = {
            "skyshine": 1,
            "name": "similar days",
            "site": {"latitude_deg": 50, "longitude_deg": 10, "date": "2026-06-28", "utc_offset_h": 1},
            "states": list(states),
            "bands": [{"wavelength_um": [10.0, 10.05]}],
            "sources": ["sun"],
            "materials": ["asphalt_road"],
            "atmosphere_grid": {
                "tolerance": f"{tolerance} K",
                "range_km": [0.01, 0.1, 1, 5],
                "altitude_km": [0.002, 0.5, 1],
                "elevation_deg": [-90, -10, 0, 10, 90],
                "source_elevation_deg": [-4, 0, 10, 40],
                "source_azimuth_deg": [0, 30, 180],
            },
        }
        return load_job(job, folder=tmp_path)

    return of


def nodes_of(loaded, number):
    response, state = response_of(loaded.trimmed.bands[0]), loaded.trimmed.states[number]
    points = points_of_band(absorption_table("mt_ckd_4.3"), response)
    return shared_nodes(loaded, state, response, "sun", points)


def built(loaded, number):
    task = next(task for task in make_plan(loaded, load_library()).tasks if task.files == (f"s0{number}b01.atmq.h5",))
    report = TaskReport(task.files)
    context = Context(task, loaded.on_date_of_state(task.index), ("asphalt_road",), load_library())
    (group,) = AtmosphereProduct().compute(context, report)
    return group, report


def same(one: SharedNodes, other: SharedNodes) -> bool:
    pairs = ((getattr(one, part), getattr(other, part)) for part in ("nodes", "sources"))
    return all(np.array_equal(value, vars(b)[name]) for a, b in pairs for name, value in vars(a).items())


def test_nodes_are_the_same_from_any_state_and_from_the_kept_file(job_of, monkeypatch):
    first = nodes_of(job_of(COOL, WARM), 0)
    monkeypatch.setattr(module, "_placed", lambda *_: pytest.fail("placed again"))
    assert nodes_of(job_of(COLD, WARM, COOL), 2) is first
    monkeypatch.setattr(module, "_by_key", {})
    kept = nodes_of(job_of(WARM, COOL), 1)
    assert kept is not first and same(kept, first)


def test_a_damaged_file_is_placed_again(job_of, monkeypatch, folder):
    loaded = job_of(COOL, WARM)
    first = nodes_of(loaded, 0)
    (path,) = (folder / module.FOLDER).iterdir()
    content = bytearray(path.read_bytes())
    content[-200] ^= 1
    path.write_bytes(bytes(content))
    monkeypatch.setattr(module, "_by_key", {})
    placed = []
    monkeypatch.setattr(module, "_placed", lambda *_: placed.append(1) or first)
    again = nodes_of(loaded, 0)
    assert placed and same(again, first) and path.read_bytes() != bytes(content)


def test_a_state_alone_shares_none(job_of):
    assert nodes_of(job_of(COLD, COOL, WARM), 0) is None


def test_states_stand_on_the_same_nodes_and_hold_the_tolerance(job_of):
    loaded = job_of(COOL, WARM)
    groups = [built(loaded, number)[0] for number in (1, 2)]
    for name in ("share", "height_root", "direction"):
        assert np.array_equal(groups[0].axes[name].values, groups[1].axes[name].values)
    assert not np.array_equal(*(group.variables["thermal_ratio"].data for group in groups))
    for group in groups:
        stated = group.groups["accuracy"].variables
        assert np.max(stated["p99_kelvin"].data) <= TOLERANCE
        assert np.max(stated["maximum_kelvin"].data) <= 3 * TOLERANCE


def test_where_shared_nodes_do_not_hold_a_state_has_its_own(job_of, monkeypatch):
    """Two nodes an axis err by about 2 K: below it on one machine, above on another, as it chooses spectral points."""
    few = nodes_of(job_of(COOL, WARM), 0)  # its ends alone are taken, which are those of every tolerance
    loaded = job_of(COOL, WARM, tolerance=FINE)
    coarse = type(few.nodes)(
        **{
            name: value[[0, -1]]
            for name, value in vars(few.nodes).items()
            if name not in ("source_elevation", "scattering_angle")
        },
        source_elevation=few.nodes.source_elevation,
        scattering_angle=few.nodes.scattering_angle,
    )
    monkeypatch.setattr("skyshine.mat.products.atmosphere.shared_nodes", lambda *_: SharedNodes(coarse, few.sources))
    group, report = built(loaded, 1)
    assert "sun: nodes of similar airs exceed the tolerance" in report.notes
    assert group.axes["share"].values.size > 2
    assert np.max(group.groups["accuracy"].variables["p99_kelvin"].data) <= FINE
