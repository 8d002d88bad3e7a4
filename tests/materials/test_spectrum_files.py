"""Spectra in the units and formats that users have: the same curve from each, and words for what is wrong."""

import importlib.util

import numpy as np
import pytest

from skyshine.materials.spectrum_files import Said, read_spectrum
from skyshine.schemas.errors import InputError

UM = np.linspace(0.4, 14.0, 60)
CURVE = 0.3 + 0.2 * np.sin(UM)


def write(path, x, y, head="", separator=","):
    path.write_text(head + "\n".join(f"{a:.12g}{separator}{b:.6f}" for a, b in zip(x, y, strict=True)) + "\n")
    return path


ECOSTRESS = "Name: paving\nX Units: Wavelength (micrometers)\nY Units: Reflectance (percentage)\n\n"


@pytest.mark.parametrize(
    "head, x, y, said",
    [
        ("wavelength_um,reflectance\n", UM, CURVE, Said()),
        ("wavelength [um],reflectance [%]\n", UM, 100 * CURVE, Said()),
        ("wavelength_nm,emissivity\n", 1000 * UM, 1 - CURVE, Said()),
        ("wavenumber cm-1,emissivity percent\n", 1e4 / UM, 100 * (1 - CURVE), Said()),
        ("", UM, CURVE, Said()),
        ("", 1000 * UM, CURVE, Said(unit="nm")),
        ("# my sample\n", UM, 100 * CURVE, Said()),
        (ECOSTRESS, UM[::-1], 100 * CURVE[::-1], Said()),
        (ECOSTRESS.replace("Reflectance (percentage)", "Emissivity (percent)"), UM, 100 * (1 - CURVE), Said()),
        (ECOSTRESS, UM, CURVE, Said(scale="fraction")),
        ("wavelength (m),reflectance\n", 1e-6 * UM, CURVE, Said()),
        ("wavelength (\u00c5),absorptance\n", 1e4 * UM, 1 - CURVE, Said()),
        ("", 1e4 * UM, CURVE, Said(unit="angstrom")),
        ("", UM, 5 * CURVE, Said(scale="percent")),
    ],
)
def test_the_same_curve_from_every_unit(tmp_path, head, x, y, said):
    found = read_spectrum(write(tmp_path / "spectrum.txt", x, y, head), said)
    assert found.wavelength == pytest.approx(UM, rel=1e-5)
    expected = 0.05 * CURVE if said == Said(scale="percent") else CURVE
    assert found.reflectance == pytest.approx(expected, abs=1e-5)
    assert np.all(np.diff(found.wavelength) > 0)


@pytest.mark.parametrize("separator", [";", "\t", " ; "])
@pytest.mark.parametrize("head", ["", "Wellenl\u00e4nge (nm);reflectance [%]\n"])
def test_comma_is_decimal_after_semicolons_and_tabs(tmp_path, separator, head):
    rows = [f"{1000 * x:.4f}{separator}{100 * y:.6f}".replace(".", ",") for x, y in zip(UM, CURVE, strict=True)]
    (tmp_path / "a.csv").write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    found = read_spectrum(tmp_path / "a.csv", Said(unit="nm"))
    assert found.wavelength == pytest.approx(UM, rel=1e-5) and found.reflectance == pytest.approx(CURVE, abs=1e-6)


def table(path, head, *columns):
    path.write_text(head + "\n".join(",".join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True)))
    return path


def test_column_of_a_table_is_the_named_one(tmp_path):
    file = table(tmp_path / "many.csv", '"wavelength","A001","B002"\n', UM, CURVE, 0.5 * CURVE)
    found = read_spectrum(file, Said(record="B002"))
    assert found.reflectance == pytest.approx(0.5 * CURVE, abs=1e-6) and found.title == "B002"
    with pytest.raises(InputError, match="contains 2 columns of values; name one with --record: A001, B002"):
        read_spectrum(file, Said())
    with pytest.raises(InputError, match="contains no column 'C003'; it has A001, B002"):
        read_spectrum(file, Said(record="C003"))
    with pytest.raises(InputError, match="found 3 columns without names"):
        read_spectrum(table(tmp_path / "bare.csv", "", UM, CURVE, CURVE), Said())


