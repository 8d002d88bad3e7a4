"""`mat spectrum`: what it prints, what it refuses, and the spectra behind it."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.mat.commands.spectrum import command
from skyshine.schemas.errors import InputError

LINE = ["--profile", "tropical", "--altitude", "0", "--elevation", "0", "--range", "5"]


def run(*arguments):
    result = CliRunner().invoke(command, [*LINE, *arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


@pytest.fixture(scope="module")
def spectrum():
    return json.loads(run("--wavenumber", "1100:1200", "--json"))


def values(entry):
    return np.array(entry["values"])


def test_spectra_name_their_quantities_and_units(spectrum):
    assert spectrum["wavenumber"]["units"] == "cm^-1"
    assert values(spectrum["wavenumber"]) == pytest.approx(np.arange(1102.5, 1200, 5))
    radiance, irradiance = "W m^-2 sr^-1 (cm^-1)^-1", "W m^-2 (cm^-1)^-1"
    expected = {"transmittance": "1", "path_thermal": radiance, "path_scattered": radiance}
    expected |= {"sky_irradiance": irradiance, "direct_irradiance": irradiance}
    for name, units in expected.items():
        assert spectrum[name]["units"] == units
        assert len(spectrum[name]["values"]) == 20
    assert {"H2O", "H2O_continuum", "CO2", "CH4"} <= set(spectrum["transmittance_by_gas"])
    assert spectrum["range"] == {"units": "km", "value": 5.0}


def test_spectra_stay_within_their_bounds(spectrum):
    total = values(spectrum["transmittance"])
    for gas in spectrum["transmittance_by_gas"].values():
        assert np.all((values(gas) >= total - 1e-9) & (values(gas) <= 1))
    for name in ("path_thermal", "path_scattered", "sky_irradiance", "direct_irradiance"):
        assert np.all(values(spectrum[name]) > 0)


def test_lines_of_csv_match_json(spectrum):
    rows = [line.split(",") for line in run("--wavenumber", "1100:1200").splitlines()]
    assert rows[0][0] == "wavenumber[cm^-1]" and rows[0][1] == "transmittance[1]"
    assert np.array([float(row[1]) for row in rows[1:]]) == pytest.approx(values(spectrum["transmittance"]), rel=1e-6)


def test_resolution_averages_intervals(spectrum):
    coarse = json.loads(run("--wavenumber", "1100:1200", "--resolution", "20", "--json"))
    assert values(coarse["wavenumber"]) == pytest.approx([1110, 1130, 1150, 1170, 1190])
    assert values(coarse["transmittance"]) == pytest.approx(
        values(spectrum["transmittance"]).reshape(5, 4).mean(axis=1)
    )


def test_wavelengths_name_the_same_spectrum(spectrum):
    same = json.loads(run("--wavelength", f"{1e4 / 1200}:{1e4 / 1100}", "--json"))
    assert same["transmittance"]["values"][1:20] == pytest.approx(spectrum["transmittance"]["values"][1:], rel=1e-9)


def test_longer_paths_transmit_less(spectrum):
    longer = json.loads(run("--range", "20", "--wavenumber", "1100:1200", "--json"))
    assert np.all(values(longer["transmittance"]) < values(spectrum["transmittance"]))
    zero = json.loads(run("--range", "0", "--wavenumber", "1100:1200", "--json"))
    assert np.all(values(zero["transmittance"]) == 1.0) and np.all(values(zero["path_thermal"]) == 0.0)


def test_a_range_ends_at_the_ground():
    found = json.loads(
        run("--altitude", "1", "--elevation", "-90", "--range", "space", "--wavenumber", "1100:1110", "--json")
    )
    assert found["ends_at_ground"] and found["range"]["value"] == pytest.approx(1.0, rel=1e-9)


def test_space_has_no_range():
    found = json.loads(
        run("--elevation", "45", "--range", "space", "--wavenumber", "1100:1110", "--source", "none", "--json")
    )
    assert found["range"]["value"] is None and not found["ends_at_ground"]
    assert np.all(values(found["path_scattered"]) == 0) and np.all(values(found["direct_irradiance"]) == 0)
    assert np.all(values(found["sky_irradiance"]) > 0)


def test_sun_outshines_moon():
    sun, moon = (json.loads(run("--wavenumber", "2500:2510", "--source", s, "--json")) for s in ("sun", "moon"))
    assert np.all(values(sun["direct_irradiance"]) > 1e4 * values(moon["direct_irradiance"]))
    assert np.all(values(moon["direct_irradiance"]) > 0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "either --wavenumber"),
        (["--wavenumber", "700:750", "--wavelength", "8:9"], "either --wavenumber"),
        (["--wavenumber", "750:700"], "LO < HI"),
        (["--wavenumber", "750"], "two numbers"),
        (["--wavenumber", "1:2"], "not covered"),
        (["--wavenumber", "1100:1200", "--resolution", "0.7"], "multiple"),
        (["--wavenumber", "1100:1200", "--resolution", "nan"], "multiple"),
        (["--wavenumber", "1100:1200", "--range", "far"], "'space'"),
        (["--wavenumber", "1100:1200", "--range", "-1"], "at least 0"),
        (["--wavenumber", "1100:1200", "--aerosol", "rurl"], "'rurl' is not one of 'rural'"),
        (["--wavenumber", "1100:1200", "--visibility-km", "0"], "0.0 is not in the range 0.1<=x<=300"),
        (["--wavenumber", "1100:1200", "--visibility-km", "nan"], "found visibility_km nan"),
        (["--wavenumber", "1100:1200", "--visibility", "5"], "Did you mean '--visibility-km'?"),
        (["--wavenumber", "1100:1200", "--clouds", "[{type"], "--clouds"),
        (["--wavenumber", "1100:1200", "--gases", "{O3: 5}"], "gases.O3: found 5"),
        (["--wavenumber", "1100:1200", "--profile", "auto"], "need a place and a date"),
        (["--wavenumber", "1100:1200", "--sounding", "nowhere.csv"], "is no file at nowhere.csv"),
        (["--wavenumber", "1100:1200", "--profile", "tropics"], "tropical"),
        (["--wavenumber", "1100:1200", "--altitude", "-1"], "is not in the range -0.5<=x"),
        (["--wavenumber", "1100:1200", "--altitude", "nan"], "finite"),
        (["--wavenumber", "1100:1200", "--elevation", "95"], "is not in the range -90<=x<=90"),
    ],
)
def test_wrong_input_is_one_clear_line(arguments, message):
    result = CliRunner().invoke(main, ["spectrum", *LINE, *arguments])
    assert result.exit_code == 2 and message in result.stderr and result.stderr.count("\n") == 1


def test_a_sounding_with_cloud_and_rain(tmp_path):
    file = tmp_path / "high.csv"
    file.write_text("altitude[m],pressure[hPa],temperature[C],dew_point[C]\n1600,835,20,10\n4000,625,4,-5\n")
    arguments = [
        "--sounding",
        str(file),
        "--elevation",
        "90",
        "--wavenumber",
        "1100:1110",
        "--source",
        "none",
        "--json",
    ]

    def look(*more):
        result = CliRunner().invoke(command, [*arguments, *more], catch_exceptions=False)
        return json.loads(result.output)

    clear, cloudy = look(), look("--clouds", "[{type: stratus}]", "--rain", "{rate_mm_h: 5}")
    black = 0.0712  # W m^-2 sr^-1 (cm^-1)^-1 at 1105 cm-1 and 293.15 K, from c1 and c2 of CODATA
    assert np.all(values(cloudy["path_thermal"]) > 0.9 * black) and np.all(values(clear["path_thermal"]) < 0.35 * black)
    assert np.all(values(cloudy["transmittance"]) < 1e-6)
    with pytest.raises(InputError, match=r"clouds\.0\.type: found 'stratos'"):
        look("--clouds", "[{type: stratos}]")
