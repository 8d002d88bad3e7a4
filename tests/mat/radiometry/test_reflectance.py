"""Band values of materials: closed cases, published values, Kirchhoff's law."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.reflectance import band_emissivity, band_reflectance, solar_absorptance, thermal_emissivity
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

LWIR = SpectralResponse.rectangular(8.0, 12.0)
MWIR = SpectralResponse.rectangular(3.0, 5.0)
SPLIT_WINDOW = SpectralResponse.rectangular(8.0, 14.0)


@pytest.fixture(scope="module")
def library():
    return load_library()


@pytest.fixture(scope="module")
def ground_spectrum():
    """AM1.5 global spectrum: wavelength [um] and irradiance."""
    from pvlib.spectrum import get_reference_spectra

    table = get_reference_spectra()["global"]
    return table.index.to_numpy() / 1000.0, table.to_numpy()


def sample(wavelength, reflectance):
    reflectance = np.asarray(reflectance, dtype=float)
    return SimpleNamespace(wavelength=np.asarray(wavelength), reflectance=reflectance, absorptance=1.0 - reflectance)


def test_grey_material_is_grey_everywhere(ground_spectrum):
    grey = sample([0.3, 14.0], [0.25, 0.25])
    assert band_reflectance(grey, LWIR) == pytest.approx(0.25, rel=1e-12)
    assert band_reflectance(grey, LWIR, "planck", temperature=[10.0, 3000.0]) == pytest.approx([0.25] * 2, rel=1e-12)
    assert solar_absorptance(grey, *ground_spectrum) == pytest.approx(0.75, rel=1e-12)
    assert thermal_emissivity(grey) == pytest.approx(0.75, rel=1e-12)


def test_flat_mean_of_a_ramp_under_a_triangular_response_is_its_middle():
    """Ramp lambda - 8 under a triangle of base 8 to 10 um and apex at 9: mean 1 by symmetry, over 2."""
    ramp = sample([8.0, 10.0], [0.0, 1.0])
    assert band_reflectance(ramp, SpectralResponse([8.0, 9.0, 10.0], [0.0, 1.0, 0.0])) == pytest.approx(0.5, rel=1e-12)


def test_step_inside_a_band_is_resolved():
    step = sample([3.0, 8.999999, 9.0, 14.0], [1.0, 1.0, 0.0, 0.0])
    assert band_reflectance(step, LWIR) == pytest.approx(0.25, abs=1e-6)


def test_blackbody_share_below_10_um():
    """A mirror below 10 um absorbs the rest: 1 - F(3000 um K) = 0.7268 at 300 K; Incropera, table 12.1."""
    mirror = sample([0.3, 9.99999, 10.0, 14.0], [1.0, 1.0, 0.0, 0.0])
    assert thermal_emissivity(mirror, 300.0) == pytest.approx(1.0 - 0.273232, abs=3e-4)


def test_cold_limit_is_the_long_wave_end():
    ramp = sample([8.0, 12.0], [0.0, 1.0])
    assert band_reflectance(ramp, LWIR, "planck", temperature=1.0) == pytest.approx(1.0, abs=0.01)


def test_library_obeys_kirchhoff(library):
    for material in library:
        emissivity = band_emissivity(material, LWIR, 300.0)
        total = emissivity + band_reflectance(material, LWIR, "planck", temperature=300.0)
        assert total <= 1.0 + 1e-9
        if not material.transmits:
            assert total == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    "name, expected",
    [
        ("water_fresh", 0.985),  # 8-14 um emissivity of water near nadir: Masuda et al. 1988
        ("water_sea", 0.985),
        ("snow_fine", 0.99),  # snow near nadir: Dozier and Warren 1982
        ("grass_green", 0.98),  # closed green canopies: Rubio et al. 1997
        ("glass_window", 0.88),
    ],
)
def test_emissivities_agree_with_published_ones(library, name, expected):
    assert band_emissivity(library[name], SPLIT_WINDOW, 300.0) == pytest.approx(expected, abs=0.012)


def test_glass_is_what_the_standard_says(library, ground_spectrum):
    """EN 673: normal emissivity 0.89 of uncoated soda-lime glass; a clear 4 mm pane absorbs a tenth of sunlight."""
    glass = library["glass_window"]
    assert glass.transmits
    assert thermal_emissivity(glass, 283.0) == pytest.approx(0.89, abs=0.01)
    assert 0.08 < solar_absorptance(glass, *ground_spectrum) < 0.15


def test_clean_metals_follow_hagen_rubens(library):
    """Normal emissivity of a good conductor, 0.365 sqrt(resistivity [ohm cm] / lambda [cm]), within a factor of 2."""
    for name, resistivity in (("aluminium_polished", 2.7e-6), ("steel_polished", 9.7e-6)):
        expected = 0.365 * np.sqrt(resistivity / 10e-4)
        found = band_emissivity(library[name], LWIR, 300.0)
        assert expected / 2.0 < found < 2.0 * expected, name


@pytest.mark.shared_data
def test_solar_absorptance_and_emissivity_of_the_source_spectra(library, ground_spectrum, shared_data):
    """Values computed from the originals by another program; differences come from held ends alone."""
    compared = 0
    with open(shared_data / "spectra" / "materials.csv", encoding="utf-8") as stream:
        rows = {row["material"]: row for row in csv.DictReader(stream)}
    for material in library:
        # The panes' rows are of reflectance alone; the rest is made from other samples than those of these rows.
        others = ("glass_window", "ice_clear", "conifer", "deciduous", "grass_dry", "roof_tile_terracotta")
        sample = "asphalt_road" if material.name == "asphalt_road_new" else material.name
        if sample not in rows or material.name in (*others, "asphalt_road"):
            continue
        row = rows[sample]
        checks = (
            ("solar_absorptance_1mR_AM1.5G", solar_absorptance(material, *ground_spectrum), 0.035),
            ("emissivity_3_5um_300K", band_emissivity(material, MWIR, 300.0), 0.002),
            ("emissivity_8_14um_300K_over_available_range", band_emissivity(material, SPLIT_WINDOW, 300.0), 0.015),
        )
        for column, found, tolerance in checks:
            if row[column]:
                assert found == pytest.approx(float(row[column]), abs=tolerance), (material.name, column)
                compared += 1
    assert compared > 100


def test_solar_range_belongs_to_the_irradiance():
    ramp = sample([0.3, 2.5], [0.0, 1.0])
    assert solar_absorptance(ramp, [0.3, 0.30001], [1.0, 1.0]) == pytest.approx(1.0, abs=1e-5)
    assert solar_absorptance(ramp, [2.5, 4.0], [1.0, 1.0]) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"weighting": "plank"}, "did you mean 'planck'"),
        ({"weighting": "planck"}, "a temperature belongs"),
        ({"temperature": 300.0}, "a temperature belongs"),
        ({"weighting": "planck", "temperature": 0.0}, "above 0 K"),
        ({"weighting": "planck", "temperature": np.nan}, "above 0 K"),
        ({"weighting": "solar"}, "an irradiance belongs"),
        ({"weighting": "solar", "irradiance": ([0.3, 2.5], [1.0, 1.0])}, "0 over the whole band"),
        ({"weighting": "solar", "irradiance": ([2.5, 0.3], [1.0, 1.0])}, "strictly increasing"),
        ({"weighting": "solar", "irradiance": ([0.3, 2.5], [0.0, 0.0])}, "not 0 everywhere"),
    ],
)
def test_wrong_weightings_and_missing_inputs_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        band_reflectance(sample([0.3, 14.0], [0.1, 0.1]), LWIR, **arguments)


@pytest.mark.parametrize("response", [MWIR, LWIR])
def test_reflectance_that_errors_count_for_in_kelvin_is_that_of_nine_in_ten_materials(library, response):
    from skyshine.mat.measure.scale import REFLECTANCE

    of_all = [band_reflectance(library[name], response) for name in library.names]
    assert np.quantile(of_all, 0.9) <= REFLECTANCE
