"""The cost of wrong texels against closed forms, a black enclosure, and another ephemeris."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy import constants
from scipy.integrate import quad

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.runtime.misclassification import (
    SurfaceRadiance,
    equivalent_temperature,
    misclassification_cost,
    sun_elevation,
    surface_radiance,
)
from skyshine.mat.tables.axes import EXACT, PERIODIC, table_axis
from skyshine.mat.tables.band import TEMPERATURES, BandTable, band_radiance
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Variable

TIMES = np.arange(0.0, 24.0, 6.0)
NAMES = np.array(["asphalt_road", "grass_green"], object)
BAND = SpectralResponse([8.0, 12.0], [1.0, 1.0])
RADIANCE = "W m^-2 sr^-1"
JOB = "site: {latitude_deg: 44.95, longitude_deg: -110.54, date: '2026-07-28', utc_offset_h: -6.0, altitude_km: 2.1}\n"


def temperatures(kelvin) -> TemperatureTable:
    """Two materials with a temperature (2, T) each, on one column."""
    axes = {
        "material": table_axis(np.array([22, 68], np.int32), "1", "", interpolation=EXACT),
        "altitude": table_axis(np.array([0.0]), "km", ""),
        "azimuth": table_axis(np.array([0.0]), "degree", "", interpolation=PERIODIC, period=360.0),
        "slope": table_axis(np.array([0.0]), "degree", ""),
        "time": table_axis(TIMES, "h", "", interpolation=PERIODIC, period=24.0),
    }
    data = np.broadcast_to(np.asarray(kelvin, float), (2, 4)).reshape(2, 1, 1, 1, 4)
    variables = {
        "temperature": Variable(tuple(axes), data, "K", ""),
        "material_name": Variable(("material",), NAMES, "1", ""),
    }
    return TemperatureTable(Path("s01.htt.h5"), "htt", Group(axes, variables), {"job": JOB})


def band(reflectance) -> BandTable:
    axes = {
        "wavelength": Axis(BAND.wavelength, "um", ""),
        "temperature": table_axis(TEMPERATURES, "K", ""),
        "material": table_axis(np.array([22, 68], np.int32), "1", "", interpolation=EXACT),
    }
    variables = {
        "blackbody_radiance": Variable(("temperature",), band_radiance(BAND, TEMPERATURES), RADIANCE, ""),
        "reflectance": Variable(("material",), np.asarray(reflectance, float), "1", ""),
        "material_name": Variable(("material",), NAMES, "1", ""),
    }
    return BandTable(Path("b01.band.h5"), "band", Group(axes, variables), {})


@dataclass(frozen=True)
class Air:
    """An atmosphere whose sky has one radiance."""

    radiance: float
    attributes: dict
    path: Path = Path("s01b01.atmq.h5")

    def nodes_of(self, axis):
        return np.array([0.0, 1.0])

    def clamped(self):
        return self

    def value(self, quantity, *, source_elevation, **line):
        assert quantity == "ambient_radiance" and set(line) == {"range", "altitude", "elevation"}
        return np.full(np.shape(source_elevation), self.radiance)


def air(radiance: float, source: str = "sun", limits=(8.0, 12.0)) -> Air:
    return Air(radiance, {"source": source, "wavelength_um": limits})


def planck(kelvin: float) -> float:
    """Radiance of a black body from 8 to 12 um, by adaptive quadrature in SI units."""
    h, c, k = constants.h, constants.c, constants.k
    return quad(
        lambda x: 2 * h * c**2 / x**5 / np.expm1(h * c / (x * k * kelvin)), 8e-6, 12e-6, epsabs=0, epsrel=1e-10
    )[0]


def test_black_and_grey_surfaces():
    found = surface_radiance(temperatures([[300.0], [310.0]]), band([0.0, 0.1]), NAMES)
    assert found.radiance[:, 0] == pytest.approx([planck(300), 0.9 * planck(310)], rel=1e-5)
    assert found.equivalent[0] == pytest.approx(np.full(4, 300.0), abs=2e-3)
    assert planck(found.equivalent[1, 0]) == pytest.approx(0.9 * planck(310), rel=1e-4)


def test_in_an_enclosure_of_one_temperature_reflectance_does_not_matter():
    found = surface_radiance(temperatures([[285.0], [285.0]]), band([0.02, 0.7]), NAMES, air=air(planck(285)))
    assert found.equivalent == pytest.approx(np.full((2, 4), 285.0), abs=2e-3)


def test_equivalent_temperature_below_the_table_and_of_nothing():
    table = band([0.0, 0.0])
    assert equivalent_temperature(table, np.array([planck(140.0)]))[0] == pytest.approx(140.0, abs=0.3)
    assert equivalent_temperature(table, np.array([0.0]))[0] == 0.0


def test_summary_of_one_wrong_pair():
    surface = SurfaceRadiance(
        ("a", "b"),
        TIMES,
        np.zeros((2, 4)),
        np.array([[1.0, 1, 1, 1], [2.0, 1, 0, 5]]),
        np.array([[300.0] * 4, [310.0, 300, 290, 340]]),
    )
    confusion = np.array([[7, 96, 4], [3, 0, 100]])
    cost = misclassification_cost(confusion, surface)
    assert cost.texels == 200 and cost.unknown == 10 and len(cost.pairs) == 1
    assert cost.radiance.rms == pytest.approx(np.sqrt(0.02) * np.array([1, 0, 1, 4]))
    assert cost.radiance.mean == pytest.approx(0.02 * np.array([1, 0, -1, 4]))
    assert cost.kelvin.maximum == pytest.approx([10, 0, 10, 40]) and not cost.kelvin.p95.any()
    pair = cost.pairs[0]
    assert (pair.true, pair.found, pair.texels, pair.kelvin_maximum, pair.hour) == ("a", "b", 4, 40.0, 18.0)
    assert pair.contribution == pytest.approx(1) and pair.radiance_rms == pytest.approx(np.sqrt(18 / 4))
    worse = misclassification_cost(
        np.array([[0, 90, 10], [0, 0, 100]]), surface
    )  # 5 % of the texels: still at the 95th percentile
    assert not worse.kelvin.p95.any()
    assert misclassification_cost(np.array([[0, 89, 11], [0, 0, 100]]), surface).kelvin.p95 == pytest.approx(
        [10, 0, 10, 40]
    )


def test_no_error_where_all_is_right():
    surface = surface_radiance(temperatures([[300.0], [310.0]]), band([0.1, 0.2]), NAMES)
    cost = misclassification_cost(np.array([[0, 5, 0], [9, 0, 3]]), surface)
    assert cost.pairs == [] and cost.kelvin.day_maximum == 0 and cost.radiance.day_rms == 0
    with pytest.raises(InputError, match="no labelled texel has a material found"):
        misclassification_cost(np.array([[5, 0, 0], [9, 0, 0]]), surface)


def test_sun_of_the_clock_times():
    import pandas
    import pvlib

    times = pandas.date_range("2026-07-28", periods=24, freq="h", tz="Etc/GMT+6")
    expected = pvlib.solarposition.spa_python(times, 44.95, -110.54, 2100)["elevation"]
    assert sun_elevation(temperatures([[300.0], [300.0]]), np.arange(24.0)) == pytest.approx(
        expected.to_numpy(), abs=0.02
    )


@pytest.mark.parametrize(
    "settings, message",
    [
        ({"air": air(1.0, "moon")}, "has the source 'moon'; allowed: sun"),
        ({"air": air(1.0, limits=(3.0, 5.0))}, "is of 3-5 um; allowed: the band of b01.band.h5, 8-12 um"),
        ({"slope": 45.0}, "slope"),
    ],
)
def test_tables_that_do_not_fit(settings, message):
    with pytest.raises(InputError, match=message):
        surface_radiance(temperatures([[300.0], [300.0]]), band([0.0, 0.0]), NAMES, **settings)
    with pytest.raises(InputError, match="found the material 'tar'"):
        surface_radiance(temperatures([[300.0], [300.0]]), band([0.0, 0.0]), ["tar"])


def test_command(tmp_path):
    import json

    from click.testing import CliRunner

    from skyshine.schemas.hdf5 import Header, write_file
    from skyshine.tmm.cli import main
    from skyshine.tmm.database.levels import pure_level
    from skyshine.tmm.exchange.image import MaterialImage
    from skyshine.tmm.exchange.indexed_png import write_png

    for table, name in (
        (temperatures([[300.0], [310.0]]), "s01.htt.h5"),
        (band([0.0, 0.0]), "b01.band.h5"),
    ):
        write_file(tmp_path / name, table.root, Header(table.filetype, "1.0.0", "", JOB))
    code = np.full((10, 10), 22, np.uint16)
    code[5:] = 68
    names = {22: "asphalt_road", 68: "grass_green"}
    write_png(tmp_path, MaterialImage("found", names, pure_level(code)))
    code[0] = 68  # ten texels are truly grass
    _, legend = write_png(tmp_path, MaterialImage("truth", names, pure_level(code)))
    palette = {entry["colour"]: entry["name"] for entry in json.loads(legend.read_text())["materials"].values()}
    (tmp_path / "truth.yaml").write_text(json.dumps({"image": "truth.png", "palette": palette}))

    def run(*arguments):
        return CliRunner().invoke(main, [str(argument) for argument in arguments])

    assert run("import", tmp_path / "found.png", "--out", tmp_path).exit_code == 0
    score = ["score", tmp_path / "found.tmm.h5", tmp_path / "truth.yaml"]
    htt, b01, atmq = (tmp_path / name for name in ("s01.htt.h5", "b01.band.h5", "s01b01.atmq.h5"))
    result = run(*score, "--htt", htt, "--band", b01, "--json")
    assert result.exit_code == 0, result.output
    cost = json.loads(result.output)["radiance_cost"][0]
    assert cost["texels"] == 100 and cost["equivalent_temperature"]["day"]["rms"]["value"] == pytest.approx(
        np.sqrt(0.1) * 10, rel=1e-3
    )
    assert cost["radiance"]["day"]["maximum"]["value"] == pytest.approx(planck(310) - planck(300), rel=1e-3)
    assert [(pair["true"], pair["found"], pair["texels"]) for pair in cost["pairs"]] == [
        ("grass_green", "asphalt_road", 10)
    ]
    assert "cost of wrong texels in b01.band.h5" in run(*score, "--htt", htt, "--band", b01).output
    for options, message in (
        (["--htt", htt], "needs --htt and --band"),
        (["--htt", htt, "--band", b01, "--atmq", atmq, "--atmq", atmq], "found 2 --atmq for 1 --band"),
        (["--htt", b01, "--band", b01], "holds 'band'; allowed: 'htt'"),
        (["--htt", htt, "--band", b01, "--slope", "200"], "slope"),
    ):
        result = run(*score, *options)
        assert result.exit_code == 2 and message in result.output and result.output.count("\n") == 1, result.output
