"""Aerosol layers of a job: what the air holds of them, what files say of them, when they are computed anew."""

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.scene.atmosphere import air_key, atmospheric_state
from skyshine.mat.scene.check import check_scene
from skyshine.mat.scene.summary import state_attributes, state_summaries, summary_line
from skyshine.schemas.errors import InputError

JOB = """\
skyshine: 1
name: layers
site: {latitude_deg: 48.1, longitude_deg: 11.6, date: 2026-06-21, utc_offset_h: 2}
states:
  - profile: midlatitude_summer
    air: profile
    aerosol_optical_depth: 0.1
    aerosol_layers:
      - {model: desert, height_km: [2, 4], optical_depth: 0.3}
      - {table: smoke.csv, scale_height_km: 1.5, optical_depth: 0.05}
      - size_distribution:
          - {median_radius_um: 0.07, geometric_sd: 1.5, refractive_index: [1.45, 0.01]}
          - {median_radius_um: 0.3, geometric_sd: 1.4, number: 0.001, refractive_index: dust.csv}
        profile: lidar.csv
    weather: {air_temperature_c: [14, 27], wind_speed_m_s: 4}
bands: [{wavelength_um: [8, 12]}]
materials: [concrete]
"""
FILES = {
    "smoke.csv": (
        "wavelength[um],extinction,single_scattering_albedo,asymmetry\n0.25,9,0.9,0.7\n0.55,4,0.9,0.65\n"
        "40,0.1,0.2,0.2\n"
    ),
    "dust.csv": "wavelength[um],real,imaginary\n0.25,1.53,0.01\n10,1.8,0.5\n40,1.9,0.4\n",
    "lidar.csv": "height[km],extinction[km^-1]\n0,0.1\n1,0.1\n1.2,0\n",
}


@pytest.fixture
def written(tmp_path):
    """Write the job, with changes of its text and files, and load it."""

    def write(*changes, **files):
        text = JOB
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        for name, content in {**FILES, **files}.items():
            (tmp_path / name).write_text(content, encoding="utf-8")
        (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
        return load_job(tmp_path / "job.yaml")

    return write


def test_layers_add_to_the_optical_depth_of_the_column(written):
    job = written().trimmed
    air = atmospheric_state(job.site, job.states[0])
    layers = air.aerosols[-3:]
    assert [part.model.name for part in layers] == ["desert", "smoke.csv", "spheres"]
    # 0.1 of the column, 0.3, 0.05, and 0.11 of the lidar's profile.
    assert float(air.aerosol_optical_depth(550.0, air.surface_altitude)) == pytest.approx(0.56, abs=3e-3)
    height = air.altitude - air.surface_altitude
    assert np.all(layers[0].extinction_550[(height < 1999) | (height > 4001)] == 0)
    assert np.all(layers[2].extinction_550[height > 1211] == 0) and layers[2].extinction_550[0] == pytest.approx(1e-4)


def test_optics_by_height_are_layers_of_their_own(written):
    rows = "".join(f"{h},{w},{e},0.5,0.1\n" for h, e in ((0, 0.1), (1, 0.1), (3, 0)) for w in (0.25, 40))
    optics = "height[km],wavelength[um],extinction[km^-1],single_scattering_albedo,asymmetry\n" + rows
    replaced = ("      - {model: desert, height_km: [2, 4], optical_depth: 0.3}", "      - {optics: o.csv}")
    job = written(replaced, **{"o.csv": optics}).trimmed
    air = atmospheric_state(job.site, job.states[0])
    assert [part.model.name for part in air.aerosols[-4:]] == ["o.csv", "o.csv", "smoke.csv", "spheres"]
    assert float(air.aerosol_optical_depth(550.0, air.surface_altitude)) == pytest.approx(0.1 + 0.2 + 0.16, abs=3e-3)
    assert "aerosol optics of o.csv by height" in summary_line(state_summaries(job)[0])
    assert state_attributes(job.states[0])["aerosol_layers"].startswith("optics of o.csv by height; smoke.csv")
    other = written(replaced, **{"o.csv": optics.replace("0,0.25,0.1", "0,0.25,0.2")}).trimmed
    assert air_key(other.states[0]) != air_key(job.states[0])


def test_layers_stand_alone_without_an_aerosol(written):
    job = written(("aerosol_optical_depth: 0.1", "aerosol: none")).trimmed
    air = atmospheric_state(job.site, job.states[0])
    assert len(air.aerosols) == 3


def test_files_and_summaries_name_the_layers(written):
    job = written().trimmed
    text = state_attributes(job.states[0])["aerosol_layers"]
    assert text == (
        "desert 2 to 4 km, optical depth 0.3; smoke.csv scale height 1.5 km, optical depth 0.05; spheres by lidar.csv"
    )
    line = summary_line(state_summaries(job)[0])
    assert "aerosol desert 2 to 4 km, optical depth 0.3" in line and "aerosol spheres by lidar.csv" in line


def test_air_is_another_with_other_layers_or_files(written):
    keys = [
        air_key(job.trimmed.states[0])
        for job in (
            written(),
            written(("optical_depth: 0.3}", "optical_depth: 0.2}")),
            written(**{"dust.csv": FILES["dust.csv"].replace("0.5", "0.6")}),
            written(("wind_speed_m_s: 4", "wind_speed_m_s: 9")),  # which raises the desert's
        )
    ]
    assert len(set(keys)) == 4
    assert air_key(written().trimmed.states[0]) == keys[0]


def test_optics_that_do_not_fit_are_refused_at_their_place(written):
    rows = "".join(f"{h},{w},0.1,1.5,0.1\n" for h in (0, 1) for w in (0.25, 40))
    optics = "height[km],wavelength[um],extinction[km^-1],single_scattering_albedo,asymmetry\n" + rows
    with pytest.raises(InputError, match=r"found 1.5; allowed: 0 to 1"):
        check_scene(
            written(
                ("      - {model: desert, height_km: [2, 4], optical_depth: 0.3}", "      - {optics: o.csv}"),
                **{"o.csv": optics},
            )
        )


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("dust.csv", "1.8,", "0,", "dust.csv:3:4: found 0; allowed: above 0"),
        ("lidar.csv", "[km^-1]", "[m^-1]", "lidar.csv:1:12: found the unit 'm^-1' of extinction"),
        ("smoke.csv", "0.65", "2", "smoke.csv:3:12: found 2; allowed: between -1 and 1"),
    ],
)
def test_a_file_of_a_layer_that_does_not_fit_is_refused_at_its_place(written, name, old, new, message):
    with pytest.raises(InputError) as caught:
        check_scene(written(**{name: FILES[name].replace(old, new)}))
    assert message in str(caught.value)
