"""Skies that are kept: the same again, computed anew where anything differs or the file is damaged."""

from dataclasses import fields, replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import broadband_fluxes, packaged_points
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.quantities import aureole
from skyshine.mat.scene import clear_sky as module
from skyshine.mat.scene.clear_sky import ClearLight, band_model_sky
from skyshine.schemas.kept_arrays import CACHE_VARIABLE

CONTINUUM = "mt_ckd_4.3_closure"
CONDITIONS = 250.0, 0.2, 1.0167, CONTINUUM  # m, albedo, au


@pytest.fixture(scope="module")
def air():
    return AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol("none"))


@pytest.fixture(scope="module")
def light(air):
    """Light of levels, computed for the first air that has so many."""
    computed = {}
    of = ClearLight.of

    def light_of(air, levels, *more):
        if levels.size not in computed:
            computed[levels.size] = of(air, levels, *more)
        return computed[levels.size]

    return light_of


@pytest.fixture
def computed(light, monkeypatch, tmp_path):
    """The folder of kept files, and how often light is computed."""
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    times = []
    monkeypatch.setattr(ClearLight, "of", lambda *given: times.append(1) or light(*given))
    return tmp_path / module.FOLDER, times


def same(one, other):
    return all(np.array_equal(getattr(one, each.name), getattr(other, each.name)) for each in fields(one))


def test_a_kept_sky_is_the_same(air, computed):
    _, times = computed
    first, again = (band_model_sky(air, *CONDITIONS) for _ in range(2))
    assert same(first, again) and len(times) == 1


def test_another_distance_of_the_sun_is_its_inverse_square_and_needs_no_other(air, computed):
    _, times = computed
    band_model_sky(air, *CONDITIONS)
    near = band_model_sky(air, 250.0, 0.2, 0.9833, CONTINUUM)
    exact = broadband_fluxes(air, near.altitude, near.solar_elevation, 0.2, sun_distance=0.9833)
    np.testing.assert_allclose(near.direct, exact.direct_normal, rtol=1e-12)
    np.testing.assert_allclose(near.diffuse, exact.diffuse, atol=0.4)
    assert len(times) == 1


def test_light_is_near_that_of_all_elevations_in_spherical_layers(monkeypatch, few_suns):
    """Under haze too, where a low Sun lights plane layers by 2.8 W/m2 too much."""
    hazy = AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol("rural", 4.0), surface_albedo=0.3)
    monkeypatch.setattr(module, "SUN_ELEVATIONS", few_suns[::4])
    monkeypatch.setattr(aureole, "_POINTS", 24)
    light, points = ClearLight.of(hazy, np.array([0.0, 250.0]), 0.3, CONTINUUM), packaged_points(CONTINUUM).shortwave
    exact = broadband_fluxes(hazy, light.fluxes.altitude, few_suns[::4], 0.3)
    np.testing.assert_allclose(light.fluxes.diffuse, exact.diffuse, atol=0.6)
    np.testing.assert_allclose(light.fluxes.direct_normal, exact.direct_normal, rtol=1e-12)
    few = aureole.strongest(points.weight, 24)
    lit = SpectralAir.of(hazy, points.subset(few))
    whole = aureole.SunlitSky.of(lit, points.weight[few], module.AUREOLE_ELEVATIONS)
    np.testing.assert_allclose(light.aureole, whole.aureole, atol=0.004)


@pytest.mark.parametrize("change", ["warmer", "albedo", "higher", "continuum"])
def test_anything_else_is_another_sky(air, computed, change):
    _, times = computed
    band_model_sky(air, *CONDITIONS)
    highest, albedo, *rest = CONDITIONS
    {
        "warmer": lambda: band_model_sky(replace(air, temperature=air.temperature + 1.0), *CONDITIONS),
        "albedo": lambda: band_model_sky(air, highest, albedo + 0.1, *rest),
        "higher": lambda: band_model_sky(air, highest + 300.0, albedo, *rest),
        "continuum": lambda: band_model_sky(air, *CONDITIONS[:3], "mt_ckd_4.3"),
    }[change]()
    assert len(times) == 2


def test_a_damaged_file_is_computed_again_and_an_empty_folder_keeps_nothing(air, computed, monkeypatch):
    folder, times = computed
    first = band_model_sky(air, *CONDITIONS)
    (path,) = folder.iterdir()
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))
    assert same(band_model_sky(air, *CONDITIONS), first) and len(times) == 2
    assert path.read_bytes() != bytes(content)
    monkeypatch.setenv(CACHE_VARIABLE, "")
    assert same(band_model_sky(air, *CONDITIONS), first) and len(times) == 3
