"""Sun and Moon against published irradiances."""

import numpy as np
import pytest

from mat.maintain.atmospheres import lunar as derive_lunar
from mat.maintain.atmospheres.solar import bin_means
from skyshine import atmospheres
from skyshine.mat.atmosphere.sources.lunar import disk_reflectance, lunar_irradiance, thermal_emissivity
from skyshine.mat.atmosphere.sources.lunar_thermal import disk_emission, subsolar_temperature
from skyshine.mat.atmosphere.sources.solar import ASTRONOMICAL_UNIT, solar_irradiance
from skyshine.schemas.csv_table import read_csv
from skyshine.schemas.errors import InputError

MEAN_DISTANCE = 384_400e3  # m


def mean_per_um(function, low_um, high_um):
    """Mean over a band of wavelength of an irradiance given per cm^-1."""
    edges = np.arange(5 * np.ceil(1e4 / high_um / 5), 1e4 / low_um, 5)
    return np.sum(function(edges + 2.5)) * 5 / (1e4 / edges[0] - 1e4 / (edges[-1] + 5))


class TestSun:
    def test_total_irradiance(self):
        """The solar constant, 1361 W m^-2 (Kopp and Lean 2011)."""
        infrared = np.arange(12.5, 33500, 5)
        ultraviolet = np.arange(33525.0, 49500, 50)
        far = np.arange(49750.0, 83500, 500)
        total = (
            5 * solar_irradiance(infrared).sum()
            + 50 * solar_irradiance(ultraviolet).sum()
            + 500 * solar_irradiance(far).sum()
        )
        assert total == pytest.approx(1361.0, rel=0.005)

    @pytest.mark.parametrize(
        ("low", "high", "expected", "tolerance"),
        # Means of LOWTRAN7's solar spectrum (BLOCK DATA SOLAR, Kurucz), W m^-2 (cm^-1)^-1.
        [
            (800, 1250, 2.490e-3, 0.03),
            (3680, 5000, 3.506e-2, 0.05),
            (9000, 11000, 7.285e-2, 0.02),
            (12000, 15000, 7.100e-2, 0.01),
            (16000, 19000, 5.970e-2, 0.01),
            (24000, 28000, 1.872e-2, 0.02),
        ],
    )
    def test_bands_of_lowtran7(self, low, high, expected, tolerance):
        assert solar_irradiance(np.arange(low + 2.5, high, 5)).mean() == pytest.approx(expected, rel=tolerance)

    def test_brightness_temperature_in_the_window(self):
        """The photosphere seen at 10 um is near 5,040 K (Vernazza et al. 1976), at 4 um near 5,600 K."""
        from skyshine.mat.radiometry.blackbody import planck_wavenumber

        solid_angle = np.pi * (695.7e6 / ASTRONOMICAL_UNIT) ** 2
        for wavenumber, expected in ((1002.5, 5040), (2502.5, 5600)):
            radiance = solar_irradiance(np.array([wavenumber]))[0] / solid_angle
            temperatures = np.linspace(4000, 7000, 3001)
            found = temperatures[np.argmin(np.abs(planck_wavenumber(wavenumber, temperatures) - radiance))]
            assert found == pytest.approx(expected, rel=0.04)

    @pytest.mark.parametrize(
        ("wavelength", "expected", "tolerance"),
        # Brightness temperature of the quiet Sun, K. From about 95 to 200 um it is flat at its minimum, measured from
        # balloons as 4,100 to 4,500 (reviewed by De Jager 1975, Space Sci. Rev. 17, 645). At 0.86 mm the centre of the
        # disk has 5,500 to 6,085 (Alissandrakis, Bastian and Nindos 2022, arXiv:2205.01008), at 1.3 mm 5,900 (White et
        # al. 2017, Sol. Phys. 292, 88).
        [(100.0, 4300, 0.05), (150.0, 4300, 0.05), (200.0, 4300, 0.05), (860.0, 5800, 0.06), (990.0, 5850, 0.06)],
    )
    def test_brightness_temperature_beyond_the_window(self, wavelength, expected, tolerance):
        """Rayleigh and Jeans: E = solid angle * 2 c k T nu^2, in W m^-2 (cm^-1)^-1 with nu in cm^-1."""
        solid_angle = np.pi * (695.7e6 / ASTRONOMICAL_UNIT) ** 2
        wavenumber = 1e4 / wavelength
        per_kelvin = 2 * 299792458.0 * 1.380649e-23 * (1e2 * wavenumber) ** 2 * 1e2
        temperature = solar_irradiance(np.array([wavenumber]))[0] / (solid_angle * per_kelvin)
        # To first order in h nu / k T the law reads the temperature low by h nu / 2 k.
        temperature += 0.5 * 1.438776877 * wavenumber
        assert temperature == pytest.approx(expected, rel=tolerance)

    @pytest.mark.parametrize("wavelength", [26.3, 75.0, 900.0])
    def test_inside_a_bin_beyond_25_um_irradiance_goes_with_the_square_of_wavenumber(self, wavelength):
        low = 5 * np.floor(1e4 / wavelength / 5)
        first, second = low + 1.0, low + 4.0
        ratio = solar_irradiance(second) / solar_irradiance(first)
        assert ratio == pytest.approx((second / first) ** 2, rel=1e-12)
        fine = low + 5 * (np.arange(5000) + 0.5) / 5000
        whole = solar_irradiance(np.array([low + 2.5]), 5.0)[0]
        assert solar_irradiance(fine).mean() == pytest.approx(whole, rel=1e-6)
        parts = [solar_irradiance(np.array([low + 1.25 + 2.5 * k]), 2.5)[0] for k in (0, 1)]
        assert np.mean(parts) == pytest.approx(whole, rel=1e-12) and parts[1] > parts[0]

    def test_bins_are_constant_and_ends_included(self):
        assert solar_irradiance(1000.0) == solar_irradiance(1004.999)
        assert np.all(solar_irradiance([10.0, 83500.0]) > 0)

    def test_bin_means_conserve_energy(self):
        """A spectrum linear in wavelength: its integral over a bin is known."""
        wavelength = np.linspace(0.5, 20, 3000)
        edges = np.array([510.0, 700.0, 2000.0, 19000.0])
        mean = bin_means(wavelength, 3 * wavelength, edges)
        np.testing.assert_allclose(mean * np.diff(edges), -np.diff(1.5 * (1e4 / edges) ** 2), rtol=1e-12)

    @pytest.mark.parametrize("wavenumber", [9.0, 90000.0, np.nan, -5.0])
    def test_outside_the_table(self, wavenumber):
        with pytest.raises(InputError, match="10 to 83500"):
            solar_irradiance([wavenumber])


