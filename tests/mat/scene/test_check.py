"""What a check accepts is built: bands at the ends of the spectrum and bands narrower than a spectral interval."""

import pytest

import skyshine.mat
from skyshine.mat.api.examples import starter_files
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.state.turbidity import typical_aerosol
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.physics import physics_left_out
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table
from skyshine.mat.scene.check import check_scene
from skyshine.mat.scene.summary import state_summaries, summary_line
from skyshine.mat.tables.verify import problems
from skyshine.schemas.errors import InputError

SLOW = pytest.mark.validation  # builds of 10 s each


def level(text):
    """A job of level faces alone, whose atmospheres take two thirds of the time."""
    assert "slope_deg: [0, 45]" in text
    return text.replace("slope_deg: [0, 45]", "slope_deg: [0]")


@pytest.mark.parametrize(
    "band",
    [
        pytest.param((26.0, 30.0), marks=SLOW),
        pytest.param((50.0, 100.0), marks=SLOW),
        pytest.param((300.0, 1000.0), marks=SLOW),
        (100.0, 100.01),
    ],
)
def test_bands_beyond_25_um_are_built_and_hold(build_inline, tmp_path, tiny_job, band):
    file = tmp_path / "job.yaml"
    text = level(tiny_job()).replace("[10.0, 10.2]", str(list(band))).replace("sources: [sun]", "sources: [moon]")
    file.write_text(text, encoding="utf-8")
    job = load_job(file)
    check_scene(job)
    build_inline(job, jobs=1)
    built = sorted(path.name for path in (tmp_path / "built").glob("*.h5"))
    assert built == ["b01.band.h5", "s01.htt.h5", "s01b01.lunar_atmq.h5"]
    assert [problem for path in (tmp_path / "built").glob("*.h5") for problem in problems(path)] == []


@pytest.mark.parametrize("lower", [0.31, 0.5, 1.0, 4.0, 10.0, 25.0, 50.0, 100.0, 300.0, 999.0])
@pytest.mark.parametrize("width", [0.01, 1e-4])
def test_points_of_a_narrow_band_weigh_as_much_as_the_band_is_wide(lower, width):
    response = SpectralResponse.rectangular(lower, lower + width)
    band = points_of_band(absorption_table(), response)
    assert band.weight.sum() == pytest.approx(width, rel=6e-3)


def test_light_measured_at_night_is_refused_by_the_check_as_by_the_build(tiny_job, tmp_path):
    """The Sun sets after 19 h on this day; 1,449 W m^-2 at 23 h are the record of another place."""
    hours = ", ".join(f"{hour:02d}:00" for hour in range(24))
    light = ", ".join(["0"] * 23 + ["1449"])
    hourly = (
        f"{{time: [{hours}], air_temperature_c: {[20] * 24}, direct_normal_w_m2: [{light}], diffuse_w_m2: {[0] * 24}}}"
    )
    text = tiny_job().replace("{air_temperature_c: [22, 33]}", f"{{radiation: measured, hourly: {hourly}}}")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(
        InputError, match=r"job.yaml:5:\d+: states.0: found 1449 W m\^-2 of direct light in the time to 23 h"
    ):
        check_scene(load_job(tmp_path / "job.yaml"))


def test_observers_far_above_the_air_that_hardly_look_at_it_are_built(build_atmosphere, tiny_job, tmp_path):
    text = level(tiny_job()).replace("altitude_km: [0.01, 1]", "altitude_km: [80000, 90000]")
    text = text.replace("[-90, 0, 90]", "[0, 90]")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    check_scene(loaded)
    assert problems(build_atmosphere(loaded, tmp_path)) == []


@pytest.mark.filterwarnings("error")
def test_particles_whose_light_has_no_bound_stay(tiny_job, tmp_path):
    """Dense haze over a white ground: a bound of 0 times infinity would read as no change at all."""
    text = tiny_job().replace("[10.0, 10.2]", "[58.29, 58.3]").replace("sources: [sun]", "sources: [moon]")
    haze = "midlatitude_summer\n    aerosol: navy_maritime\n    visibility_km: 0.256\n    surface_albedo: 1.0"
    (tmp_path / "job.yaml").write_text(text.replace("midlatitude_summer", haze), encoding="utf-8")
    left_out = physics_left_out(load_job(tmp_path / "job.yaml"))
    assert not [item for item in left_out if "particle" in item.what or "aerosol" in item.what]


