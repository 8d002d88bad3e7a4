"""Response tables: units, order, interpolation and what is refused."""

import numpy as np
import pytest

from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance
from skyshine.mat.radiometry.response_table import UNITS, parse_response, response_notes
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
        ("wavelength[um]", "wavenumber", "r.csv:2:1: found no unit of wavenumber; allowed: cm-1, cm^-1, 1/cm, m-1;"),
        ("wavelength[um]", "wavelength[parsec]", "r.csv:2:1: found the unit 'parsec' of wavelength; allowed: um, nm"),
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
    assert response_notes("\n".join([head, *rows]), "r.csv") == ("peaks at 80; scaled to 1",)


@pytest.mark.parametrize(
    "name", ["QE", "EQE (%)", "quantum_efficiency", "photon response", "response[electrons/photon]"]
)
@pytest.mark.parametrize("axis", ["wavelength[um]", "wavenumber[cm-1]"])
def test_a_quantum_efficiency_becomes_the_response_to_energy(name, axis):
    """A detector that counts every photon of 8 to 12 um: its response to a watt rises as the wavelength."""
    ends = ("8", "12") if axis == "wavelength[um]" else ("1250", "833.3333333333334")
    text = f"{axis},{name}\n{ends[0]},0.6\n{ends[1]},0.6\n"
    response = parse_response(text, "r.csv")
    assert "counts photons" in response_notes(text, "r.csv")[-1]
    assert response.at_wavelength([8.0, 9.0, 10.0, 12.0]) == pytest.approx(np.array([8, 9, 10, 12]) / 12, rel=1e-9)


def test_a_quantum_efficiency_that_changes_is_finer_than_its_table():
    """QE rises linearly from 0 to 1 over 8 to 12 um: at 10 um half of it, times 10 of 12."""
    response = parse_response("wavelength_nm,QE\n8000,0\n12000,1\n", "r.csv")
    assert response.at_wavelength([9.0, 10.0, 11.0]) == pytest.approx([9 / 48, 10 / 24, 11 / 16], rel=2e-4)


@pytest.mark.parametrize(
    "text", ["", "wavelength_um,response\n", "800,0\n900,1\n10,0\n", "wavelength_um\n8\n9\n", "\0\0,\0\n1,2\n3,4\n"]
)
def test_hostile_tables_are_refused_in_one_line(text):
    with pytest.raises(InputError) as caught:
        parse_response(text, "r.csv")
    assert "\n" not in str(caught.value)


ROWS_OF_TIRS = [("10.3", -0.0005), ("10.6", 0.4), ("10.9", 1.0), ("11.2", 0.5), ("11.4", -0.0002)]


def test_scatter_beside_a_response_and_its_noise_below_0():
    """As the tables of the Landsat mission: wavelength in nanometres without a unit, and a column STDEV."""
    rows = [f"{1000 * float(wavelength):g},{value},0.001" for wavelength, value in ROWS_OF_TIRS]
    text = "\n".join(["Wavelength,BA RSR [watts],STDEV", *rows])
    response = parse_response(text, "r.csv")
    assert response.at_wavelength([10.3, 10.6, 10.9, 11.2, 11.4]) == pytest.approx([0, 0.4, 1, 0.5, 0])
    column, unit, noise = response_notes(text, "r.csv")
    assert column == "has the column STDEV, which is not read"
    assert unit == "names no unit; 10300 to 11400 is read in nm"
    assert noise == "has 2 values below 0, down to -0.0005; they are replaced by 0"


@pytest.mark.parametrize(
    "text",
    [
        "wavelength[um];response\n8,0;0,0\n9,0;1,0\n11,0;1,0\n12,0;0,0\n",
        "wavelength[um]\tresponse\n8,0\t0,0\n9,0\t1,0\n11,0\t1,0\n12,0\t0,0\n",
        "  Wavelength (um)   RSR\n  8.0  0\n  9.0  1\n 11.0  1e0\n 12.0  0\n",
        "8 0\n9 1\n11 1\n12 0\n",
        "8,0\n9,1\n11,1\n12,0\n",
        "# wavelength[nm] response\n8000 0\n9000 1\n11000 1\n12000 0\n",
        "# response of camera 7, wavelength in nm\n8000 0\n9000 1\n11000 1\n12000 0\n",
        "Camera 7\nWavelength (micron), then response\n\n8;0;0,1\n9;1;0,1\n11;1;0,1\n12;0;0,1\n",
        "wavelength[um],response\n12,0\n11,1\n9,1\n8,0\n",
    ],
)
def test_forms_of_one_trapezium(text):
    response = parse_response(text, "r.txt")
    assert (response.lower, response.upper) == (8.0, 12.0)
    assert response.at_wavelength([8.25, 9.0, 10.0, 11.5]) == pytest.approx([0.25, 1, 1, 0.5])


def test_text_of_wavenumbers_below_lines_of_words():
    """As satellite agencies write them: a title, the platform, a line of names, then numbers between blanks."""
    head = "Normalised response\nPLATFORM 1 channel 4\n  3 rows\nWavenumber (cm-1)   Response\n"
    response = parse_response(head + "   800.0  0.0\n  1000.0  1.0\n  1250.0  0.0\n", "srf_ch04.txt")
    assert (response.lower, response.upper) == pytest.approx((8.0, 12.5))
    assert response.at_wavenumber(900.0) == pytest.approx(0.5, abs=3e-4)


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("wavelength[um],response\n8,0\n9,37\n10,0\n", "peaks at 37; scaled to 1"),
        ("wavelength[um],response\n10,0\n9,1\n8,0\n", "falls in wavelength from row to row; turned round"),
        ("wavelength[um],response\n8,1\n9,1\n10,1\n", "is flat over all 3 rows; read as a rectangle"),
    ],
)
def test_what_is_done_with_a_table_is_said(text, note):
    assert response_notes(text, "r.csv") == (note,)
    assert parse_response(text, "r.csv").response.max() == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("700 0\n800 1\n900 0\n", r"r\.csv:1:1: names neither wavelength nor wavenumber; write a first line such as"),
        ("0.01,0\n0.02,1\n0.03,0\n", "no unit of wavelength; allowed: um, nm, m.*write a first line such as"),
        ("wavelength[um],B10,B11\n8,0,1\n9,1,1\n", "found the columns wavelength and B10 and B11; allowed: response"),
    ],
)
def test_columns_that_nothing_names(text, words):
    with pytest.raises(InputError, match=words):
        parse_response(text, "r.csv")


def test_decimal_commas_between_semicolons():
    response = parse_response("wavelength (um);response\n8,0;0\n9,5;0,9\n11,25;1\n12,0;0\n", "r.csv")
    assert response.wavelength.tolist() == [8.0, 9.5, 11.25, 12.0] and response.response.tolist() == [0, 0.9, 1, 0]
