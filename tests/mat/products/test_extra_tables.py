"""Extra tables where a job asks for them: the classic files keep their bytes, values are the spectral integrals, the
report states gain and cost.
"""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import skyshine.mat
from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.budget.budget import error_budget
from skyshine.mat.budget.summary import describe
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.builder.tasks import run_task
from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import make_plan
from skyshine.mat.quantities.emission import lines_of_sight
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.lobe import normalisation
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.tables.files import BAND
from skyshine.mat.tables.pictures import draw
from skyshine.mat.tables.raw import export_raw
from skyshine.mat.tables.verify import problems
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

THERMAL = "s01b01.thermal_atmq.h5"
CLASSIC = ("s01b01.atmq.h5", "s01b01.lunar_atmq.h5", "s01.htt.h5")


@pytest.fixture(scope="module")
def thermal(extra_build):
    return skyshine.mat.open(extra_build / THERMAL)


@pytest.fixture(scope="module")
def prepared(extra_job):
    return Prepared.of(load_job(extra_job), 1, 1)


def rms(error):
    return float(np.sqrt(np.mean(np.square(error))))


def test_the_classic_files_keep_their_bytes(small_build, extra_build):
    for name in CLASSIC:
        assert (small_build / name).read_bytes() == (extra_build / name).read_bytes(), name
    assert not (small_build / THERMAL).exists()
    plain, extra = (skyshine.mat.open(folder / "b01.band.h5") for folder in (small_build, extra_build))
    assert plain.attributes["format_version"] == extra.attributes["format_version"] == BAND.format_version
    for name in plain.root.variables:
        np.testing.assert_array_equal(plain.root.variables[name].data, extra.root.variables[name].data)


def test_the_new_files_hold_and_are_in_the_catalogue(extra_build):
    for name in (THERMAL, "b01.band.h5"):
        assert problems(extra_build / name) == []
    catalog = json.loads((extra_build / "catalog.json").read_text(encoding="utf-8"))
    (entry,) = [entry for entry in catalog["files"] if entry["file"] == THERMAL]
    assert (entry["state"], entry["band"], entry["filetype"]) == (1, 1, "thermal_atmq")


def test_at_the_nodes_emission_times_transmittance_is_the_integral(extra_job, extra_build, thermal):
    """(5) over all spectral points, from (6) with the .band file's emissivity and the class's beta*."""
    job = load_job(extra_job).trimmed
    response = response_of(job.bands[0])
    points = band_points(absorption_table().points(*response.wavenumber_range), response)
    air = SpectralAir.of(atmospheric_state(job.site, job.states[0]), points.points, points.gases, points.weight)
    place = {"range": 5.0, "altitude": 1.0, "elevation": -5.0}
    (line,) = lines_of_sight(air, np.array([[5.0]]), np.array([1.0]), np.array([-5.0]))
    spectral = np.exp(-line.depth[0])
    band, library = skyshine.mat.open(extra_build / "b01.band.h5"), load_library()
    for name, number in zip(("asphalt_road", "grass_green"), range(2), strict=True):
        rho = np.interp(1e4 / points.wavenumber, library[name].wavelength, library[name].reflectance)
        through = spectral * planck_wavenumber(points.wavenumber, 325.0) * points.radiance_weight @ (1 - rho)
        beta = thermal.beta_star(material=name, temperature=325.0, **place)
        seen = band.blackbody_radiance(325.0) * (
            1 - band.value("reflectance_planck", material=name, planck_temperature=325.0)
        )
        within = thermal.root.variables["class_difference"].data[number] + 2e-4  # other quadrature of the band
        assert abs(seen * thermal.transmittance(range=5.0, beta_star=beta) / through - 1) <= 2 * within


def test_a_material_is_read_through_its_class(thermal):
    place = {"planck_temperature": 290.0, "range": 3.0, "altitude": 0.4, "elevation": -10.0}
    for name, number in zip(
        thermal.root.variables["material_name"].data, thermal.root.variables["class_of_material"].data, strict=True
    ):
        of_class = thermal.value("beta_star_thermal", material_class=number, **place)
        assert thermal.value("beta_star_thermal", material=name, **place) == of_class
    with pytest.raises(InputError, match="found the material 'asfalt_road'.*asphalt_road"):
        thermal.value("beta_star_thermal", material="asfalt_road", **place)
    with pytest.raises(InputError, match="planck_temperature: found 2000; allowed: 200 to 1000"):
        thermal.value("beta_star_thermal", material="asphalt_road", **{**place, "planck_temperature": 2000.0})
    part = thermal.part(altitude=0.4, elevation=(-12.0, -8.0), planck_temperature=290.0)
    read = part.value("beta_star_thermal", material="asphalt_road", range=3.0, elevation=-10.0)
    assert read == pytest.approx(thermal.value("beta_star_thermal", material="asphalt_road", **place), rel=1e-12)


