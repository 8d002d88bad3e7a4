"""Stand-ins for missing line lists: LOWTRAN7's parameters from its source, REPTRAN's representatives on the fine
grid.
"""

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("netCDF4")

from skyshine.mat.spectroscopy import linebyline, nodes
from skyshine.mat.spectroscopy.lookups import SHAPE_EFFECT, WHOLE_COLUMN, LookupSource, band_parameters
from skyshine.schemas.errors import InputError

FORTRAN = """\
      DATA IWLO3 /   0,    515,   -999/
      DATA IWHO3 /  10,    520,   -999/
      BLOCK DATA CPO3
C     DATA C11O3/ 9.0/
      DATA C11O3/
     1 -2.0, -1.5,
     2  0.5/
      DATA C21O3/ -0.25, 1.0/
      END
"""


def test_parameters_are_read_with_their_wavenumbers(tmp_path):
    path = tmp_path / "lowtran7.f"
    path.write_text(FORTRAN)
    found = band_parameters(path, "O3")
    assert list(found) == [0, 5, 10, 515, 520]
    np.testing.assert_allclose([np.log10(value) for value in found.values()], [-2.0, -1.5, 0.5, -0.25, 1.0])


@pytest.mark.parametrize(
    "text, message",
    [(FORTRAN.replace(", 1.0/", "/"), "4 parameters of O3 for 5 wavenumbers"), ("      END\n", "no DATA of IWLO3")],
)
def test_other_sources_are_refused(tmp_path, text, message):
    path = tmp_path / "lowtran7.f"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        band_parameters(path, "O3")


def test_missing_files_are_named(tmp_path):
    with pytest.raises(InputError, match="--lowtran needs"):
        band_parameters(tmp_path / "absent.f", "O3")
    with pytest.raises(InputError, match="--lookups needs"):
        LookupSource("O3", tmp_path, tmp_path / "absent.f")


@pytest.mark.shared_data
def test_ozone_near_nine_and_a_half_micrometres(shared_data, tmp_path):
    path = tmp_path / "lowtran7.f"
    path.write_text(FORTRAN.replace("515", "1050").replace("520", "1055"))
    source = LookupSource("O3", shared_data / "ozone_n2o", path)
    assert source.covers(1050.0, 1055.0) and not source.covers(20.0, 25.0)
    grid = linebyline.interval_grid(1050.0, 1055.0)
    spectrum = source.spectrum(grid, 1050.0, 1055.0)
    assert spectrum.shape == (nodes.PRESSURE.size, nodes.TEMPERATURE.size, grid.size) and spectrum.min() >= 0
    # Band strength of nu3 is 1.4e-17 cm over some 70 cm-1 (Rothman et al. 2005): a mean of about 2e-19 cm2, more in the
    # branches.
    mean = spectrum[-1, 4].mean() * 1e4
    assert 1e-19 < mean < 8e-19
    some, humid = source.points(grid[[5, 700, 4000]], 1050.0, 1055.0)
    assert humid is None
    np.testing.assert_array_equal(some, np.moveaxis(spectrum[..., [5, 700, 4000]], -1, 0))


@pytest.mark.shared_data
@pytest.mark.parametrize("slope", [0.0, 0.5])
def test_a_steep_shape_is_flattened_until_it_keeps_the_transmittance_of_its_band(shared_data, tmp_path, slope):
    """Ozone at 1060-1075 cm-1: REPTRAN's representatives as they are against the three intervals, through the whole
    atmosphere.
    """
    values = ",".join(f"{slope * step:.2f}" for step in range(4))
    path = tmp_path / "lowtran7.f"
    path.write_text(
        "      DATA IWLO3 /1060, -999/\n      DATA IWHO3 /1075, -999/\n      BLOCK DATA CPO3\n"
        f"      DATA C11O3/{values}/\n      END\n"
    )
    source = LookupSource("O3", shared_data / "ozone_n2o", path)
    column, pressure, temperature = WHOLE_COLUMN["O3"]
    place = np.abs(np.log(nodes.PRESSURE / pressure)).argmin(), np.abs(nodes.TEMPERATURE - temperature).argmin()
    means, strengths = [], []
    for low in (1060.0, 1065.0, 1070.0):
        spectrum = source.spectrum(linebyline.interval_grid(low, low + 5), low, low + 5)[place]
        means.append(np.exp(-column * spectrum).mean())
        strengths.append(spectrum.mean())
    band = int(source._containing(1060.0, 1065.0)[0])
    depth = column * np.array([source._at_nodes(int(k))[place] for k in source._members[: source._count[band], band]])
    exact = np.average(np.exp(-depth), weights=source._weights[: source._count[band], band])
    assert abs(np.mean(means) - exact) < SHAPE_EFFECT + 0.001
    assert (strengths[2] / strengths[0] > 1.5) == (slope > 0)
    assert np.mean(strengths) == pytest.approx(
        np.average(depth / column, weights=source._weights[: depth.size, band]), rel=0.02
    )
