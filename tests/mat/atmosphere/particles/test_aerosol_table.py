"""A user's aerosol from CSV: what it gives, and what is refused where."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.aerosol_table import parse_aerosol, parse_aerosol_optics
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


OPTICS_HEAD = "height[km],wavelength[um],extinction[km^-1],single_scattering_albedo,asymmetry\n"
OPTICS = (
    OPTICS_HEAD
    + "0.5,0.25,0.3,0.9,0.7\n0.5,0.55,0.2,0.9,0.6\n0.5,40,0.01,0.1,0.2\n"
    + "1,0.25,0.1,0.6,0.8\n1,1.1,0.1,0.4,0.3\n1,40,0.1,0.2,0.1\n"
    + "2,0.25,0,1,0\n2,40,0,1,0\n"
)


def test_optics_by_height_mix_linearly_between_heights():
    state = AtmosphericState.from_profile(
        "us_standard", aerosol=Aerosol("none"), aerosol_layers=parse_aerosol_optics(OPTICS, "retrieval.csv")
    )
    wavenumber = 1e4 / np.array([0.55, 40.0])

    def mixture(height):
        extinction = scattering = forward = 0.0
        for part in state.aerosols:
            optics = part.model.optics(wavenumber, [50.0])
            here = np.interp(height, state.altitude, part.extinction_550) * optics.extinction[0]
            extinction = extinction + here
            scattering = scattering + here * optics.single_scattering_albedo[0]
            forward = forward + here * optics.single_scattering_albedo[0] * optics.asymmetry[0]
        return np.array([extinction * 1e3, scattering / extinction, forward / scattering])

    np.testing.assert_allclose(mixture(500.0), [[0.2, 0.01], [0.9, 0.1], [0.6, 0.2]], rtol=1e-9)
    # 0.55 um at 1 km: albedo by the power law of absorption from 0.4 to 0.6, asymmetry linear in wavelength.
    share = np.log(0.55 / 0.25) / np.log(1.1 / 0.25)
    upper = [[0.1, 0.1], [1 - 0.4 * 1.5**share, 0.2], [0.8 - 0.5 * 0.3 / 0.85, 0.1]]
    np.testing.assert_allclose(mixture(1000.0), upper, rtol=1e-9)
    between = mixture(750.0)
    np.testing.assert_allclose(between[0], [0.15, 0.055], rtol=1e-9)
    scattering = np.array([0.5 * (0.18 + 0.1 * upper[1][0]), 0.5 * (0.001 + 0.02)])
    np.testing.assert_allclose(between[1], scattering / between[0], rtol=1e-9)
    np.testing.assert_allclose(
        between[2] * scattering,
        [0.5 * (0.18 * 0.6 + 0.1 * upper[1][0] * upper[2][0]), 0.5 * (0.001 * 0.2 + 0.02 * 0.1)],
        rtol=1e-9,
    )
    assert sum(float(np.interp(490.0, state.altitude, part.extinction_550)) for part in state.aerosols) == 0.0
    # 0.5 km at the mean of 0.2 and 0.1 km^-1, 1 km at half of 0.1, 10 m below at half of 0.2.
    assert state.aerosol_optical_depth(550.0, 0.0) == pytest.approx(0.075 + 0.05 + 0.001, rel=2e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (OPTICS.replace("[km^-1]", "[m^-1]"), r"o.csv:1:\d+: found the unit 'm\^-1' of extinction"),
        (OPTICS.replace("\n1,", "\n0.4,"), r"o.csv:5:1: found 0.4 after 0.5; allowed: a height that rises"),
        (OPTICS.replace("0.6,0.8", "1.01,0.8"), r"o.csv:5:12: found 1.01; allowed: 0 to 1"),
        (OPTICS.replace("0.9,0.7", "0.9,-1"), r"o.csv:2:18: found -1; allowed: between -1 and 1"),
        (OPTICS.replace("0.9,0.7", "inf,0.7"), r"o.csv:2:14: .*inf"),
        (OPTICS.replace("0.3,", "-0.3,"), r"o.csv:2:10: found -0.3; allowed: at least 0"),
        (OPTICS.replace("1.1,0.1", "1.1,0"), r"o.csv:6:7: found 0; allowed: above 0, or 0 at all wavelengths"),
        (OPTICS.replace("1,40,", "1,20,"), r"o.csv:7:3: found wavelengths from 0.25 to 20 um"),
        (OPTICS.replace("\n0.5,40", "\n0.5,0.4"), r"o.csv:4:5: found 0.4 after 0.55; allowed: a wavelength that rises"),
        (OPTICS_HEAD + "1,0.25,1,1,0\n1,40,1,1,0\n", r"o.csv:2:1: found 1 heights; allowed: 2 to 24"),
        (OPTICS.replace("\n2,", "\n90,"), r"o.csv:8:1: found 90; allowed: 0 to 80"),
        (OPTICS_HEAD + "".join(f"{h},{w},0,1,0\n" for h in (0, 1) for w in (0.25, 40)), r"found no extinction"),
    ],
)
def test_optics_that_do_not_fit_are_refused_at_their_place(text, message):
    with pytest.raises(InputError, match=message):
        try:
            parse_aerosol_optics(text, "o.csv")
        except InputError as error:
            raise InputError(str(error)) from None
