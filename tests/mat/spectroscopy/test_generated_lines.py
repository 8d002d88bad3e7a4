"""Generated lines of ozone and nitrous oxide against sums, partition functions and HITRAN."""

import numpy as np
import pytest

from mat.maintain.lines.rotors import nitrous_oxide, ozone
from mat.maintain.lines.rotors.asymmetric import levels
from mat.maintain.lines.rotors.force_field import normal_modes
from mat.maintain.lines.rotors.linear import LinearState, transitions
from mat.maintain.lines.rotors.records import write
from skyshine.mat.radiometry.constants import C2
from skyshine.mat.spectroscopy.gases import GeneratedLibrary
from skyshine.mat.spectroscopy.lines import LineList, read_lines
from skyshine.mat.spectroscopy.partition import reference_sum

pytest.importorskip("hapi")


def line_list(bands):
    """All lines of bands of one molecule, ordered by wavenumber."""
    isotopologue = np.concatenate([np.full(band.wavenumber.size, band.isotopologue, np.int16) for band in bands])
    names = ("wavenumber", "strength", "air_width", "self_width", "lower_energy", "temperature_exponent", "shift")
    arrays = {name: np.concatenate([getattr(band, name) for band in bands]) for name in names}
    lines = LineList(molecule=bands[0].molecule, isotopologue=isotopologue, **arrays)
    return lines.select(np.argsort(lines.wavenumber, kind="stable"))


@pytest.fixture(scope="module")
def nitrous():
    return nitrous_oxide.band_lines()


def test_levels_of_ozone_give_its_partition_sum():
    rotation = sum((2 * j + 1) * np.exp(-C2 * levels((ozone.GROUND,), j).energy / 296.0).sum() for j in range(85))
    vibration = np.prod([1 / -np.expm1(-C2 * ozone.ORIGINS[name] / 296.0) for name in ("100", "010", "001")])
    assert rotation * vibration == pytest.approx(reference_sum(3, 1), rel=1e-3)


def test_force_field_gives_the_wavenumbers_and_centrifugal_distortion():
    modes = normal_modes()
    # Harmonic wavenumbers of Barbe, Secroun and Jouve 1974, J. Mol. Spectrosc. 49, 171.
    assert modes.wavenumber == pytest.approx([1134.9, 716.0, 1089.2], rel=0.003)
    assert modes.zeta[0, 2] ** 2 + modes.zeta[1, 2] ** 2 == pytest.approx(1.0)
    # Delta_K + Delta_JK + Delta_J is the change of A by centrifugal forces along a: sum of squared derivatives over w.
    along_a = 0.5 * np.sum(modes.inertia[:, 2, 2] ** 2 / modes.wavenumber)
    assert along_a == pytest.approx(sum(ozone.GROUND.quartic[:3]), rel=0.05)


def test_substituted_ozone_has_its_rotational_constants():
    # A of 16O 18O 16O and 16O 16O 18O: Flaud et al. 1990.
    for species, expected in ((ozone.INNER_HEAVY, 3.2905), (ozone.OUTER_HEAVY, 3.4882)):
        assert ozone.state("000", species).rotation[0] == pytest.approx(expected, rel=3e-4)


@pytest.mark.validation  # 6 s: all bands of three isotopologues; the packaged lines change with their program alone
def test_ozone_bands_have_the_published_strengths():
    bands = [each for each in ozone.bands() if {"001", "011", "010"} & set(each.upper)]
    by_name = {(band.upper, band.lower): band for one in bands for band in ozone.band_lines(one)}
    for name in ("001", "100", "010"):
        total = by_name[name, "000"].strength.sum() / ozone.MAIN.abundance
        assert total == pytest.approx(ozone.STRENGTHS[name], rel=0.01)
    # A band from 010 has the strength of the fundamental times the share of molecules in 010.
    occupied = np.exp(-C2 * ozone.ORIGINS["010"] / 296.0)
    ratio = by_name["011", "010"].strength.sum() / by_name["001", "000"].strength.sum()
    assert ratio == pytest.approx(occupied * 1025.59 / 1042.08, rel=0.03)
    # Coriolis coupling strengthens the R branch of v1 (levels of small Ka, which are little mixed).
    v1 = by_name["100", "000"]
    step = np.array([int(up[:3]) - int(low[:3]) for up, low in zip(v1.upper_rotation, v1.lower_rotation, strict=True)])
    pure = np.array(
        [max(int(up[3:6]), int(low[3:6])) <= 4 for up, low in zip(v1.upper_rotation, v1.lower_rotation, strict=True)]
    )
    assert v1.strength[pure & (step == 1)].sum() > 1.5 * v1.strength[pure & (step == -1)].sum()