def test_scatter_beside_a_spectrum_is_not_read(tmp_path):
    file = table(tmp_path / "a.csv", "um,std reflectance,reflectance,n\n", UM, 0 * UM + 0.01, CURVE, 0 * UM + 3)
    assert read_spectrum(file, Said()).reflectance == pytest.approx(CURVE, abs=1e-6)


def test_header_of_a_library_names_the_sample(tmp_path):
    assert read_spectrum(write(tmp_path / "a.txt", UM, 100 * CURVE, ECOSTRESS, "  "), Said()).title == "paving"


@pytest.fixture
def usgs(tmp_path):
    """A spectrum of splib07a: one value a line, deleted channels of -1.23e34, wavelengths in a file of their own."""
    values = [f"{y:.6f}" for y in CURVE]
    values[7] = "-1.2300000e+34"
    (tmp_path / "splib07a_X.txt").write_text(" splib07a Record=1: Asphalt GDS376\n" + "\n".join(values) + "\n")
    (tmp_path / "waves.txt").write_text(" splib07a Record=2: Wavelengths\n" + "\n".join(f"{x:.6f}" for x in UM) + "\n")
    return tmp_path


def test_text_of_the_usgs(usgs):
    found = read_spectrum(usgs / "splib07a_X.txt", Said(wavelengths=usgs / "waves.txt"))
    assert found.title == "Asphalt GDS376" and len(found.wavelength) == 59
    assert found.reflectance == pytest.approx(np.delete(CURVE, 7), abs=1e-5)
    with pytest.raises(InputError, match="one column; a spectrum of the USGS needs its file of wavelengths"):
        read_spectrum(usgs / "splib07a_X.txt", Said())
    (usgs / "waves.txt").write_text("0.4\n0.5\n")
    with pytest.raises(InputError, match="contains 60 values and waves.txt 2 wavelengths"):
        read_spectrum(usgs / "splib07a_X.txt", Said(wavelengths=usgs / "waves.txt"))


@pytest.fixture
def envi(tmp_path):
    np.array([CURVE, 100 * CURVE], np.float32).tofile(tmp_path / "library.sli")
    numbers = ", ".join(f"{1000 * x:.4f}" for x in UM)
    (tmp_path / "library.hdr").write_text(
        "ENVI\nsamples = 60\nlines = 2\nbands = 1\nheader offset = 0\nfile type = ENVI Spectral Library\n"
        "data type = 4\ninterleave = bsq\nbyte order = 0\nwavelength units = Nanometers\n"
        f"spectra names = {{slate, tile}}\nwavelength = {{{numbers}}}\n"
    )
    return tmp_path


@pytest.mark.skipif(importlib.util.find_spec("spectral") is None, reason="needs the extra envi")
def test_library_of_envi(envi):
    for file, record in (("library.hdr", "slate"), ("library.sli", "tile")):
        found = read_spectrum(envi / file, Said(record=record))
        assert found.title == record and found.wavelength == pytest.approx(UM, rel=1e-4)
        assert found.reflectance == pytest.approx(CURVE, abs=1e-5)
    with pytest.raises(InputError, match="contains 2 spectra; name one with --record: slate, tile"):
        read_spectrum(envi / "library.hdr", Said())
    with pytest.raises(InputError, match="contains no spectrum 'brick'"):
        read_spectrum(envi / "library.hdr", Said(record="brick"))
    (envi / "library.hdr").write_text("ENVI\n")
    with pytest.raises(InputError, match="is no ENVI spectral library"):
        read_spectrum(envi / "library.hdr", Said())


def envi_of(folder, values, header, encoding="ascii", offset=0):
    """A library of one spectrum with further lines of its header."""
    (folder / "one.sli").write_bytes(bytes(offset) + values.tobytes())
    numbers = ", ".join(f"{x:.5f}" for x in UM)
    kind = {"float64": 5, "int16": 2}[values.dtype.name]
    text = (
        f"ENVI\nsamples = {len(values)}\nlines = 1\nbands = 1\nheader offset = {offset}\ninterleave = bsq\n"
        f"file type = ENVI Spectral Library\ndata type = {kind}\nbyte order = 0\nspectra names = {{slate}}\n"
        f"wavelength = {{{numbers}}}\n{header}\n"
    )
    (folder / "one.hdr").write_bytes(text.encode(encoding))
    return read_spectrum(folder / "one.hdr", Said())


