"""Water on leaves and on the soil below them: what is caught, what drips, what evaporates."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.scene.moisture import open_library
from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface.canopy import gap_towards
from skyshine.mat.surface.canopy_days import _film
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.film import TOLERANCE
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.weather import Wetting
from skyshine.mat.surface.wet_skin import FilmSkin
from skyshine.materials.library import load_library

STEPS = 96


def surface(name, leaf_area=None):
    library = load_library() if leaf_area is None else open_library(load_library(), ((name, leaf_area),))
    (material,) = surface_materials([library[name]], wetting=Wetting(rain=True))
    return material


@pytest.fixture
def rainy(sun_path, weather, sky):
    """Level ground and a slope; a shower of 6 mm at noon."""
    scene = Scene(sun_path, weather, sky, np.array([0.0]), np.array([0.0, 30.0]), np.array([0.0, 180.0]))
    rain = np.zeros((1, STEPS))
    rain[0, 48:52] = 6.0 / 3600.0
    return replace(scene.forcing(STEPS), rain=rain)


def solved(material, forcing):
    ((_, solution),) = solve_days(material, [lambda _: forcing], steps=STEPS, fine_steps=None)
    return solution


def test_what_exceeds_the_capacity_runs_off():
    """0.001 kg/m2/s for 1000 s into 0.4 kg/m2 without evaporation: full after 400 s, then all of it runs off."""
    supply = np.full((1, 10), 1e-3)
    film, share, drip = _film(FilmSkin(0.9, 0.9, 0.4), np.zeros((1, 10)), supply, 100.0, np.zeros(1))
    np.testing.assert_allclose(film[0], np.minimum(0.1 * np.arange(1, 11), 0.4), atol=1e-9)
    np.testing.assert_allclose(drip[0], np.where(np.arange(1, 11) > 4, 1e-3, 0.0), atol=1e-9)
    np.testing.assert_allclose(share[0], (film[0] / 0.4) ** (2 / 3), atol=1e-9)


def test_water_is_kept_evaporated_or_run_off():
    generator = np.random.default_rng(3)
    flux, supply = generator.uniform(-2e-5, 2e-4, (4, STEPS)), generator.uniform(0, 3e-4, (4, STEPS))
    film, share, drip = _film(FilmSkin(0.9, 0.9, 1.3), flux, supply, 900.0, None)
    gain, demand = supply + np.maximum(-flux, 0), np.maximum(flux, 0)
    stored = (film - np.roll(film, 1, axis=1)) / 900.0
    np.testing.assert_allclose(gain - demand * share - drip, stored, atol=1e-9)
    assert np.all((drip == 0) | (film > 1.3 - 1e-6) | (drip < 1e-9))


def test_stands_between_bare_soil_and_closed_leaves(rainy):
    """Few leaves have the temperature and film of bare wet soil, many film and cooling of the closed stand."""
    bare = solved(surface("soil_loam_brown"), rainy)
    sparse = solved(surface("shrub", 1e-5), rainy)
    np.testing.assert_allclose(sparse.temperature, bare.temperature, atol=0.1)
    np.testing.assert_allclose(sparse.film[:, STEPS:], bare.film, atol=0.03)
    closed, dense = solved(surface("shrub"), rainy), solved(surface("shrub", 20), rainy)
    pairs = ((("shrub",), closed), (("shrub", 20), dense))
    np.testing.assert_allclose(dense.film[:, :STEPS], closed.film, atol=0.1)
    none = replace(rainy, rain=0 * rainy.rain)
    cooled = [solved(surface(*of), none).temperature - wet.temperature for of, wet in pairs]
    assert cooled[1].max() > 1 and np.abs(cooled[0] - cooled[1]).max() < 1.5


def test_a_shower_wets_leaves_first_and_cools_the_stand(rainy):
    material = surface("grass_dry", 1.65)
    wet, dry = solved(material, rainy), solved(material, replace(rainy, rain=0 * rainy.rain))
    assert wet.residual.max() <= TOLERANCE and np.abs(wet.energy_closure).max() < 0.05
    after = slice(50, 60)
    assert (dry.temperature - wet.temperature)[:, after].min() > 1
    leaves, soil = wet.film[0, :STEPS], wet.film[0, STEPS:]
    # After the first quarter of an hour, 1.5 mm: through the gaps, and on the leaves by the area that they cover.
    through = float(gap_towards(1.65, 1.0))
    assert soil[48] == pytest.approx(1.5 * through, abs=0.2) and 0.8 < leaves[48] < 1.5
    assert soil.max() == pytest.approx(material.canopy.soil.film.capacity, abs=0.05)  # all that drips is enough


def test_days_before_leave_their_water(rainy):
    material = surface("grass_dry", 1.65)
    evening = replace(rainy, rain=np.roll(rainy.rain, 44, axis=1))
    none = replace(rainy, rain=0 * rainy.rain)
    ((_, after),) = solve_days(material, [lambda _: evening, lambda _: none], steps=STEPS, fine_steps=None)
    ((_, without),) = solve_days(material, [lambda _: none, lambda _: none], steps=STEPS, fine_steps=None)
    assert after.film[0, 0] > 0.5 and after.film[0, 0] > without.film[0, 0] + 0.3


def test_soil_below_dense_leaves_is_wetted_by_what_drips(rainy):
    """Through the gaps of 8 m2/m2 come 0.11 of 6 mm; the leaves keep 1.9 mm at most, the rest fills the soil's film."""
    material = surface("grass_dry", 8.0)
    assert 6.0 * float(gap_towards(8.0, 1.0)) < 0.12 < material.canopy.soil.film.capacity
    soil = solved(material, rainy).film[0, STEPS:]
    assert soil.max() == pytest.approx(material.canopy.soil.film.capacity, abs=0.05)