class TestReflectedMoonlight:
    @pytest.mark.parametrize(
        ("phase", "expected"),
        # Miller and Turner 2009 at 0.555 um, 384,400 km, 1 au: mW m^-2 um^-1.
        [(10, 3.53), (30, 2.15), (60, 1.045), (90, 0.444)],
    )
    def test_against_miller_and_turner(self, phase, expected):
        value = mean_per_um(lambda nu: lunar_irradiance(nu, phase, MEAN_DISTANCE, 1.0).reflected, 0.55, 0.56)
        assert 1e3 * value == pytest.approx(expected, rel=0.10)

    @pytest.mark.parametrize(
        ("wavelength", "at_7", "at_60"),
        # Equation 10 and table 4 of Kieffer and Stone 2005 by itself: the two ends of the range, where no
        # coefficients of LIME are: the mean of the two bands of each pair, which differ by 6 and 8 %.
        [(0.35255, 0.05912, 0.01341), (2.31725, 0.26495, 0.09056)],
    )
    def test_ends_of_the_range_of_rolo(self, wavelength, at_7, at_60):
        """At the level of LIME, which is 0 to 9 % higher."""
        for phase, expected in ((7.0, at_7), (60.0, at_60)):
            assert 0.99 < disk_reflectance(np.array([wavelength]), phase)[0] / expected < 1.09

    def test_coefficients_stay_near_those_of_rolo_and_lime(self):
        """The published form at the 32 wavelengths of ROLO: bands scatter by 10 % about a smooth
        spectrum, and LIME is up to 8 % higher."""
        rolo = read_csv(atmospheres.path("sources/lunar_rolo.csv"))
        for degrees in (1.6, 5.0, 30.0, 60.0, 90.0, 97.0):
            radians = np.radians(degrees)
            logarithm = sum(rolo[f"a{i}"] * radians**i for i in range(4))
            logarithm += rolo["d1"] * np.exp(-degrees / 4.06054) + rolo["d2"] * np.exp(-degrees / 12.8802)
            logarithm += rolo["d3"] * np.cos((degrees + 30.5858) / 16.7498)
            ratio = disk_reflectance(rolo["wavelength[um]"], degrees) / np.exp(logarithm)
            assert ratio.min() > 0.92 and ratio.max() < 1.20
            assert 1.0 < np.median(ratio) < 1.05

    @pytest.mark.shared_data
    def test_level_of_lime(self, shared_data):
        """The coefficients that LIME publishes, evaluated as it states them, at phases between the surge and 75."""
        h5py = pytest.importorskip("h5py")
        with h5py.File(shared_data / "moon" / "lime_coefficients_20231120.nc") as file:
            wavelength, table = file["wavelength"][:] * 1e-3, file["coeff"][:]
        for degrees in (5.0, 7.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0):
            radians = np.radians(degrees)
            d1, d2, d3, p1, p2, p3, p4 = table[11:]
            logarithm = sum(table[i] * radians**i for i in range(4)) + d1 * np.exp(-degrees / p1)
            logarithm += d2 * np.exp(-degrees / p2) + d3 * np.cos((degrees - p3) / p4)
            np.testing.assert_allclose(disk_reflectance(wavelength, degrees), np.exp(logarithm), rtol=0.04)

    def test_opposition_surge(self):
        """Clementine: the Moon brightens by more than 40 % between 4 degrees and 0 (Buratti, Hillier and Wang 1996)."""
        full, near = (disk_reflectance(np.array([0.41, 0.555, 1.0]), phase) for phase in (0.0, 4.0))
        assert np.all(full / near > 1.33) and np.all(full / near < 1.5)

    @pytest.mark.parametrize("wavelength", [0.36, 0.555, 0.9, 2.2])
    def test_law_of_the_crescent_joins_the_fit(self, wavelength):
        """Krisciunas and Schaefer 1991: 0.026 mag a degree and 4e-9 mag a degree^4 beyond the quarter."""
        before, at, after = (disk_reflectance(np.array([wavelength]), phase)[0] for phase in (96.999, 97.0, 97.001))
        assert before == pytest.approx(at, rel=1e-4) and after == pytest.approx(at, rel=1e-4)
        crescent = disk_reflectance(np.array([wavelength]), 150.0)[0]
        magnitudes = 0.026 * (150 - 97) + 4e-9 * (150.0**4 - 97.0**4)
        assert crescent / at == pytest.approx(10 ** (-0.4 * magnitudes), rel=1e-12)

    def test_reflectance_of_rolo(self):
        """Kieffer and Stone 2005: disk reflectance at 7 degrees, 0.555 um, about 0.105, and redder at longer waves."""
        reflectance = disk_reflectance(np.array([0.44, 0.555, 0.87, 1.64]), 7.0)
        assert reflectance[1] == pytest.approx(0.105, rel=0.1)
        assert np.all(np.diff(reflectance) > 0)

    def test_waxing_and_waning(self):
        """The mare-rich trailing side makes the waning Moon darker; the default is the mean of both."""
        band = np.array([0.555])
        waxing, waning, mean = (disk_reflectance(band, 60.0, side)[0] for side in (True, False, None))
        assert waning < mean < waxing
        assert mean == pytest.approx(np.sqrt(waxing * waning))

    @pytest.mark.shared_data
    def test_packaged_tables_are_what_the_program_derives(self, shared_data, tmp_path):
        derive_lunar.main([str(shared_data / "moon"), "--out", str(tmp_path)], standalone_mode=False)
        for name in ("lunar_coefficients.csv", "lunar_shape.csv"):
            assert (tmp_path / name).read_text() == atmospheres.path(f"sources/{name}").read_text()

    @pytest.mark.shared_data
    def test_against_the_whole_of_miller_and_turner(self, shared_data):
        """Means over 0.44 to 0.72 um: half of the phases of 4 to 96 degrees within 5 %, all within 15 %; crescents to
        170 degrees within 30 %.
        """
        rows = np.loadtxt(shared_data / "moon" / "miller_turner_2009_300_750nm.csv.gz", delimiter=",", skiprows=1)
        spectra = rows[:, 1].reshape(181, 451)[:, 140:421].mean(axis=1)
        ratio = {
            g: 1e3
            * mean_per_um(lambda nu, g=g: lunar_irradiance(nu, g, MEAN_DISTANCE, 1.0).reflected, 0.44, 0.72)
            / spectra[g]
            for g in range(4, 171, 2)
        }
        fitted = np.array([abs(value - 1) for g, value in ratio.items() if g < 97])
        crescent = np.array([abs(value - 1) for g, value in ratio.items() if g >= 97])
        assert fitted.max() < 0.15 and np.median(fitted) < 0.05
        assert crescent.max() < 0.30

    def test_distances(self):
        near = lunar_irradiance([18000.0], 30.0, 360e6, 0.98)
        far = lunar_irradiance([18000.0], 30.0, 400e6, 1.02)
        assert near.reflected[0] / far.reflected[0] == pytest.approx((400 / 360 * 1.02 / 0.98) ** 2)

    def test_falls_with_phase(self):
        wavelength = np.array([0.3, 0.55, 1.0, 2.0, 4.0, 10.0])
        curve = np.array([disk_reflectance(wavelength, phase) for phase in range(0, 181, 2)])
        assert np.all(curve > 0)
        assert np.all(np.diff(curve, axis=0) <= 0)