def test_a_frame_reads_tables_on_axes_of_their_own_and_by_scattering_angle(own_axes):
    whole, draw = skyshine.mat.open(own_axes[0]), np.random.default_rng(8)
    place = {"range": draw.uniform(1, 20, 100), "elevation": draw.uniform(-20, -5, 100)}
    still = {"altitude": 0.6, "source_elevation": 22.0}
    azimuth = draw.uniform(-400, 400, 100)
    frame = whole.part(**still, elevation=(-20.0, -5.0))
    for name, extra in (
        ("beta_star", {}),
        ("ambient_radiance", {}),
        ("path_radiance_ratio", {"source_azimuth": azimuth}),
    ):
        source = {} if name == "beta_star" else {"source_elevation": 22.0}
        expected = whole.value(name, altitude=0.6, **source, **place, **extra)
        np.testing.assert_allclose(frame.value(name, **place, **extra), expected, rtol=1e-12)
    expected = whole.value("path_radiance_ratio", **still, **place, source_azimuth=70.0)
    np.testing.assert_allclose(
        whole.part(**still, elevation=(-20.0, -5.0), source_azimuth=70.0).value("path_radiance_ratio", **place),
        expected,
    )
    line = whole.part(**still, elevation=-9.0, source_azimuth=70.0)
    assert line.root.variables["path_radiance_ratio"].data.ndim == 1
    expected = whole.value("path_radiance_ratio", **still, range=place["range"], elevation=-9.0, source_azimuth=70.0)
    np.testing.assert_allclose(line.value("path_radiance_ratio", range=place["range"]), expected, rtol=1e-12)


def test_stated_errors_cover_both_what_is_read_and_what_classes_cost(thermal):
    read, materials = thermal.error("beta_star_thermal"), thermal.error("transmittance_of_materials")
    assert read["points"] > 100 and 0 < read["rms_kelvin"] < 10
    assert 0 < materials["rms"] < 0.2 and materials["maximum"] >= materials["rms"]


def test_xarray_opens_it(extra_build):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(extra_build / THERMAL, engine="h5netcdf") as data:
        assert data["beta_star_thermal"].sel(material_class=1).dims == (
            "planck_temperature",
            "range",
            "altitude",
            "elevation",
        )


def test_values_of_the_paths_that_are_read_stay_within_the_tolerance_of_classes(extra_job, thermal, tmp_path):
    file = tmp_path / "job.yaml"
    file.write_text(
        extra_job.read_text(encoding="utf-8") + "needs: {elevation_deg: [-4, 10], range_km: [2, 4]}\n", encoding="utf-8"
    )
    loaded = load_job(file)
    (task,) = [task for task in make_plan(loaded, load_library()).tasks if task.kind == "thermal"]
    run_task(task, loaded, tmp_path, ("asphalt_road", "grass_green"), True)
    less = skyshine.mat.open(tmp_path / THERMAL)
    assert less.root.variables["valid"].data.shape == (2, 2, 3)
    place = {"planck_temperature": 310.0, "range": np.linspace(2, 4, 5), "altitude": 0.6, "elevation": 3.0}
    for name in ("asphalt_road", "grass_green"):
        np.testing.assert_allclose(
            less.value("beta_star_thermal", material=name, **place),
            thermal.value("beta_star_thermal", material=name, **place),
            rtol=2e-3,
        )
    tolerance = less.root.groups["accuracy"].attributes["class_tolerance"]
    assert np.max(less.root.variables["class_difference"].data) <= tolerance


def test_it_exports_flat_and_is_queried_and_drawn(extra_build, tmp_path):
    flat = skyshine.mat.open(export_raw(extra_build / THERMAL, tmp_path))
    place = {"material": "grass_green", "planck_temperature": 301.0, "range": 2.0, "altitude": 0.2, "elevation": 0.0}
    value = float(flat.value("beta_star_thermal", **place))
    asked = [f"{axis}={number}" for axis, number in place.items()]
    result = CliRunner().invoke(
        main, ["query", str(extra_build / THERMAL), "beta_star_thermal", *asked, "--json"], standalone_mode=False
    )
    assert json.loads(result.output)["value"] == pytest.approx(value, rel=1e-6)
    draw(extra_build / THERMAL, tmp_path / "thermal.png")
    assert (tmp_path / "thermal.png").stat().st_size > 10_000


