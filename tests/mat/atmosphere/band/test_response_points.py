"""Points of a band for its own response, against line-by-line spectra of the fine table on paths that nothing saw."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band import response_points
from skyshine.mat.atmosphere.band.points import band_points, micron_response
from skyshine.mat.atmosphere.band.response_points import _another, _Cells, _within_cells, points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.radiometry.blackbody import SpectralResponse

TABLE = AbsorptionTable.open()


def own_spectrum(low, high):
    """Mean transmittances of the judging paths over the cells of [low, high] cm-1, cut at its very ends."""
    reference = TABLE.fine.reference_spectra(low - 1, high + 1)
    width = np.diff(reference.cell[:2])[0]
    share = np.clip(np.minimum(reference.cell + width / 2, high) - np.maximum(reference.cell - width / 2, low), 0, None)
    rows = ~reference.fitted & ~reference.emission
    return reference, rows, reference.value[rows] @ share / share.sum()


@pytest.mark.parametrize("low, high", [(1136.3, 1149.4), (768.0, 769.2), (2130.6, 2171.0), (3003.3, 3021.7)])
def test_a_narrow_band_has_the_transmittance_of_its_own_lines(low, high):
    response = SpectralResponse.rectangular(1e4 / high, 1e4 / low)
    reference, rows, truth = own_spectrum(low, high)
    band = points_of_band(TABLE, response)
    values = reference.at_points(band.points, fitted=False)[~reference.emission[~reference.fitted]]
    error = values @ band.weight / band.weight.sum() - truth
    assert rows.sum() == error.size and np.sqrt(np.mean(error**2)) < 0.003, error
    assert band.weight.sum() == pytest.approx(1e4 / low - 1e4 / high, rel=1e-6)
    # The statement weights wavelengths of the band alike, not wavenumbers.
    fitted = reference.fitted & ~reference.emission
    mean = reference.at_points(band.points, fitted=True)[~reference.emission[reference.fitted]] @ band.weight
    cells = np.clip(reference.cell + 0.0625, low, high) - np.clip(reference.cell - 0.0625, low, high)
    error = np.append(error, mean / band.weight.sum() - reference.value[fitted] @ cells / cells.sum())
    atmosphere = np.append(reference.atmosphere[rows], reference.atmosphere[fitted])
    worst = max(np.sqrt(np.mean(error[atmosphere == number] ** 2)) for number in set(atmosphere))
    assert worst - 1e-4 < band.line_by_line.transmittance_rms < 3 * worst + 5e-4
    assert band.line_by_line.transmittance_max >= band.line_by_line.transmittance_rms


def test_what_cells_cannot_resolve_at_an_end_is_in_the_statement():
    """A response that ends in the middle of a cell: its halves differ by as much as its neighbours do from it."""
    reference = replace(
        TABLE.fine.reference_spectra(1000, 1001), value=np.array([[0.2, 0.5, 0.6, 0.3, 0.4, 0.4, 0.1, 0.9]])
    )
    end = reference.cell[2]
    response = SpectralResponse.rectangular(1e4 / end, 1e4 / 999.0)
    cells = _Cells(reference, 0.125, micron_response(response, reference.cell - 0.0625, 0.125))
    share = 0.25 / 2.5  # of the mean: a quarter of a cell, of two and a half
    expected = share**2 * (0.1**2 + 0.3**2) / 2
    np.testing.assert_allclose(_within_cells(cells, response), [expected], rtol=1e-2)
    whole = SpectralResponse.rectangular(1e4 / (end + 0.0625), 1e4 / 999.0)  # ends between two cells
    cells = _Cells(reference, 0.125, micron_response(whole, reference.cell - 0.0625, 0.125))
    np.testing.assert_allclose(_within_cells(cells, whole), 0, atol=1e-7)


def test_what_ends_err_by_counts_with_two_standard_deviations(monkeypatch):
    def stated(square):
        monkeypatch.setattr(
            response_points, "_within_cells", lambda cells, _: np.full(len(cells.reference.value), square)
        )
        error = points_of_band(TABLE, SpectralResponse.rectangular(8.7, 8.75)).line_by_line
        return np.array([error.transmittance_rms, error.radiance_rms])

    np.testing.assert_allclose(stated(0.01**2) ** 2 - stated(0.0) ** 2, (2 * 0.01) ** 2, rtol=1e-9)


def test_another_air_is_below_the_limit_as_often_as_is_said():
    draws = np.exp(np.random.default_rng(3).normal(-7.0, 0.4, (20000, 9)))
    below = [row[8] < _another(row[:8]) for row in draws]
    assert np.mean(below) == pytest.approx(0.95, abs=0.005)


def test_a_strong_line_just_outside_does_not_count():
    """A band of 1 cm-1 whose interval of 5 cm-1 holds lines outside it: whole intervals are ten times further off."""
    low, high = 1136.3, 1137.5
    response = SpectralResponse.rectangular(1e4 / high, 1e4 / low)
    reference, _, truth = own_spectrum(low, high)

    def rms(band):
        values = reference.at_points(band.points, fitted=False)[~reference.emission[~reference.fitted]]
        return np.sqrt(np.mean((values @ band.weight / band.weight.sum() - truth) ** 2))

    whole = band_points(TABLE.points(*response.wavenumber_range), response)
    assert rms(points_of_band(TABLE, response)) < 0.1 * rms(whole)


def test_a_wide_band_has_whole_intervals_but_at_its_ends():
    response = SpectralResponse.rectangular(8.0, 12.0)
    whole, own = band_points(TABLE.points(*response.wavenumber_range), response), points_of_band(TABLE, response)
    assert np.mean(np.isin(own.points.wavenumber, whole.points.wavenumber)) > 0.97
    assert own.weight.size < 1.03 * whole.weight.size
    assert own.line_by_line.transmittance_rms < 5e-4 and own.line_by_line.radiance_rms < 5e-4


def test_a_band_beyond_the_fine_table_states_no_error():
    own = points_of_band(TABLE, SpectralResponse.rectangular(2.0, 2.05))
    assert own.line_by_line is None


def test_another_continuum_changes_the_points_and_not_what_is_stated():
    response = SpectralResponse.rectangular(8.7, 8.8)
    one, two = (
        points_of_band(AbsorptionTable.open(water_continuum=name), response) for name in ("mt_ckd_4.3", "mt_ckd_2.4")
    )
    np.testing.assert_array_equal(one.weight, two.weight)
    assert one.line_by_line == two.line_by_line
    sections = [
        band.points.cross_sections([1e5], [290.0], [0.01], ["H2O_continuum"])["H2O_continuum"] for band in (one, two)
    ]
    assert not np.allclose(*sections, rtol=1e-2, atol=0)