class TestThermalMoonlight:
    def test_emissivity_joins_the_measured_reflectance_of_lunar_soil(self):
        """Kirchhoff: what the samples of the shape reflect at their last wavelength, 2.55 um (RELAB, Apollo 16), is not
        emitted there.
        """
        shape = read_csv(atmospheres.path("sources/lunar_shape.csv"))
        assert 1 - thermal_emissivity(2.55) == pytest.approx(shape["reflectance"][-1], rel=0.06)

    def test_reflected_light_of_4_um_follows_from_the_emissivity(self):
        """Kirchhoff: sunlight that is not absorbed is reflected. At 8 um (Christiansen feature: emissivity 0.99) the
        disk reflects 0.01 / 0.35 of what it does at 2.55 um.
        """
        reflectance = disk_reflectance(np.array([2.55, 4.0, 8.0]), 30.0)
        assert reflectance[2] / reflectance[0] == pytest.approx(0.01 / 0.35, rel=1e-3)
        between = 0.65 + (0.99 - 0.65) * (4.0 - 3.75) / (8.0 - 3.75)
        assert reflectance[1] / reflectance[0] == pytest.approx((1 - between) / 0.35, rel=1e-3)

    @pytest.mark.parametrize(("wavelength", "measured"), [(316.0, 353.0), (1000.0, 337.0)])
    def test_middle_of_the_full_moon_is_warmer_than_measured_where_it_is_transparent(self, wavelength, measured):
        """Pardo, Serabyn and Wiedner 2005, Icarus 178, 19: 337 K in 165 to 365 GHz, rising to 353 K at 950 GHz. Such
        waves come from below the surface, which is colder; the model knows the surface alone.
        """
        middle = float(thermal_emissivity(wavelength)) * subsolar_temperature(1.0)
        assert 1.0 < middle / measured < 1.1

    @pytest.mark.parametrize("wavelength", [30.0, 80.0, 600.0])
    def test_smooth_full_moon_beyond_25_um_is_a_sphere_in_radiative_equilibrium(self, wavelength):
        """Rayleigh and Jeans: irradiance goes with the mean temperature of the disk. With T^4 going with the cosine
        mu of incidence the mean over the disk of mu^(1/4) is 8/9, so that T = 8/9 of the subsolar 387 K.
        """
        wavenumber = np.array([1e4 / wavelength])
        full = disk_emission(wavenumber, 0.0, 1.0, rms_slope=0.01)[0]
        per_kelvin = 2 * 299792458.0 * 1.380649e-23 * (1e2 * wavenumber[0]) ** 2 * 1e2
        # Planck's law reads h nu / k T = x lower there than Rayleigh and Jeans's: by 1 - x / 2 + x^2 / 12 - x^4 / 720.
        x = 1.438776877 * wavenumber[0] / (8 / 9 * 387.0)
        temperature = full / (np.pi * per_kelvin) / (1 - x / 2 + x**2 / 12 - x**4 / 720)
        assert temperature == pytest.approx(8 / 9 * 387.0, rel=0.01)

    @pytest.mark.parametrize("phase", [0.0, 45.0, 90.0, 150.0, 180.0])
    def test_smooth_moon_against_a_picture_of_the_disk(self, phase):
        """Sum over the pixels of the disk, the equilibrium of each with the Sun, at 10 and 4 um."""
        from skyshine.mat.radiometry.blackbody import planck_wavenumber

        axis = (np.arange(600) + 0.5) / 300 - 1
        x, y = np.meshgrid(axis, axis)
        inside = x**2 + y**2 < 1
        z = np.sqrt(1 - x[inside] ** 2 - y[inside] ** 2)
        cos_incidence = np.clip(z * np.cos(np.radians(phase)) + x[inside] * np.sin(np.radians(phase)), 0, None)
        temperature = ((1361 * 0.88 * cos_incidence) / (0.95 * 5.670374e-8) + 100.0**4) ** 0.25
        result = disk_emission(np.array([1000.0, 2500.0]), phase, 1.0, rms_slope=0.01)
        for wavenumber, value in zip((1000.0, 2500.0), result, strict=True):
            assert value == pytest.approx(planck_wavenumber(wavenumber, temperature).sum() / 300**2, rel=1e-2, abs=0)

    def test_rough_moon_is_brighter_when_full_and_darker_when_half(self):
        """Lunar facets of 30 degrees: the beaming of the full Moon in all wavelengths, more in short ones; the standard
        thermal model gives asteroids eta = 0.756 (Lebofsky et al. 1986): 1.3 times a smooth sphere at 10 um.
        """
        wavenumber = 1e4 / np.array([10.0, 4.0])
        full, half = (disk_emission(wavenumber, g, 1.0) / disk_emission(wavenumber, g, 1.0, 0.01) for g in (0.0, 90.0))
        assert 1.05 < full[0] < 1.3 and full[0] < full[1]
        assert np.all(half < 1.0)

    def test_emission_falls_with_phase_and_ends_with_the_night_side(self):
        from skyshine.mat.radiometry.blackbody import planck_wavenumber

        wavenumber = np.array([700.0, 1000.0, 2500.0])
        curve = np.array([disk_emission(wavenumber, phase, 1.0) for phase in range(0, 181, 3)])
        assert np.all(np.diff(curve, axis=0) < 0)
        np.testing.assert_allclose(curve[-1], np.pi * planck_wavenumber(wavenumber, 100.0), rtol=1e-3)

    @pytest.mark.parametrize("phase", [0.0, 60.0, 130.0])
    def test_shadows_leave_the_area_of_the_disk(self, phase, monkeypatch):
        """A rough body of one temperature looks like a smooth one (Kirchhoff): here without any sunlight."""
        from skyshine.mat.atmosphere.sources import lunar_thermal
        from skyshine.mat.radiometry.blackbody import planck_wavenumber

        monkeypatch.setattr(lunar_thermal, "SOLAR_CONSTANT", 1e-12)
        result = disk_emission(np.array([500.0]), phase, 1.0)[0]
        assert result == pytest.approx(np.pi * planck_wavenumber(500.0, 100.0), rel=1e-3)

    def test_subsolar_temperature(self):
        """Noon at the lunar equator, Diviner: 380 to 400 K over the year and from highland to mare (Vasavada et al.
        2012).
        """
        assert 380 < subsolar_temperature(1.017) < subsolar_temperature(0.983) < 400

    def test_where_emission_takes_over(self):
        """Reflected sunlight leads below 3.5 um, emission beyond 4.5 um, at full and half Moon."""
        for phase in (5.0, 90.0):
            light = lunar_irradiance([1e4 / 3.0, 1e4 / 4.5, 1e3], phase, MEAN_DISTANCE, 1.0)
            assert light.reflected[0] > light.thermal[0]
            assert light.thermal[1] > light.reflected[1]
            assert light.thermal[2] > 1000 * light.reflected[2]
            np.testing.assert_array_equal(light.total, light.reflected + light.thermal)

    @pytest.mark.parametrize(("rms_slope", "lowest"), [(0.01, 0.995), (30.0, 0.93)])
    def test_total_emission_balances_sunlight(self, rms_slope, lowest):
        """Over all directions and wavelengths the Moon sends out what it takes in; from rough ground some percent are
        missing, which shadowed facets would receive from bright ones.
        """
        middle = np.arange(15.0, 5000.0, 10)
        nodes, weights = np.polynomial.legendre.leggauss(12)
        emitted = sum(
            weight * 2 * np.pi * np.sum(disk_emission(middle, float(np.degrees(np.arccos(node))), 1.0, rms_slope)) * 10
            for node, weight in zip(nodes, weights, strict=True)
        )
        absorbed = np.pi * 1361 * 0.88 / 0.95
        night = 4 * np.pi * 5.670374e-8 * 100.0**4
        assert lowest < emitted / (absorbed + night) < 1.005

    @pytest.mark.parametrize("phase", [0.0, 1.5, 97.0, 150.0, 179.9, 180.0])
    def test_all_phases_and_wavelengths_have_finite_light(self, phase):
        light = lunar_irradiance(
            1e4 / np.array([0.3, 0.35, 0.555, 1.0, 2.0, 2.4, 2.55, 4.0, 10.0, 14.0]), phase, 363e6, 1.0
        )
        assert np.all(np.isfinite(light.total)) and np.all(light.reflected > 0) and np.all(light.thermal > 0)

    @pytest.mark.parametrize(
        ("phase", "distance", "sun", "message"),
        [
            (-1.0, MEAN_DISTANCE, 1.0, "phase angle"),
            (181.0, MEAN_DISTANCE, 1.0, "phase angle"),
            (np.nan, MEAN_DISTANCE, 1.0, "phase angle"),
            (30.0, 1.0e6, 1.0, "radius"),
            (30.0, np.nan, 1.0, "radius"),
            (30.0, MEAN_DISTANCE, 0.0, "positive"),
        ],
    )
    def test_bad_input(self, phase, distance, sun, message):
        with pytest.raises(InputError, match=message):
            lunar_irradiance([1000.0], phase, distance, sun)


