"""The notebooks: files with what their cells showed last; the cells run, and what they show is what is known.

The tests run the shortest; `-m validation` runs all.
"""

import json
import re
import tempfile
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest

import skyshine.mat

FOLDER = Path(__file__).parents[2] / "examples" / "notebooks"
NAMES = ("spectrum", "day_of_surfaces", "contrast_24h")


def cells_of(name):
    return json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]


def values_of(name, monkeypatch):
    """The names that the cells of a notebook leave, run in their order."""
    matplotlib.use("Agg")
    monkeypatch.setattr(plt, "show", lambda: plt.close("all"))
    names = {}
    for number, cell in enumerate(cells_of(name)):
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), f"{name}, cell {number}", "exec"), names)
    return names


def test_these_are_all_notebooks():
    assert {path.stem for path in FOLDER.iterdir()} == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_notebooks_are_of_format_4_5_with_the_results_of_a_run(name):
    """`python -m mat.maintain.notebooks` runs them; no error, no folder of a machine, no page of another size."""
    content = json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))
    assert (content["nbformat"], content["nbformat_minor"]) == (4, 5)
    ids = [cell["id"] for cell in content["cells"]]
    assert len(set(ids)) == len(ids)
    code = [cell for cell in content["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in code] == list(range(1, len(code) + 1))
    outputs = [output for cell in code for output in cell["outputs"]]
    assert {output["output_type"] for output in outputs} <= {"stream", "display_data", "execute_result"}
    figures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(figures) == sum("plt.show()" in "".join(cell["source"]) for cell in code) > 2
    text = json.dumps(outputs)
    assert len(text) < 400_000 and tempfile.gettempdir() not in text and str(Path.home()) not in text
    assert content["cells"][0]["source"][0].startswith("# ")


@pytest.mark.parametrize("name", NAMES)
def test_cells_name_what_the_package_has(name):
    """`validation` runs those of all notebooks."""
    for cell in cells_of(name):
        if cell["cell_type"] == "code":
            text = "".join(cell["source"])
            compile(text, name, "exec")
            assert all(hasattr(skyshine.mat, called) for called in re.findall(r"\bskyshine\.mat\.(\w+)\(", text))


@pytest.mark.validation  # 9 s
def test_the_spectrum_shows_the_windows_of_the_air(builds_here, monkeypatch):
    values = values_of("spectrum", monkeypatch)
    means = values["means"]
    assert max(means[4.2, 4.4], means[5.5, 7.5], means[14.0, 15.4]) < 0.02  # CO2, H2O, CO2
    assert means[10.0, 12.0] > 0.5 and means[9.4, 9.9] < 0.7 * means[8.0, 9.2]  # the window, and ozone in it
    zenith, sky = values["zenith"], values["sky"]
    opaque = np.abs(zenith.wavelength - 15.0) < 0.2
    assert sky[opaque] == pytest.approx(294.2, abs=0.7)  # the air of the profile at the ground
    window = np.abs(zenith.wavelength - 11.0) < 0.5
    assert 220 < sky[window].mean() < 265  # Sloan, Shaw and Williams (1955): a clear sky is tens of kelvin colder
    means = [values["level"][km].transmittance.mean() for km in (1, 5, 20)]
    assert means[0] > 1.5 * means[1] > 3 * means[2] > 0


def test_the_day_of_surfaces_has_its_phases(builds_here, monkeypatch):
    values = values_of("day_of_surfaces", monkeypatch)
    days, hours = values["days"], values["hours"]
    warmest = {name: hours[np.argmax(day.temperature)] for name, day in days.items()}
    noon = 12.0 + 1 / 60 * 25  # the highest Sun at 9 degrees east by a clock of one hour
    assert noon < warmest["paint_grey_on_metal"] < warmest["asphalt_road"] < 15.5
    assert days["grass_green"].temperature.max() < days["asphalt_road"].temperature.max() - 15
    coldest = {name: day.temperature.min() - 273.15 for name, day in days.items()}
    assert coldest["paint_grey_on_metal"] < 15 and coldest["grass_green"] < 15 and coldest["sand_desert"] < 15
    assert coldest["asphalt_road"] > 15
    walls = values["walls"]
    peaks = {name: wall.time[int(np.argmax(wall.temperature))] for name, wall in walls.items()}
    assert peaks["east"] < 11.5 < peaks["south"] < 15.5 < peaks["west"]
    assert walls["north"].temperature.max() == min(wall.temperature.max() for wall in walls.values())
    conduction = days["asphalt_road"].fluxes["conduction"]
    assert conduction.max() > 200 > -50 > conduction.min()  # stored by day, given back at night
    assert abs(conduction.mean()) < 0.1 * conduction.max()  # little is left over in a day that repeats


@pytest.mark.validation  # 19 s
def test_the_contrast_crosses_over_and_falls_with_range(builds_here, monkeypatch):
    values = values_of("contrast_24h", monkeypatch)
    for result in values["near"].values():
        assert 2 <= len(result.crossovers) <= 4
        assert any(6 < hour < 11 for hour in result.crossovers)  # steel and leaves cross in the morning
        assert result.contrast.max() > 5 > -1 > result.contrast.min()
    for contrasts in values["noon"].values():
        assert np.all(np.diff(contrasts) < 0) and contrasts[-1] > 0
    assert values["error"]["rms"] < 0.3