@pytest.mark.parametrize(
    ("weather", "message"),
    [
        ("{air_temperature_c: 75}", "found air of 348.1 K at the ground by the weather; allowed: 140 to 335 K"),
        pytest.param("{air_temperature_c: [-120, -118]}", None, marks=SLOW),
        pytest.param("{air_temperature_c: 60, relative_humidity_percent: 0}", None, marks=SLOW),
    ],
)
def test_weather_that_the_air_cannot_have_is_refused_by_the_check_and_all_other_is_built(
    build_inline, tiny_job, tmp_path, weather, message
):
    file = tmp_path / "job.yaml"
    file.write_text(level(tiny_job()).replace("{air_temperature_c: [22, 33]}", weather), encoding="utf-8")
    loaded = load_job(file)
    if message is not None:
        with pytest.raises(InputError, match=rf"job.yaml:5:\d+: states.0: {message}"):
            check_scene(loaded)
        return
    check_scene(loaded)
    build_inline(loaded, jobs=1)
    assert [problem for path in (tmp_path / "built").glob("*.h5") for problem in problems(path)] == []


@pytest.mark.validation  # 6 s
def test_an_optical_depth_is_checked_built_and_named_in_the_files(build_inline, tiny_job, tmp_path):
    haze = "profile: midlatitude_summer\n    aerosol_optical_depth: 0.12\n    angstrom_exponent: 1.4"
    haze += "\n    aerosol_table: dust.csv"
    rows = "0.25,2,0.9,0.7\n0.55,1,0.9,0.7\n10,0.3,0.5,0.6\n40,0.1,0.3,0.3\n"
    table = "wavelength[um],extinction,single_scattering_albedo,asymmetry\n" + rows
    (tmp_path / "dust.csv").write_text(table, encoding="utf-8")
    file = tmp_path / "job.yaml"
    file.write_text(level(tiny_job()).replace("profile: midlatitude_summer", haze), encoding="utf-8")
    loaded = load_job(file)
    check_scene(loaded)
    summary = state_summaries(loaded.trimmed)[0]
    assert summary["aerosol_optical_depth_550"]["value"] == pytest.approx(0.12, rel=1e-9)
    assert "depth 0.12 at 0.55 um, optical properties of dust.csv, Angstrom exponent 1.4" in summary_line(summary)
    build_inline(loaded, jobs=1)
    paths = list((tmp_path / "built").glob("s01*.h5"))
    assert len(paths) > 1 and [problem for path in paths for problem in problems(path)] == []
    for path in paths:
        attributes = skyshine.mat.open(path).attributes
        names = ("aerosol_optical_depth_550", "angstrom_exponent", "aerosol_table")
        assert [attributes[name] for name in names] == ["0.12", "1.4", "dust.csv"]
    (tmp_path / "dust.csv").write_text(table.replace("0.5,0.6", "1.5,0.6"), encoding="utf-8")
    with pytest.raises(InputError, match="found 1.5; allowed: 0 to 1") as refused:
        check_scene(load_job(file))
    assert (refused.value.file, refused.value.line, refused.value.column) == (tmp_path / "dust.csv", 4, 8)


def test_a_typical_optical_depth_is_that_of_place_and_month_and_is_named(tiny_job, tmp_path):
    """Each state has that of its own month, once and for all in the loaded job; `mat check` says where it is from."""
    haze = "profile: midlatitude_summer\n    aerosol: opac_continental_average\n    aerosol_optical_depth: typical"
    file = tmp_path / "job.yaml"
    file.write_text(tiny_job().replace("profile: midlatitude_summer", haze), encoding="utf-8")
    loaded = load_job(file)
    site, state = loaded.trimmed.site, loaded.trimmed.states[0]
    typical = typical_aerosol(site.latitude_deg, site.longitude_deg, 1e3 * site.altitude_km, site.date)
    assert state.optical_depth == typical.optical_depth > 0
    line = summary_line(state_summaries(loaded.trimmed)[0])
    assert (
        f"optical depth {typical.optical_depth:.2g} at 0.55 um (Linke turbidity {typical.linke_turbidity:.3g} in"
        in line
    )


def test_a_typical_optical_depth_and_a_visibility_are_refused(tiny_job, tmp_path):
    haze = "profile: midlatitude_summer\n    visibility_km: 23\n    aerosol_optical_depth: typical"
    file = tmp_path / "job.yaml"
    file.write_text(tiny_job().replace("profile: midlatitude_summer", haze), encoding="utf-8")
    with pytest.raises(InputError, match="found visibility_km 23 and aerosol_optical_depth typical; allowed: one"):
        load_job(file)


def test_an_image_that_is_missing_is_named_at_its_texture(tmp_path):
    """The build would stop there: `mat check` says it before."""
    for file in starter_files():
        if file.suffix == ".yaml":
            (tmp_path / file.name).write_bytes(file.read_bytes())
    with pytest.raises(InputError, match="found 'yellowstone_road.png', which does not exist; name a file") as caught:
        check_scene(load_job(tmp_path / "job.yaml"))
    assert caught.value.line == 32
