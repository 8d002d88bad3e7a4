"""The program that derives the reflectance tables: optics, resampling, units, and its agreement with the package."""

import numpy as np
import pytest
from click.testing import CliRunner

from mat.maintain.materials.__main__ import compose, main
from mat.maintain.materials.optics import coated_pane, fresnel_reflectance, pane
from mat.maintain.materials.penetrating_light import laws
from mat.maintain.materials.readers import read_constants, read_ecostress, read_nist_skin
from mat.maintain.materials.recipes import Level, Recipes
from mat.maintain.materials.resample import compact_grid, fine_grid, project
from skyshine import materials
from skyshine.mat.atmosphere.sources.solar import ground_sunlight
from skyshine.mat.radiometry.levels import with_odds
from skyshine.materials.files import load_spectrum
from skyshine.materials.library import load_library
from skyshine.schemas.documents import load_model
from skyshine.schemas.errors import InputError


def test_fresnel_of_glass_and_of_a_perfect_conductor():
    assert fresnel_reflectance(np.array([1.5 + 0j]))[0] == pytest.approx(0.04)
    assert fresnel_reflectance(np.array([1.0 + 1e6j]))[0] == pytest.approx(1.0)


def test_clear_and_black_pane():
    """Without absorption a pane of face reflectance r reflects 2 r / (1 + r); an opaque one reflects r."""
    reflectance, absorptance = pane(np.array([1.5 + 0j, 1.5 + 0.1j]), np.array([0.5, 0.5]), 0.004)
    assert reflectance == pytest.approx([2 * 0.04 / 1.04, fresnel_reflectance(1.5 + 0.1j)])
    assert absorptance[0] == pytest.approx(0.0, abs=1e-12)
    assert reflectance[1] + absorptance[1] == pytest.approx(1.0)


def characteristic_matrix(index, film, thickness, wavelength):
    """Reflectance and transmittance of a film (n - ik) between media of `index` and of 1; Macleod, Thin-Film Optical
    Filters, chapter 2."""
    phase = 2 * np.pi * film * thickness / wavelength
    matrix = np.array([[np.cos(phase), 1j * np.sin(phase) / film], [1j * film * np.sin(phase), np.cos(phase)]])
    sent, taken = matrix @ [1, 1]
    return abs((index * sent - taken) / (index * sent + taken)) ** 2, 4 * index / abs(index * sent + taken) ** 2


@pytest.mark.parametrize("film", [1.38 + 0j, 0.13 + 4.0j, 2.0 + 0.5j])
def test_coated_pane_is_that_of_the_characteristic_matrix(film):
    """Glass that absorbs a little; the series of reflections between the faces is summed by hand."""
    glass, wavelength, thick = np.array([1.5 + 1e-5j]), np.array([0.6]), 12e-9
    inside = np.exp(-4 * np.pi * 1e-5 * 0.004 / 0.6e-6)
    reflected, passed = characteristic_matrix(1.5, film.conjugate(), thick, 0.6e-6)
    face = 0.04
    order = (face * reflected * inside**2) ** np.arange(60)
    reflectance = face + (1 - face) ** 2 * inside**2 * reflected * order.sum()
    transmittance = (1 - face) * inside * passed * order.sum()
    found = coated_pane(glass, np.array([film]), wavelength, 0.004, thick)
    assert [float(value[0]) for value in found] == pytest.approx(
        [reflectance, 1 - reflectance - transmittance], abs=1e-9
    )


def test_film_without_thickness_leaves_the_pane_as_it_is():
    index, wavelength = np.array([1.5 + 1e-6j, 1.46 + 1e-3j]), np.array([0.6, 4.4])
    bare = pane(index, wavelength, 0.004)
    coated = coated_pane(index, np.array([0.1 + 4j, 3 + 30j]), wavelength, 0.004, 0.0)
    assert np.array(coated) == pytest.approx(np.array(bare), abs=1e-6)


