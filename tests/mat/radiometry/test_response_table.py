"""Response tables: units, order, interpolation and what is refused."""

import numpy as np
import pytest

from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance
from skyshine.mat.radiometry.response_table import UNITS, is_quantum, parse_response
from skyshine.schemas.errors import InputError

TABLE = """\
# camera 7
wavelength[um],response
7.5,0
8,40
9,80
11,60
12,0
13,0
"""


def test_a_table_is_scaled_to_peak_one_and_cut_to_where_it_responds():
    response = parse_response(TABLE, "r.csv")
    assert (response.lower, response.upper) == (7.5, 12.0)
    assert response.at_wavelength([7.75, 8.0, 9.0, 11.5]) == pytest.approx([0.25, 0.5, 1.0, 0.375])


def test_order_and_unit_do_not_matter():
    rows = [line.split(",") for line in TABLE.splitlines()[2:]]
    text = "response,wavelength[nm]\n" + "\n".join(f"{v},{1e3 * float(w)}" for w, v in reversed(rows))
    ours, own = parse_response(text, "r.csv"), parse_response(TABLE, "r.csv")
    assert ours.wavelength == pytest.approx(own.wavelength) and ours.response == pytest.approx(own.response)


# 8, 10 and 12.5 um: 1250, 1000 and 800 waves in a centimetre.
ROWS = {
    "um": ("8", "10", "12.5"),
    "nm": ("8000", "10000", "12500"),
    "m": ("8e-6", "10e-6", "12.5e-6"),
    **dict.fromkeys(
        ("micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"), ("8", "10", "12.5")
    ),
    **dict.fromkeys(("nanometer", "nanometers", "nanometre", "nanometres"), ("8000", "10000", "12500")),
    **dict.fromkeys(("cm-1", "cm^-1", "1/cm"), ("1250", "1000", "800")),
    "m-1": ("125000", "100000", "80000"),
}


@pytest.mark.parametrize(("kind", "unit"), [(kind, unit) for kind, units in UNITS.items() for unit in units])
def test_each_unit_is_converted(kind, unit):
    rows = [f"{row},{value}" for row, value in zip(ROWS[unit], [0.2, 1.0, 0.4], strict=True)]
    response = parse_response("\n".join([f"{kind}[{unit}],response", *rows]), "r.csv")
    assert (response.lower, response.upper) == pytest.approx((8.0, 12.5), rel=1e-12)
    assert response.at_wavelength([8.0, 10.0, 12.5]) == pytest.approx([0.2, 1.0, 0.4], rel=1e-9)


@pytest.mark.parametrize("order", [1, -1])
def test_a_wavenumber_table_gets_a_node_for_each_hundredth(order):
    """1.01^22 < 1.25 < 1.01^23: 23 parts each of 800 to 1000 and 1000 to 1250 cm^-1, whichever comes first."""
    rows = ["800,0", "1000,1", "1250,0"][::order]
    response = parse_response("wavenumber[cm-1],response\n" + "\n".join(rows), "r.csv")
    assert response.wavelength.size == 2 * 23 + 1


def test_a_wavenumber_table_is_linear_in_wavenumber():
    response = parse_response("wavenumber[cm-1],response\n800,0\n1000,1\n1250,0\n", "r.csv")
    nodes = np.linspace(800, 1250, 91)
    assert response.at_wavenumber(nodes) == pytest.approx(np.interp(nodes, [800, 1000, 1250], [0, 1, 0]), abs=3e-4)