def test_normalisation_by_angle_reaches_grazing_light(small_build, extra_build):
    plain, extra = (skyshine.mat.open(folder / "b01.band.h5") for folder in (small_build, extra_build))
    (width,) = {load_library()["asphalt_road"].lobe_fwhm}
    angle = np.linspace(0.0, 89.0, 61)
    np.testing.assert_allclose(
        extra.normalisation(material="asphalt_road", angle=angle), normalisation(width, angle), rtol=3e-3
    )
    assert extra.normalisation(material="asphalt_road", angle=90.0) == 0.0
    np.testing.assert_allclose(
        plain.normalisation(material="asphalt_road", angle=[0.0, 45.0]), normalisation(width, [0.0, 45.0]), rtol=1e-6
    )
    with pytest.raises(InputError, match="source_angle: found 89; allowed: 0 to 75"):
        plain.normalisation(material="asphalt_road", angle=89.0)
    assert 0 < extra.error("normalisation_fine")["maximum"] < 0.02


def test_what_is_there_is_kept_until_the_tolerance_changes(build_inline, extra_job, extra_build, tmp_path):
    """Files of other keys are kept; the table of other classes is built again."""
    folder = shutil.copytree(extra_build, tmp_path / "built")
    loaded = load_job(extra_job)
    before = (folder / THERMAL).read_bytes()
    again = build_inline(loaded, out=folder, jobs=1)["files"]
    assert all(file["kept"] for file in again.values()) and (folder / THERMAL).read_bytes() == before
    coarse = loaded.trimmed.model_copy(
        update={"accuracy": loaded.trimmed.accuracy.model_copy(update={"class_tolerance": 0.1})}
    )
    files = build_inline(replace(loaded, trimmed=coarse), out=folder, jobs=1)["files"]
    assert [name for name, file in files.items() if not file["kept"]] == [THERMAL]
    assert skyshine.mat.open(folder / THERMAL).root.axes["material_class"].values.tolist() == [1]


def test_the_report_reads_the_stored_tables_and_counts_their_cost(prepared, extra_build):
    budget = error_budget(prepared, extra_build, load_library(), source="sun", scenes=4, seed=3)
    options = describe(budget)["options"]
    emitted = options["weighted_transmittance"]
    assert (
        emitted["basis"] == "stored tables"
        and emitted["cost"]["size"]["value"] == (extra_build / THERMAL).stat().st_size
    )
    assert emitted["cost"]["build"]["value"] > 0 and set(emitted["rms_by_material"]) == {"asphalt_road", "grass_green"}
    before, after = emitted["without_interpolation"]["rms"]["values"]
    assert after < 0.05 * before
    assert rms(budget.options["normalisation_by_angle"].after) <= 0.1 * rms(
        budget.options["normalisation_by_angle"].before
    )
    assert options["normalisation_by_angle"]["cost"]["build"]["value"] > 0
    # The tables' own interpolation is what a frame leaves, whatever the field of view.
    frame = budget.frames["frame"]
    assert np.all(frame == frame[0]) and rms(budget.frames["centre"][-1]) > rms(frame[0])
    cost = options["frame_of_the_tables"]["cost"]
    assert cost["values_per_pixel"]["value"] == 4 + 8 + 4 + 4
    assert options["profile_of_the_tables"]["cost"]["values_per_pixel"]["value"] == 4 * 2


def test_a_table_that_is_asked_for_and_missing(prepared, small_build, extra_build, tmp_path):
    with pytest.raises(InputError, match=f"holds no {THERMAL}; build the job first"):
        error_budget(prepared, small_build, load_library(), source="sun", scenes=4, seed=3)
    folder = shutil.copytree(small_build, tmp_path / "built")
    shutil.copyfile(extra_build / THERMAL, folder / THERMAL)
    with pytest.raises(
        InputError, match="b01.band.h5 lacks the normalisation_by_angle that the job asks for; build the job again"
    ):
        error_budget(prepared, folder, load_library(), source="sun", scenes=4, seed=3)