def test_the_header_of_envi_is_heeded(tmp_path):
    """Stored integers over their scale factor; values to ignore and bad bands are no points; bytes before the data."""
    stored = np.round(1000 * CURVE).astype("<i2")
    spectrum = envi_of(tmp_path, stored, "reflectance scale factor = 1000", offset=64)
    assert spectrum.reflectance == pytest.approx(CURVE, abs=5e-4) and "fraction" in spectrum.read_as
    gaps = CURVE.copy()
    gaps[[3, 9]] = -9999.0
    spectrum = envi_of(tmp_path, gaps, "data ignore value = -9999")
    assert spectrum.reflectance == pytest.approx(np.delete(CURVE, [3, 9]))
    good = ", ".join("0" if number == 5 else "1" for number in range(len(CURVE)))
    spectrum = envi_of(tmp_path, np.where(np.arange(len(CURVE)) == 5, 8.0, CURVE), f"bbl = {{{good}}}")
    assert spectrum.wavelength == pytest.approx(np.delete(UM, 5), abs=1e-5)


@pytest.mark.parametrize(("names", "title"), [("spectra names =", "1"), ("spectra names = slate roof", "slate roof")])
def test_the_name_of_a_single_spectrum_of_envi_needs_no_braces(tmp_path, names, title):
    assert envi_of(tmp_path, CURVE, names).title == title  # the last line of a name counts


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "utf-8-sig"])
def test_units_of_envi_in_any_encoding(tmp_path, encoding):
    spectrum = envi_of(tmp_path, CURVE, "wavelength units = \u00b5m", encoding)
    assert spectrum.wavelength == pytest.approx(UM, abs=1e-5) and spectrum.read_as.startswith("ENVI library, um")


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("reflectance scale factor = 1e-308", "says that its values are fraction, but they reach"),
        ("reflectance scale factor = 0", "the reflectance scale factor 0; allowed: as many, and above 0"),
        ("bbl = {1, 0}", "is no ENVI spectral library"),
        ("data ignore value = none", "could not convert string to float"),
        ("file type = ENVI Standard", "another file of ENVI"),
    ],
)
def test_a_wrong_header_of_envi_is_one_line(tmp_path, header, words):
    with pytest.raises(InputError, match=words) as caught:
        envi_of(tmp_path, CURVE, header)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "head, x, y, said, message",
    [
        (ECOSTRESS, UM, CURVE, Said(), "says that its values are percent, but they reach 0.499967; give --scale"),
        ("", UM, 400 * CURVE, Said(), "found values from .* when read as percent; allowed: 0 to 1"),
        ("", UM, CURVE - 0.4, Said(), "found values from -0.29"),
        ("", 1e4 / UM, CURVE, Said(), "says no unit of its first column"),
        ("", UM, CURVE, Said(unit="nm"), "found wavelengths of 0.0004 to 0.014 um when read in nm"),
        ("", UM - 0.4, CURVE, Said(unit="cm-1"), "found the wavenumber 0; allowed: above 0"),
        ("um,transmittance\n", UM, CURVE, Said(), "contains transmittance"),
        ("um,absorbance\n", UM, CURVE, Said(), "contains absorbance; allowed: reflectance, emissivity or absorptance"),
        ("", UM, 5 * CURVE, Said(), "values, up to 2.49.*, are fractions or percent; give --scale"),
        ("", UM[:5], CURVE[:5], Said(), "found 5 points"),
        ("no numbers at all\n", [], [], Said(), "found 0 points"),
        ("", UM, np.where(UM > 1, CURVE, np.nan), Said(), None),
    ],
)
def test_words_for_what_is_wrong(tmp_path, head, x, y, said, message):
    file = write(tmp_path / "spectrum.txt", x, y, head)
    if message is None:
        assert read_spectrum(file, said).wavelength[0] > 1.0
        return
    with pytest.raises(InputError, match=message) as caught:
        read_spectrum(file, said)
    assert str(caught.value).startswith(str(file))