def test_mean_sunlight_over_wide_intervals_keeps_the_sum():
    edges = np.arange(17000.0, 33400.0, 100.0)
    fine = np.arange(17002.5, 33300.0, 5.0)
    wide = solar_irradiance(edges[:-1] + 50.0, 100.0)
    assert np.sum(wide * 100.0) == pytest.approx(np.sum(solar_irradiance(fine) * 5.0), rel=1e-9)
    np.testing.assert_allclose(solar_irradiance(fine[:50], 5.0), solar_irradiance(fine[:50]), rtol=1e-9)


def test_direct_moonlight_on_the_ground_follows_the_phase():
    """Miller and Turner 2009 at 0.555 um: 2.15 and 0.444 mW m^-2 um^-1 at phases of 30 and 90 degrees, 3.53 at 10
    degrees.
    """
    from skyshine.mat.atmosphere.band.response_points import points_of_band
    from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
    from skyshine.mat.atmosphere.state.state import AtmosphericState
    from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
    from skyshine.mat.quantities.lines_of_sight import LinesOfSight
    from skyshine.mat.radiometry.blackbody import SpectralResponse

    response = SpectralResponse.rectangular(0.55, 0.56)
    band = points_of_band(AbsorptionTable.open(), response)
    atmosphere = BandAtmosphere.of(AtmosphericState.from_profile("us_standard"), band)
    direct = []
    for phase in (10.0, 30.0, 90.0):
        light = lunar_irradiance(band.wavenumber, phase, MEAN_DISTANCE, 1.0).total
        direct.append(atmosphere.at_points(LinesOfSight(0.5, 0.5, -90.0, 40.0, 0.0), light).direct[0])
    assert np.array(direct[1:]) / direct[0] == pytest.approx(
        np.array([2.15, 0.444]) / 3.53, rel=0.15
    )  # each is within 10 %
