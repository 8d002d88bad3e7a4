"""`mat materials fit` and `fit_material`: what is found is said, written, and taken by the other commands."""

import json

import numpy as np
import planted_skin
import pytest
import yaml
from click.testing import CliRunner

import skyshine.mat
from skyshine.mat.cli import main
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

TRUE = {"albedo": 0.3, "conductivity": 2.5}
COLUMNS = ("sw_down", "lw_down", "air_temperature", "relative_humidity", "wind_speed", "pressure")


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    weather = planted_skin.weather(5)
    _, measured = planted_skin.planted("concrete", TRUE, weather)
    noise = 0.1 * planted_skin.autoregression(weather.steps, 0.5, 1)
    lines = [",".join(["time", *COLUMNS, "surface_temperature"])]
    for index, time in enumerate(np.datetime_as_string(weather.times, unit="s")):
        numbers = [f"{weather.values[name][index]:.4f}" for name in COLUMNS]
        lines.append(
            ",".join([f"{time}Z", *numbers, f"{measured.skin[index] + noise[index]:.3f}" if index % 9 else ""])
        )
    file = tmp_path_factory.mktemp("fit") / "slab.csv"
    file.write_text("\n".join(lines) + "\n")
    return file


def run(*arguments):
    return CliRunner().invoke(main, ["materials", "fit", *map(str, arguments)])


def test_the_fitted_material_is_one_of_the_library(record, tmp_path, monkeypatch):
    """Its skin under the same record is what the fit predicted, within the steps of both."""
    free = list(TRUE)
    found = skyshine.mat.fit_material(record, "concrete", free, held_out=0.5, name="slab", out=tmp_path)
    for each in found.parameters:
        assert each.low < TRUE[each.name] < each.high
        assert each.low < each.value - each.standard_error and each.bounds[0] <= each.low
    albedo, conductivity = found.parameters
    widths = albedo.high - albedo.low, conductivity.value * np.log(conductivity.high / conductivity.low)
    errors = albedo.standard_error, conductivity.standard_error
    assert widths[0] / errors[0] == pytest.approx(widths[1] / errors[1])
    assert found.error("held out").rms < 0.3 < found.error("held out", "material as it was").rms
    assert repr(found).startswith("<MaterialFit of concrete to 43 readings: albedo 0.")
    data = found.to_xarray()
    np.testing.assert_array_equal(data.predicted.values, found.predicted)
    assert data.attrs["albedo"] == albedo.value and int(data.fitted.sum()) == int(found.fitted.sum())
    slab = load_library(tmp_path)["slab"]
    assert slab.sources["layers.1.conductivity"] == "fit to slab.csv (2026-06-02 to 2026-06-03)"
    assert slab.sources["layers.2.conductivity"].startswith("like concrete: ")
    assert slab.thermal.skin.conductivity == pytest.approx(found.values["conductivity"], rel=1e-4)
    assert "scaled to a solar absorptance" in slab.reflectance_note and "(fit to slab.csv" in slab.reflectance_note
    monkeypatch.setenv("MATERIALS_DATABASE", str(tmp_path))
    given = skyshine.mat.temperature("slab", forcing=record, absorptance=1 - found.values["albedo"])
    # The fit takes the record to repeat, the command its first day to have come before: they agree in the last 12 h.
    assert np.sqrt(np.mean((given.temperature - found.predicted)[-12:] ** 2)) < 0.03
    library = skyshine.mat.temperature("slab", forcing=record)
    assert np.abs(library.temperature - found.predicted)[-12:].max() < 0.2  # the spectrum is scaled to some thousandths
    job = tmp_path / "job.yaml"
    content = yaml.safe_load(skyshine.mat.example("starter").read_text()) | {"textures": []}
    job.write_text(yaml.safe_dump(content | {"materials": ["slab"]}))
    checked = CliRunner().invoke(main, ["check", str(job)])
    assert checked.exit_code == 0 and "slab" in checked.output, checked.output


def test_the_command_says_what_was_found(record):
    result = run(
        "--record", record, "--material", "concrete", "--free", "albedo, conductivity", "--held-out", "alternate"
    )
    assert result.exit_code == 0, result.output
    for text in (
        "equivalent to",
        "99 % from",
        "correlation",
        "W m^-1 K^-1",
        "held out",
        "material as it was",
        "day before",
    ):
        assert text in result.output
    result = run("--record", record, "--material", "concrete", "--free", "albedo", "--json")
    shown = json.loads(result.output)
    albedo = shown["parameters"]["albedo"]
    low, high = albedo["interval"]["values"]
    assert low < albedo["value"]["value"] < high and albedo["bounds"]["values"] == [0.01, 0.95]
    assert shown["confidence"] == 0.99 and shown["correlation"]["values"][0] == pytest.approx([1.0])
    assert shown["measured"]["values"][9] is None and len(shown["time"]["values"]) == 120
    rms = {(each["part"], each["prediction"], each["hours"]): each["rms"]["value"] for each in shown["errors"]}
    assert rms["held out", "fit", "all"] < rms["held out", "day before", "all"]


def test_a_material_file_starts_a_fit(record):
    file = str(skyshine.materials.__path__[0]) + "/ht/concrete.yaml"
    optical = {"absorptance": 0.6, "emissivity": 0.93}
    found = skyshine.mat.fit_material(record, file, ["conductivity"], **optical)
    assert found.parameters[0].start == 1.51 and found.written is None
    with pytest.raises(InputError, match="found a material file and a name"):
        skyshine.mat.fit_material(record, file, ["conductivity"], name="slab", **optical)


@pytest.mark.parametrize(
    "options, message",
    [
        (["--free", "albedo,speed"], "found the parameter 'speed'; allowed: albedo, emissivity, conductivity"),
        (["--free", "surface_resistance"], "surface_resistance has no effect on material 'concrete': it is dry"),
        (["--free", "albedo", "--held-out", "half"], "--held-out: found 'half'; allowed: 0 to less than 1"),
        (["--free", "albedo", "--name", "Slab!"], "allowed: lower-case letters, digits and underscores"),
        (["--free", "albedo", "--name", "granite"], "there is a material 'granite'"),
        (["--free", "albedo", "--spin-up", "3.9"], "slab.csv: found 2 measured skin temperatures in the days"),
    ],
)
def test_bad_input_ends_in_a_line(record, tmp_path, options, message):
    result = run("--record", record, "--material", "concrete", "--out", tmp_path / "own", *options)
    assert result.exit_code == 2 and message in result.output, result.output
    assert result.output.count("\n") == 1 and not (tmp_path / "own").exists()
