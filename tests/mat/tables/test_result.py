"""Results in notebooks: short text, HTML, pictures."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.tables.result import MOST_LINES, Panel, Result, line_chart
from skyshine.schemas.errors import InputError


class Days(Result):
    """Two lines, one of which falls to zero."""

    def __repr__(self):
        return "<Days 3>"

    def _panels(self):
        return [Panel([0, 1, 2], "day, d", "radiance, W", {"a": [1, 10, 0], "b": [0, 0, 0]}, logarithmic=True)]


def test_a_picture_is_shown_and_saved(tmp_path):
    chart = Days().plot()
    assert chart._repr_png_().startswith(b"\x89PNG") and chart.save(tmp_path / "days.png").stat().st_size > 1000
    (axes,) = chart.figure.axes
    (line,) = axes.get_lines()  # what is nowhere above 0 has no line on a logarithmic axis
    np.testing.assert_array_equal(line.get_ydata(), [1, 10, np.nan])
    assert axes.get_yscale() == "log" and axes.get_xlabel() == "day, d"
    with pytest.raises(InputError, match="cannot be written"):
        chart.save(tmp_path / "nowhere" / "days.png")
    with pytest.raises(InputError, match="ends in .png"):
        chart.save(tmp_path / "days.svg")


def test_upright_panels_have_their_axis_on_the_left():
    chart = line_chart([Panel([0, 5], "altitude, km", "flux, W", {"up": [3, 4]}, upright=True)], "fluxes")
    (axes,) = chart.figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("flux, W", "altitude, km")
    np.testing.assert_array_equal(axes.get_lines()[0].get_xdata(), [3, 4])


def test_many_lines_are_refused():
    lines = {str(number): [0, 1] for number in range(MOST_LINES + 1)}
    with pytest.raises(InputError, match=f"found {MOST_LINES + 1} lines"):
        line_chart([Panel([0, 1], "x", "y", lines)], "lines")


def test_html_is_that_of_xarray_or_the_text(monkeypatch):
    def without(self):
        raise InputError("needs xarray")

    monkeypatch.setattr(Days, "to_xarray", without)
    assert Days()._repr_html_() == "<pre>&lt;Days 3&gt;</pre>"


def test_a_query_is_a_dataset_over_the_axis_that_was_asked(small_build, tmp_path):
    place = {"material": "asphalt_road", "altitude": 0.5, "azimuth": 200, "slope": 20}
    answer = skyshine.mat.query(small_build / "s01.htt.h5", "temperature", time=[6.0, 13.5], **place)
    data = answer.to_xarray()
    assert data.temperature.dims == ("time",) and data.temperature.units == "K" and data.altitude.units == "km"
    assert float(data.temperature.sel(time=13.5)) == answer.value[1] and "2 values" in repr(answer)
    assert "xarray" in answer._repr_html_()
    (axes,) = answer.plot().figure.axes
    np.testing.assert_array_equal(axes.get_lines()[0].get_ydata(), answer.value)
    alone = skyshine.mat.query(small_build / "s01.htt.h5", "temperature", time=6.0, **place)
    assert alone.to_xarray().temperature.dims == () and "K, 99 % within" in repr(alone)
    with pytest.raises(InputError, match="several values of 0 axes"):
        alone.plot()
    assert skyshine.mat.open(small_build / "s01.htt.h5").plot().figure.axes


def test_results_of_functions_are_drawn():
    lines = skyshine.mat.spectrum(wavenumber=(2500, 2505), elevation=[0, 30], range=2)
    transmittance, radiance = lines.plot().figure.axes
    assert len(transmittance.get_lines()) == 2 and len(radiance.get_lines()) == 4
    upper, lower = skyshine.mat.spectrum(wavenumber=(2500, 2505), range=2).plot().figure.axes
    assert upper.get_lines()[0].get_label() == "all" and {"N2O", "aerosol"} < {x.get_label() for x in upper.get_lines()}
    assert lower.get_yscale() == "log"
    levels = skyshine.mat.fluxes(wavenumber=(2500, 2505), source="none")
    (thermal,) = levels.plot().figure.axes
    np.testing.assert_allclose(thermal.get_lines()[0].get_xdata(), levels.in_band["thermal_up"])
    np.testing.assert_allclose(thermal.get_lines()[0].get_ydata(), levels.altitude / 1e3)