def test_lightest_and_darkest_subjects_are_told_apart(tmp_path):
    """Subject n reflects n hundredths; its second reading, which is wrong, is in no mean that is read."""
    file = tmp_path / "skin.csv"
    rows = [
        ",".join([str(nm), *(f"{n / 100},0.9,{n / 100},{n / 100}" for n in range(1, 41))]) for nm in (400, 550, 700)
    ]
    file.write_text("There are 3 spectra\nWavelength (nm),R1,R2,R3,Average\n" + "\n".join(rows) + "\n")
    for sample, mean in (("", 0.205), ("darkest", 0.025), ("lightest", 0.385)):
        wavelength, value = read_nist_skin(file, sample)
        assert list(wavelength) == [0.4, 0.55, 0.7] and value == pytest.approx(mean)


def grey(value):
    return {
        "sample": "grey",
        "pieces": [{"source": "literature", "range": [0.3, 15], "kind": "constant", "value": value}],
    }


def test_mixture_is_the_mean_by_area_and_cites_its_parts(tmp_path):
    parts = {"bright": grey(0.8), "dark": grey(0.2)}
    both = {
        "mix": {"sample": "m", "mixture": {"bright": 0.25, "dark": 0.75}},
        "same": {"sample": "s", "like": "bright"},
    }
    recipes = Recipes.model_validate({"citations": {"literature": "values"}, "recipes": parts | both})
    _, reflectance, absorptance, stretches = compose(recipes, "mix", tmp_path)
    assert reflectance == pytest.approx(0.35) and absorptance == pytest.approx(0.65)
    assert stretches == [(0.3, 15.0, "modelled", "by area 0.25 of bright and 0.75 of dark")]
    assert recipes.sources_of("mix") == ["literature"]
    assert compose(recipes, "same", tmp_path)[1] == pytest.approx(0.8)


@pytest.mark.parametrize(
    "recipe, message",
    [
        ({"mixture": {"bright": 0.5, "dark": 0.4}}, "shares with a sum of 0.9"),
        ({"mixture": {"bright": 0.5, "white": 0.5}}, "found white in mix"),
        ({"like": "same"}, "found same in mix; allowed: recipes with a spectrum of their own"),
        ({}, "one of 'pieces', 'mixture' and 'like'"),
        ({"like": "dark", "mixture": {"bright": 0.5, "dark": 0.5}}, "one of 'pieces', 'mixture' and 'like'"),
    ],
)
def test_recipe_of_no_clear_origin_is_refused(recipe, message):
    known = {"bright": grey(0.8), "dark": grey(0.2), "same": {"sample": "s", "like": "dark"}}
    with pytest.raises(ValueError, match=message):
        Recipes.model_validate({"citations": {}, "recipes": known | {"mix": {"sample": "m", **recipe}}})


def test_projection_keeps_what_it_can_hold_and_the_integral_of_what_it_cannot():
    nodes, fine = compact_grid(0.3, 15.0), fine_grid(0.3, 15.0)
    assert project(fine, 0.2 + 0.01 * fine, nodes) == pytest.approx(0.2 + 0.01 * nodes, abs=1e-6)
    rough = 0.5 + 0.3 * np.sin(20.0 * fine) * np.exp(-((fine - 7.0) ** 2))
    compact = project(fine, rough, nodes)
    assert np.trapezoid(np.interp(fine, nodes, compact), fine) == pytest.approx(np.trapezoid(rough, fine), rel=1e-7)


def test_grid_is_compact_and_reaches_its_ends():
    for upper, most in ((15.0, 400), (50.0, 450)):
        nodes = compact_grid(0.3, upper)
        assert nodes[0] == 0.3 and nodes[-1] == upper and len(nodes) < most and np.all(np.diff(nodes) > 0.0)


@pytest.mark.parametrize("unit, scale", [("fraction", 1.0), ("percent", 100.0)])
def test_unit_of_a_library_file_is_checked(tmp_path, unit, scale):
    file = tmp_path / "sample.txt"
    rows = "\n".join(f"{14.0 - 0.1 * n:.3f}  {0.4 * scale:.3f}" for n in range(50))
    file.write_text(f"Name: sample\nFirst X Value: 14.0\nY Units: Reflectance (percent)\n\n{rows}\n")
    wavelength, value = read_ecostress(file, unit)
    assert np.all(np.diff(wavelength) > 0.0) and value == pytest.approx(0.4)
    with pytest.raises(InputError, match=f"which are {unit}; the recipe says"):
        read_ecostress(file, "percent" if unit == "fraction" else "fraction")