def test_a_rectangle_in_wavenumbers_is_the_one_in_wavelengths():
    table = parse_response("wavenumber[cm-1],response\n1250,3\n800,3\n", "r.csv")
    assert band_radiance(table, 300.0) == pytest.approx(
        band_radiance(SpectralResponse.rectangular(8.0, 12.5), 300.0), rel=1e-12
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("9,80", "8,80", "r.csv:5:1: found 8 after 8; allowed: a wavelength that rises"),
        ("9,80", "14,80", "r.csv:6:1: found 11 after 14"),
        ("8,40", "8,-1", "r.csv:4:3: found -1; allowed: a response of at least 0"),
        ("8,40", "8,nan", "r.csv:4:3: response: found 'nan'; allowed: a finite number"),
        ("7.5,0", "-7.5,0", "r.csv:3:1: found -7.5; allowed: a wavelength above 0"),
        ("wavelength[um]", "wavelength", "r.csv:2:1: found no unit of wavelength; allowed: um, nm, m, micron"),
        ("wavelength[um]", "colour[um]", "r.csv:2:1: found the columns colour and response; allowed"),
        (",response", ",wavenumber[cm-1]", "r.csv:2:1: found the columns wavelength and wavenumber; allowed: response"),
    ],
)
def test_bad_tables_are_refused_with_line_and_column(old, new, message):
    assert old in TABLE
    with pytest.raises(InputError) as caught:
        parse_response(TABLE.replace(old, new, 1), "r.csv")
    assert str(caught.value).startswith(message)


def test_a_response_of_0_everywhere_is_refused():
    with pytest.raises(InputError, match="0 in every row"):
        parse_response("wavelength[um],response\n8,0\n9,0\n", "r.csv")


@pytest.mark.parametrize(
    "head",
    [
        "wavelength_um,response",
        "Wavelength (um);RSR",
        "lambda [\u00b5m]\tB10",
        "wl_um,transmission (%)",
        "WAVELENGTH [microns],responsivity[A/W]",
    ],
)
def test_usual_headers_and_delimiters(head):
    delimiter = next((d for d in "\t;" if d in head), ",")
    rows = [line.replace(",", delimiter) for line in TABLE.splitlines()[2:]]
    ours, own = parse_response("\n".join([head, *rows]), "r.csv"), parse_response(TABLE, "r.csv")
    assert ours.wavelength == pytest.approx(own.wavelength) and ours.response == pytest.approx(own.response)
    assert not is_quantum("\n".join([head, *rows]), "r.csv")


@pytest.mark.parametrize(
    "name", ["QE", "EQE (%)", "quantum_efficiency", "photon response", "response[electrons/photon]"]
)
@pytest.mark.parametrize("axis", ["wavelength[um]", "wavenumber[cm-1]"])
def test_a_quantum_efficiency_becomes_the_response_to_energy(name, axis):
    """A detector that counts every photon of 8 to 12 um: its response to a watt rises as the wavelength."""
    ends = ("8", "12") if axis == "wavelength[um]" else ("1250", "833.3333333333334")
    text = f"{axis},{name}\n{ends[0]},0.6\n{ends[1]},0.6\n"
    response = parse_response(text, "r.csv")
    assert is_quantum(text, "r.csv")
    assert response.at_wavelength([8.0, 9.0, 10.0, 12.0]) == pytest.approx(np.array([8, 9, 10, 12]) / 12, rel=1e-9)


def test_a_quantum_efficiency_that_changes_is_finer_than_its_table():
    """QE rises linearly from 0 to 1 over 8 to 12 um: at 10 um half of it, times 10 of 12."""
    response = parse_response("wavelength_nm,QE\n8000,0\n12000,1\n", "r.csv")
    assert response.at_wavelength([9.0, 10.0, 11.0]) == pytest.approx([9 / 48, 10 / 24, 11 / 16], rel=2e-4)


@pytest.mark.parametrize(
    "text", ["", "wavelength_um,response\n", "8,0\n9,1\n10,0\n", "wavelength_um\n8\n9\n", "\0\0,\0\n1,2\n3,4\n"]
)
def test_hostile_tables_are_refused_in_one_line(text):
    with pytest.raises(InputError) as caught:
        parse_response(text, "r.csv")
    assert "\n" not in str(caught.value)
