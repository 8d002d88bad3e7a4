"""A user's aerosol from CSV: what it gives, and what is refused where."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.aerosol_table import parse_aerosol
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.schemas.errors import InputError

HEAD = "wavelength[um],extinction,single_scattering_albedo,asymmetry\n"
TABLE = HEAD + "0.25,9,0.9,0.7\n0.55,4.5,0.95,0.65\n10,0.45,0.4,0.5\n40,0.1,0.2,0.2\n"


def test_a_table_gives_optics_in_any_measure_of_extinction():
    model = parse_aerosol(TABLE, "dust.csv")
    assert model.name == "dust.csv"
    optics = model.optics(1e4 / np.array([0.25, 0.55, 10.0, 40.0]), [20.0, 90.0])
    np.testing.assert_allclose(optics.extinction, [[2.0, 1.0, 0.1, 0.1 / 4.5]] * 2, rtol=1e-12)
    np.testing.assert_allclose(optics.single_scattering_albedo, [[0.9, 0.95, 0.4, 0.2]] * 2, rtol=1e-12)
    np.testing.assert_allclose(optics.asymmetry, [[0.7, 0.65, 0.5, 0.2]] * 2, rtol=1e-12)


def test_a_table_stands_for_the_lowest_two_kilometres_alone():
    aerosol = Aerosol(optics=parse_aerosol(TABLE, "dust.csv"), optical_depth=0.4)
    plain, dusty = (
        AtmosphericState.from_profile("us_standard", aerosol=one) for one in (Aerosol(optical_depth=0.4), aerosol)
    )
    names = [part.model.name for part in dusty.aerosols]
    assert names == ["dust.csv", *(part.model.name for part in plain.aerosols[1:])]
    for before, after in zip(plain.aerosols, dusty.aerosols, strict=True):
        np.testing.assert_array_equal(after.extinction_550, before.extinction_550)
    assert dusty.aerosol_optical_depth(550.0, 0.0) == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TABLE.replace("asymmetry", "g"), r"dust.csv:1:\d+: found the column 'g'"),
        (TABLE.replace("[um]", "[nm]"), r"dust.csv:1:1: found the unit 'nm' of wavelength; allowed: um"),
        (TABLE.replace("10,", "0.5,"), r"dust.csv:4:1: found 0.5 after 0.55; allowed: a wavelength that rises"),
        (TABLE.replace("0.25,", "0.4,"), r"dust.csv:2:1: found wavelengths from 0.4 to 40 um"),
        (TABLE.replace("\n40,", "\n20,"), r"dust.csv:5:1: found wavelengths from 0.25 to 20 um"),
        (TABLE.replace("4.5,", "0,"), r"dust.csv:3:6: found 0; allowed: above 0"),
        (TABLE.replace("0.95", "1.2"), r"dust.csv:3:10: found 1.2; allowed: 0 to 1"),
        (TABLE.replace("0.65", "1"), r"dust.csv:3:15: found 1; allowed: between -1 and 1"),
        (TABLE.replace("0.65", "nan"), r"dust.csv:3:15: .*nan"),
    ],
)
def test_a_table_that_does_not_fit_is_refused_at_its_place(text, message):
    with pytest.raises(InputError, match=message):
        try:
            parse_aerosol(text, "dust.csv")
        except InputError as error:
            raise InputError(str(error)) from None


def test_a_table_needs_an_aerosol_for_its_amount():
    with pytest.raises(InputError, match="name the model of its amount"):
        Aerosol("none", optics=parse_aerosol(TABLE, "dust.csv"))