def test_nitrous_oxide_bands_have_the_published_strengths(nitrous):
    by_name = {(band.upper, band.lower): band for band in nitrous}
    for name, expected in nitrous_oxide.STRENGTHS.items():
        total = by_name[name, "0000"].strength.sum() / nitrous_oxide.ABUNDANCE
        assert total == pytest.approx(expected, rel=2e-3)


def test_a_parallel_and_a_perpendicular_band_have_their_honl_london_factors():
    ground, sigma = LinearState("0000", (0.0, 0.4, 0.0, 0.0)), LinearState("1000", (1000.0, 0.4, 0.0, 0.0))
    pi = LinearState("0110", (500.0, 0.4, 0.0, 0.0), (500.0, 0.4, 0.0, 0.0))
    parallel, perpendicular = transitions(ground, sigma, 20), transitions(ground, pi, 20)
    expected = np.where(parallel["step"] == 1, parallel["j"] + 1, parallel["j"])
    assert parallel["factor"] == pytest.approx(expected)
    assert not np.any(parallel["step"] == 0)
    j, step = perpendicular["j"], perpendicular["step"]
    assert perpendicular["factor"] == pytest.approx(np.select([step == 0, step == 1], [2 * j + 1, j + 2], j - 1))


def test_records_are_read_as_they_were_written(nitrous, tmp_path):
    write(tmp_path / "04_generated.par.gz", nitrous, 4, 1110.0, 1345.0)
    read, made = read_lines(tmp_path / "04_generated.par.gz"), line_list(nitrous).between(1110.0, 1345.0)
    assert read.wavenumber == pytest.approx(made.wavenumber, abs=1e-6)
    assert read.strength == pytest.approx(made.strength, rel=1e-3)
    assert read.air_width == pytest.approx(made.air_width, abs=6e-5)
    assert read.shift == pytest.approx(made.shift, abs=1e-6)
    library = GeneratedLibrary(tmp_path)
    assert [gas.name for gas in library.gases] == ["N2O"]
    assert library.covers("N2O", 1280.0, 1285.0)
    assert not library.covers("N2O", 2200.0, 2205.0)


@pytest.mark.shared_data
def test_the_method_gives_hitrans_lines_at_four_and_a_half_micrometres(shared_data):
    """v3 of nitrous oxide, which HITRAN's list holds: positions, relative strengths and widths by the same program."""
    hitran = read_lines(shared_data / "lines" / "04_prism.par.gz")
    upper = LinearState("0001", (2223.7568, 0.41555948, 1.75456e-07, -1.500e-14))
    made = transitions(nitrous_oxide.STATES["0000"], upper, 70)
    squared = made["factor"]
    strength = made["wavenumber"] * squared * np.exp(-C2 * made["lower_energy"] / 296.0)
    strength *= -np.expm1(-C2 * made["wavenumber"] / 296.0)
    nearest = np.abs(hitran.wavenumber[:, None] - made["wavenumber"]).argmin(axis=0)
    near = np.abs(hitran.wavenumber[nearest] - made["wavenumber"])
    ratio = hitran.strength[nearest] / strength
    strong = hitran.strength[nearest] > 1e-20
    assert strong.sum() > 80
    assert near[strong].max() < 5e-4
    assert np.std(ratio[strong]) / np.mean(ratio[strong]) < 0.02
