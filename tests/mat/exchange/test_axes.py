"""Tables on five axes of a finished file: they keep their tolerance, or say how far they come."""

import numpy as np
import pytest
from click.testing import CliRunner

import skyshine.mat
from skyshine.mat.cli import main
from skyshine.mat.exchange.axes import export_axes, scene_scale
from skyshine.mat.measure.grid_nodes import drawn_points
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.equivalent_temperature import kelvin_per_radiance, reference_radiance
from skyshine.mat.tables.verify import problems
from skyshine.schemas.errors import InputError


@pytest.fixture(scope="module")
def written(channel_atmosphere, tmp_path_factory):
    return export_axes(channel_atmosphere, tmp_path_factory.mktemp("axes"), 1.0, 2_000_000)


def test_kelvin_are_those_of_a_black_body_in_the_band(channel_atmosphere):
    scale, response = scene_scale(skyshine.mat.open(channel_atmosphere)), SpectralResponse.rectangular(10.0, 10.2)
    assert scale.background == pytest.approx(reference_radiance(response), rel=0.01)
    assert scale.factor == pytest.approx(kelvin_per_radiance(response), rel=0.01)


def test_other_reads_keep_the_tolerance(written, channel_atmosphere):
    """Transmittance and path radiance of a black body at 300 K, at places of the test's own."""
    assert problems(written.path) == [] and written.p99 <= 1.0
    tables, air = skyshine.mat.open(written.path, grid=True), skyshine.mat.open(channel_atmosphere)
    places = drawn_points(air, 3000, np.random.default_rng(99))
    line = {name: places[name] for name in ("range", "altitude", "elevation")}
    scale = scene_scale(air)
    through = [
        air.transmittance(range=line["range"], beta_star=one.value("beta_star", **line)) for one in (tables, air)
    ]
    lost = (through[0] - through[1]) * scale.background * scale.factor
    path = [one.value("path_radiance_ratio", **places) for one in (tables, air)]
    light = (path[0] - path[1]) * (1 - through[1]) * scale.factor
    for error in (lost, light):
        assert np.percentile(np.abs(error), 99) < 1.2
    assert np.abs(lost).max() > 1e-3  # linear interpolation errs


def test_a_size_that_holds_no_tolerance_is_said(channel_atmosphere, tmp_path):
    arguments = ["export", "--to", "axes", str(channel_atmosphere), "--out", str(tmp_path), "--tolerance", "0.05 K"]
    result = CliRunner().invoke(main, [*arguments, "--most-nodes", "5000"])
    assert result.exit_code == 0 and "--tolerance 0.05 K is not reached with 5,000 nodes" in result.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "no format is named; allowed: --to raw, --to axes"),
        (["--to", "axes", "--tolerance", "1 %"], "--tolerance: found '1 %'; allowed: 0.05 K to 5 K"),
    ],
)
def test_options_that_do_not_fit_are_one_line(channel_atmosphere, tmp_path, arguments, words):
    result = CliRunner().invoke(main, ["export", *arguments, str(channel_atmosphere), "--out", str(tmp_path)])
    assert result.exit_code == 2 and words in result.output and len(result.output.splitlines()) == 1


def test_a_file_is_not_written_over_itself_and_bands_have_no_axes(channel_atmosphere, small_build):
    with pytest.raises(InputError, match="would be written over itself"):
        export_axes(channel_atmosphere, channel_atmosphere.parent, 1.0, 1000)
    with pytest.raises(InputError, match="is of the file type 'band'; allowed: atmq, lunar_atmq; name one of these"):
        export_axes(small_build / "b01.band.h5", small_build.parent / "other", 1.0, 1000)