def test_dispersion_formula(tmp_path):
    file = tmp_path / "glass.yml"
    file.write_text(
        "DATA:\n  - type: formula 5\n    wavelength_range: 0.3 4.6\n    coefficients: 1.5 -0.003 2 0.004 -2\n"
        "  - type: tabulated k\n    data: |\n        0.5 1E-6\n        2.0 2E-6\n"
    )
    wavelength, index = read_constants(file)
    assert list(wavelength) == [0.5, 2.0]
    assert index == pytest.approx([1.5 - 0.003 * 0.25 + 0.004 / 0.25 + 1e-6j, 1.5 - 0.003 * 4 + 0.004 / 4 + 2e-6j])


def test_each_material_has_a_recipe_with_citations():
    recipes = load_model(materials.path("ref/recipes.yaml"), Recipes)
    assert set(recipes.recipes) == {file.stem for file in materials.path("ref").glob("*.csv")}
    for name in recipes.recipes:
        assert set(recipes.sources_of(name)) <= set(recipes.citations)


@pytest.mark.shared_data
def test_packaged_tables_are_those_that_the_program_derives(tmp_path, shared_data):
    names = ["concrete", "limestone", "brick_red", "glass_window", "soil_loam_wet", "water_sea", "skin_human"]
    names += ["conifer", "galvanised_new", "armour_aluminium_tan", "stubble"]
    result = CliRunner().invoke(main, [str(shared_data / "spectra"), *names, "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    for name in names:
        derived, packaged = load_spectrum(tmp_path / f"{name}.csv"), load_spectrum(materials.path(f"ref/{name}.csv"))
        assert derived.reflectance == pytest.approx(packaged.reflectance, abs=2e-5)
        assert derived.ranges == packaged.ranges


def test_light_that_a_structure_returns_to_its_elements_is_summed():
    """A geometric series: with probability p each reflection meets the structure again, else it leaves."""
    reflectance, again = np.array([0.0, 0.3, 0.8, 1.0]), 0.6
    orders = np.arange(400)[:, None]
    series = ((1.0 - again) * reflectance * (again * reflectance) ** orders).sum(axis=0)
    assert with_odds(reflectance, 1.0 - again) == pytest.approx(series, rel=1e-9)


@pytest.mark.parametrize("over, lower, upper", [("sunlight", 0.3, 2.5), ("300 K", 2.6, 50.0)])
@pytest.mark.parametrize("absorptance", [0.02, 0.5, 0.98])
def test_level_brings_the_mean_to_its_number(over, lower, upper, absorptance):
    wavelength = np.geomspace(lower, upper, 4000)
    sample = 0.4 + 0.2 * np.sin(6.0 * np.log(wavelength))
    factor = Level(over=over, absorptance=absorptance, source="test").factor(wavelength, sample)
    scaled = with_odds(sample, factor)
    weight = (
        np.interp(wavelength, *ground_sunlight())
        if over == "sunlight"
        else wavelength**-5 / (np.exp(14387.77 / (300.0 * wavelength)) - 1.0)
    )
    found = 1.0 - np.trapezoid(scaled * weight, wavelength) / np.trapezoid(weight, wavelength)
    assert found == pytest.approx(absorptance, abs=1e-3)
    assert np.all((scaled >= 0.0) & (scaled <= 1.0)) and np.array_equal(np.argsort(scaled), np.argsort(sample))


def test_level_that_no_scaling_reaches_is_refused():
    with pytest.raises(InputError, match="no scaling of the sample gives an absorptance of 0.3"):
        Level(over="sunlight", absorptance=0.3, source="test").factor(np.array([0.4, 0.5, 0.6]), np.zeros(3))


@pytest.mark.shared_data
def test_light_in_clear_ice_is_that_which_the_program_derives(shared_data):
    shares, extinctions, largest = laws(shared_data / "spectra" / "rii_nk" / "H2O__Warren-2008.yml")
    stored = load_library()["ice_clear"].thermal.light
    assert [part.share for part in stored] == pytest.approx(list(shares), abs=0.001)
    assert [part.extinction for part in stored] == pytest.approx(list(extinctions), rel=0.005)
    assert largest < 0.01
