"""`soil_moisture` of a job: what it moves, what it leaves, what it refuses."""

from dataclasses import replace

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.atmosphere import materials_digest
from skyshine.mat.scene.material_summary import material_summary
from skyshine.mat.scene.moisture import job_library, moist
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.soil_moisture import conductivity
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError


def job(**keys):
    return {
        "skyshine": 1,
        "name": "moist",
        "site": {"latitude_deg": 45, "longitude_deg": 5, "date": "2026-06-28", "utc_offset_h": 2},
        "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [14, 28]}}],
        "bands": [{"wavelength_um": [8.2, 9.2]}],
        "materials": ["soil_loam_brown", "soil_sand", "concrete"],
        **keys,
    }


def digest(**keys):
    return materials_digest(job_library(load_job(job(**keys)).trimmed), ("soil_sand", "concrete"))


@pytest.mark.validation  # 8 s
def test_wetter_soil_is_colder_at_noon_and_swings_less():
    swings, noons = [], []
    for moisture in ("dry", 0.05, "moist", 0.2):
        day = skyshine.mat.temperature("soil_sand", job=job(soil_moisture=moisture)).temperature
        swings.append(np.ptp(day))
        noons.append(day.max())
    assert np.all(np.diff(swings) < 0) and np.all(np.diff(noons) < 0)
    assert swings[0] > 45 and swings[-1] < 25


def test_sand_with_bound_water_alone_is_as_dry_as_without_the_key():
    known = skyshine.mat.temperature("soil_sand", job=job()).temperature
    for moisture in ("dry", 0.02, 0.045, 0.05):
        day = skyshine.mat.temperature("soil_sand", job=job(soil_moisture=moisture)).temperature
        assert np.abs(day - known).max() < 0.3


def test_only_soil_answers_and_without_the_key_nothing_changes():
    assert digest() == materials_digest(load_library(), ("soil_sand", "concrete"))
    assert digest() != digest(soil_moisture="moist")
    assert digest() == digest(soil_moisture={"soil_loam_brown": "wet"})
    library = job_library(load_job(job(soil_moisture="wet")).trimmed)
    for field in ("thermal", "surface", "reflectance"):
        assert np.all(getattr(library["concrete"], field) == getattr(load_library()["concrete"], field))


def test_dry_is_the_library_within_the_dry_conductivity_of_sand():
    library = load_library()
    for name, near in (("soil_loam_brown", 0.1), ("soil_sand", 1.0)):
        dry = skyshine.mat.temperature(name, job=job(soil_moisture="dry")).temperature
        assert np.abs(dry - skyshine.mat.temperature(name, job=job()).temperature).max() < near
        np.testing.assert_array_equal(moist(library[name], 0.0).reflectance, library[name].reflectance)


def test_emissivity_of_quartz_sand_rises_as_measured():
    """Mira et al. (2007): by up to 16 % in 8.2 to 9.2 um, in sand; 1.7 % at least, between dry and wet."""
    from skyshine.mat.radiometry.blackbody import SpectralResponse
    from skyshine.mat.radiometry.reflectance import band_emissivity

    sand, band = load_library()["soil_sand"], SpectralResponse.rectangular(8.2, 9.2)
    rise = band_emissivity(moist(sand, 0.4), band, 300.0) / band_emissivity(sand, band, 300.0) - 1
    assert 0.017 < rise < 0.16


def test_wet_spectra_of_the_library_are_met():
    """The library's wet sand has the quotient of a measured wet and dry beach sand: an albedo 0.126; ours of the dry
    sand is 0.15, from which a tenth of the sunlight differs at most."""
    wet = material_summary(moist(load_library()["soil_sand"], 0.4))["solar_absorptance"]
    assert wet == pytest.approx(material_summary(load_library()["sand_wet"])["solar_absorptance"], abs=0.04)


@pytest.mark.parametrize(
    ("moisture", "words"),
    [
        (0.5, "0 to 0.4, the porosity of soil_loam_brown"),
        (-0.1, "greater than or equal to 0"),
        ("damp", "'dry', 'moist' or 'wet'"),
        ({"concrete": 0.1}, "'concrete', which does not answer to soil moisture"),
        ({"soil_sand": 0.7}, "the porosity of soil_sand"),
    ],
)
def test_impossible_moisture_is_refused_at_its_place(tmp_path, moisture, words):
    import yaml

    file = tmp_path / "job.yaml"
    file.write_text(yaml.safe_dump(job(soil_moisture=moisture)))
    with pytest.raises(InputError, match=words) as refused:
        load_job(file)
    assert refused.value.line and refused.value.column


def test_check_says_what_is_changed():
    sand, _ = skyshine.mat.check(job(soil_moisture={"soil_sand": 0.1})).surfaces
    assert "soil_sand with 0.1 m3/m3" in sand and "0.3 -> 1.52 W/m/K" in sand and "131 s/m" in sand
    (ground,) = skyshine.mat.check(job()).surfaces
    assert ground.startswith("ground: ")


@pytest.mark.parametrize(("air", "frozen"), [([-12.0, -4.0], True), ([2.0, 8.0], False)])
def test_soil_freezes_by_the_state_s_air(air, frozen):
    """On the job's whole way, by its one moisture and by that of each hour."""
    winter = {
        "skyshine": 1,
        "name": "winter",
        "site": {"latitude_deg": 48, "longitude_deg": 11, "date": "2026-01-20", "utc_offset_h": 1},
        "states": [{"profile": "midlatitude_winter", "weather": {"air_temperature_c": air}}],
        "bands": [],
        "materials": ["soil_loam_brown"],
        "soil_moisture": 0.3,
    }
    loaded = load_job(winter).trimmed
    inputs = scene_inputs(loaded, 1)
    assert (inputs[1].wetting.frost > 0) == frozen
    for wetting in (inputs[1].wetting, replace(inputs[1].wetting, soil_moisture=0.3)):
        (found,) = surface_materials([job_library(loaded)["soil_loam_brown"]], wetting=wetting)
        soil = load_library()["soil_loam_brown"].soil
        assert found.thermal.layers[0].conductivity == pytest.approx(float(conductivity(soil, 0.3, frozen)))
