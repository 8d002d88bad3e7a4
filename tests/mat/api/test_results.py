"""Results of the public functions: what they hold, as xarray too, and what the functions refuse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.constants import Stefan_Boltzmann

import skyshine.mat
from skyshine.mat.job.atmosphere import State
from skyshine.schemas.errors import InputError

JOB = {
    "skyshine": 1,
    "name": "one wall",
    "site": {"latitude_deg": 35, "longitude_deg": 139, "date": "2026-06-21", "utc_offset_h": 9},
    "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [18, 29]}}],
    "bands": [{"wavelength_um": [8, 8.4]}],
    "sources": ["sun"],
    "materials": ["concrete", "grass_green"],
    "atmosphere_grid": {
        "range_km": [0.01, 1],
        "altitude_km": [0.01, 0.1, 1],
        "elevation_deg": [-90, -30, -5, 0, 90],
        "source_elevation_deg": [0, 20, 45, 80],
        "source_azimuth_deg": [0, 90, 180],
    },
    "surface_grid": {"altitude_km": [0], "azimuth_deg": [180], "slope_deg": [0, 90]},
    "output": {"pictures": False},
}


@pytest.fixture(scope="module")
def built(builds_here, tmp_path_factory):
    return skyshine.mat.build(JOB, out=tmp_path_factory.mktemp("api") / "built", jobs=1)


def test_public_names_are_what_dir_shows():
    assert set(dir(skyshine.mat)) == set(skyshine.mat.__all__)
    assert all(callable(getattr(skyshine.mat, name)) for name in skyshine.mat.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'opne'"):
        _ = skyshine.mat.opne


def test_version_is_that_of_the_distribution():
    from importlib import metadata

    import skyshine

    assert skyshine.__version__ == metadata.version("skyshine")


def test_transmittance_is_the_product_of_its_parts_in_a_window():
    line = skyshine.mat.spectrum(wavenumber=(900, 1000), range=1, source="none")
    parts = np.prod(
        [*line.transmittance_by_gas.values(), line.transmittance_aerosol, line.transmittance_rayleigh], axis=0
    )
    np.testing.assert_allclose(line.transmittance, parts, rtol=5e-3)  # exact but for lines that overlap in a bin
    data = line.to_xarray()
    np.testing.assert_array_equal(data.transmittance.values, line.transmittance)
    assert data.path_thermal.attrs["units"] == "W m^-2 sr^-1 (cm^-1)^-1"
    assert float(data.sel(wavenumber=952.5).wavelength) == pytest.approx(10.4987, abs=1e-4)
    assert float(data.path_length) == 1.0 and "Spectrum 902.5 to 997.5" in repr(line)


def test_wavelength_limits_are_those_of_wavenumber():
    one = skyshine.mat.spectrum(wavelength=(10.0, 11.0), range=1, source="none")
    other = skyshine.mat.spectrum(wavenumber=(1e4 / 11, 1e3), range=1, source="none")
    np.testing.assert_array_equal(one.transmittance, other.transmittance)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "found both or neither of wavenumber"),
        ({"wavenumber": (1000, 900)}, "allowed: 0 < low < high"),
        ({"wavenumber": (900, 1000), "source": "lamp"}, "allowed: 'sun', 'moon' or 'none'"),
        ({"wavenumber": (900, 1000), "range": -1.0}, "allowed: at least 0 km"),
        ({"wavenumber": (900, 1000), "range": float("nan")}, "allowed: at least 0 km"),
        ({"wavenumber": (900, 1000), "elevation": float("inf")}, "allowed: a finite number"),
    ],
)
def test_spectrum_refuses(arguments, message):
    with pytest.raises(InputError, match=message):
        skyshine.mat.spectrum(**arguments)


def test_fluxes_of_a_day_close(built):
    day = skyshine.mat.temperature("concrete", job=JOB, slope=0)
    data = day.to_xarray()
    assert data.temperature.attrs["units"] == "K" and data.time.attrs["units"] == "h"
    assert abs(day.energy_closure) < 0.1 and "SurfaceTemperature 192 times" in repr(day)
    emitted = data.longwave_emitted / (Stefan_Boltzmann * data.temperature**4)  # the emissivity, all day the same
    assert float(emitted.max() - emitted.min()) < 1e-6 and 0.8 < float(emitted.mean()) < 1
    table = built.open("s01.htt").temperature(material="concrete", slope=0, time=data.time.values[::4])
    np.testing.assert_allclose(table, data.temperature.values[::4], atol=0.3)


def test_shade_cools_while_it_lasts_and_a_warm_wall_keeps_the_night_warm():
    sunlit, shaded = (
        skyshine.mat.temperature("concrete", job=JOB, **shade)
        for shade in ({}, {"shade": ["10:00-12:00", "12:00-14:00"]})
    )
    change, hours = shaded.temperature - sunlit.temperature, np.asarray(sunlit.time)
    assert change.max() < 1e-3 and -30 < change[np.abs(hours - 14) < 0.1].min() < -8
    walled = skyshine.mat.temperature("concrete", job=JOB, sky_view=0.4, facing=310)
    assert np.all(walled.temperature[hours < 4] > sunlit.temperature[hours < 4] + 1)


def test_bad_shade_is_refused():
    for shade, message in (("10-14", "found '10'"), ("10:00", "an interval such as"), ("09:00-09:00", "is empty")):
        with pytest.raises(InputError, match=message):
            skyshine.mat.temperature("concrete", job=JOB, shade=shade)


def test_a_day_takes_a_job_or_a_record():
    with pytest.raises(InputError, match="found both or neither of job and forcing"):
        skyshine.mat.temperature("concrete")


def test_a_band_is_that_of_the_file(built):
    computed = skyshine.mat.band((8, 8.4), materials=["grass_green", "concrete"])
    stored = built.open("b01.band")
    for name in ("reflectance", "specular_fraction"):
        ours, read = (float(table.value(name, material="grass_green")) for table in (computed, stored))
        assert ours == pytest.approx(read, rel=1e-6)
    assert computed.blackbody_radiance(300.0) == pytest.approx(float(stored.blackbody_radiance(300.0)))


def test_build_keeps_what_is_there_and_says_so(built):
    again = skyshine.mat.build(JOB, out=built.folder, jobs=1)
    assert all(entry["kept"] for entry in again.files.values()) and "3 files, 3 kept" in repr(again)


def test_check_names_what_build_writes(built):
    plan = skyshine.mat.check(JOB)
    assert sorted(plan.files) == sorted(built.files) and plan.materials == ["concrete", "grass_green"]
    assert "3 files, 2 materials" in repr(plan)


def test_plan_and_build_as_arrays(built):
    plan = skyshine.mat.check(JOB).to_xarray()
    done = built.to_xarray()
    assert set(plan.file.values) == set(done.file.values) == set(built.files)
    assert float(plan.size_before_compression.sum()) == skyshine.mat.check(JOB).bytes > 0
    assert np.isnan(plan.size_before_compression.sel(file="b01.band.h5"))  # no plan knows it
    assert float(plan.estimated_time.sum()) == pytest.approx(sum(skyshine.mat.check(JOB).seconds.values()))
    stated = built.files["s01.htt.h5"]["error_kelvin"]
    assert (
        float(done.error_maximum.sel(file="s01.htt.h5")) == stated["maximum"] >= done.error_p99.sel(file="s01.htt.h5")
    )
    assert (done.processor_time > 0).all() and done.peak_memory.units == "byte" and not done.kept.any()
    again = skyshine.mat.build(JOB, out=built.folder, jobs=1).to_xarray()
    assert (
        again.kept.all() and (again.error_maximum == done.error_maximum).sum() == np.isfinite(done.error_maximum).sum()
    )


def test_a_mapping_may_hold_numpy(built):
    grid = {name: np.asarray(nodes) for name, nodes in JOB["atmosphere_grid"].items()}
    plan = skyshine.mat.check({**JOB, "skyshine": np.int64(1), "atmosphere_grid": grid, "sources": ("sun",)})
    assert sorted(plan.files) == sorted(built.files)
    assert plan.loaded.trimmed == skyshine.mat.check(JOB).loaded.trimmed
    with pytest.raises(InputError, match=r"<mapping>: atmosphere_grid\.range_km"):
        skyshine.mat.check({**JOB, "atmosphere_grid": {**grid, "range_km": np.array([0.1, np.nan])}})


def test_a_wrong_key_of_a_mapping_is_named_by_its_path():
    wrong = {**JOB, "site": {**JOB["site"], "latitude_deg": 135}}
    with pytest.raises(InputError, match=r"<mapping>: site\.latitude_deg: found 135"):
        skyshine.mat.check(wrong)
    with pytest.raises(InputError, match="contains what YAML does not"):
        skyshine.mat.check({**JOB, "name": object()})


@pytest.mark.validation  # 6 s: a budget
def test_a_report_as_arrays(built, tmp_path):
    measured = skyshine.mat.report(JOB, built=built.folder, scenes=2)
    data = measured.to_xarray()
    assert list(data.measure.values) == ["rms", "p95", "p99", "maximum"] and data.sizes["budget"] == 1
    total = data.temperature.sel(error="all")
    assert float(total.sel(measure="rms")[0]) <= float(total.sel(measure="maximum")[0])
    number = measured.numbers["budgets"][0]["errors"]["all"]["temperature"]["rms"]["value"]
    assert float(total.sel(measure="rms")[0]) == pytest.approx(number)
    measured.write_html(tmp_path / "report.html")
    assert (tmp_path / "report.json").is_file() and "1 budgets" in repr(measured)
    with pytest.raises(InputError, match="found the band 'b07'"):
        skyshine.mat.report(JOB, built=built.folder, band="b07")


def test_carbon_dioxide_is_that_of_jobs_unless_it_is_given():
    sight = {"wavelength": (4.2, 4.4), "range": 0.05, "source": "none"}
    of_jobs = State.model_fields["co2_ppm"].default
    default, same, old = (skyshine.mat.spectrum(**sight, co2_ppm=ppm) for ppm in (None, of_jobs, 330))
    np.testing.assert_array_equal(default.transmittance, same.transmittance)
    assert np.all(default.transmittance_by_gas["CO2"] < old.transmittance_by_gas["CO2"])


def test_the_spectrum_of_a_state_is_that_of_its_air_described():
    """The same air by a job and by arguments; the Sun of 21 June stands 1.0162 au away (Astronomical Almanac)."""
    state = {
        "profile": "tropical",
        "air": "profile",
        "surface_albedo": 0.1,
        "aerosol": "urban",
        "aerosol_optical_depth": 0.3,
        "angstrom_exponent": 1.1,
        "weather": {"air_temperature_c": 26.55},
    }
    job = JOB | {"states": [JOB["states"][0], state]}
    sight = {"wavelength": (3.7, 3.8), "altitude": 0.2, "elevation": 20.0}
    of_job = skyshine.mat.spectrum(job=job, state=2, **sight)
    described = skyshine.mat.spectrum(
        profile="tropical", aerosol="urban", aerosol_optical_depth=0.3, angstrom_exponent=1.1, **sight
    )
    for name in ("transmittance", "transmittance_aerosol", "path_thermal"):
        np.testing.assert_allclose(getattr(of_job, name), getattr(described, name), rtol=1e-9)
    for name in ("path_scattered", "direct_irradiance"):
        np.testing.assert_allclose(getattr(of_job, name) * 1.0162**2, getattr(described, name), rtol=4e-4, err_msg=name)
    first = skyshine.mat.spectrum(job=job, **sight)
    assert np.all(np.abs(first.path_thermal / of_job.path_thermal - 1) > 0.02)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"job": JOB, "aerosol": "rural"}, "found job and aerosol; allowed: the air of a job's state"),
        ({"job": JOB, "clouds": [{"type": "stratus"}], "co2_ppm": 400.0}, "found job and clouds and co2_ppm"),
        ({"job": JOB, "state": 2}, "found state 2; allowed: 1 to 1"),
        ({"state": 2}, "found state 2 without a job"),
        ({"visibility_km": 23.0, "aerosol_optical_depth": 0.1}, "allowed: one of them"),
        ({"aerosol_optical_depth": float("nan")}, "aerosol_optical_depth: found nan"),
        ({"wind_speed_m_s": float("inf")}, "wind_speed_m_s: found inf"),
    ],
)
def test_spectrum_refuses_a_description_that_does_not_fit(arguments, message):
    with pytest.raises(InputError, match=message):
        skyshine.mat.spectrum(wavenumber=(900, 1000), **arguments)


def test_a_state_seen_spectrally_has_the_numbers_of_its_tables(built):
    """Transmittance of a level path of 1 km: its mean over the wavelengths of the band, at all points and at few."""
    line = skyshine.mat.spectrum(job=JOB, wavelength=(8.0, 8.4), altitude=0.1, elevation=0.0, range=1.0)
    low, high = 1e4 / 8.4, 1e4 / 8.0
    width = np.minimum(line.wavenumber + 2.5, high) - np.maximum(line.wavenumber - 2.5, low)
    weight = width / line.wavenumber**2
    table, place = built.open("s01b01.atmq"), {"range": 1.0, "altitude": 0.1, "elevation": 0.0}
    stored = table.transmittance(range=1.0, beta_star=table.value("beta_star", **place))
    assert stored == pytest.approx(np.sum(weight * line.transmittance) / weight.sum(), abs=2e-3)


def test_catalogue_to_xarray(built):
    listed = skyshine.mat.open_catalog(built.folder).to_xarray()
    assert listed.sel(file="s01.htt.h5").filetype == "htt" and int(listed.sel(file="s01.htt.h5").state) == 1
    assert int(listed.sel(file="b01.band.h5").state) == 0
