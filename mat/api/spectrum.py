"""Spectra of lines of sight through a standard atmosphere, a sounding or the air of a job's state."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from importlib import metadata
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
import yaml

from skyshine.mat.api.air import described_air, on_the_day, source_on_the_day, state_air, with_air_keys
from skyshine.mat.api.arguments import number, numbers, wavenumber_limits
from skyshine.mat.api.spectrum_comparison import SpectrumComparison, compared
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable, default_water_continuum
from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM, SpectralPoints
from skyshine.mat.atmosphere.spectra.spectrum import LineSpectrum, line_spectrum
from skyshine.mat.tables.dataset import Column, dataset
from skyshine.mat.tables.other_spectra import read_other_spectrum
from skyshine.mat.tables.result import Chart, Panel, Result
from skyshine.mat.tables.spectrum_file import IRRADIANCE, RADIANCE, write_spectrum, write_spectrum_csv
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    import xarray

    from skyshine.mat.spectroscopy.line_points import LineByLinePoints


@dataclass(frozen=True, eq=False)
class Spectrum(Result, LineSpectrum):
    """Spectra of lines of sight; the fields are those of `LineSpectrum`, arrays (..., B) over spectral bins.

    Attributes
    ----------
    attributes : dict of str
        What was computed, and from which data.
    coords : dict of str to (units, (n,) values)
        Arguments given as arrays, a dimension each of the arrays before the bins: visibility_km, altitude and range
        [km], elevation [degree]. Empty for a single line of sight.
    """

    attributes: dict[str, str] = field(default_factory=dict)
    coords: dict[str, Column] = field(default_factory=dict)

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions of the spectra, wavenumber last."""
        return (*self.coords, "wavenumber")

    @property
    def wavelength(self) -> npt.NDArray[np.float64]:
        """Middle of each bin, (B,) um."""
        return 1e4 / self.wavenumber

    @property
    def columns(self) -> dict[str, Column]:
        """Units and values (..., B) of each spectrum by name, wavenumber (B,) first."""
        return {
            "wavenumber": ("cm^-1", self.wavenumber),
            "transmittance": ("1", self.transmittance),
            **{f"transmittance_{gas}": ("1", values) for gas, values in self.transmittance_by_gas.items()},
            "transmittance_rayleigh": ("1", self.transmittance_rayleigh),
            "transmittance_aerosol": ("1", self.transmittance_aerosol),
            "path_thermal": (RADIANCE, self.path_thermal),
            "path_scattered": (RADIANCE, self.path_scattered),
            "sky_irradiance": (IRRADIANCE, self.sky_irradiance),
            "direct_irradiance": (IRRADIANCE, self.direct_irradiance),
            **({"night_sky": (RADIANCE, self.night_sky)} if np.any(self.night_sky > 0) else {}),
        }

    def to_xarray(self) -> xarray.Dataset:
        """The spectra as an `xarray.Dataset` over `dims`, with wavelength, and the length and end of each line."""
        columns = {**self.columns, "wavelength": ("um", self.wavelength)}
        wavenumber, wavelength = columns.pop("wavenumber"), columns.pop("wavelength")
        lines = tuple(self.coords)
        return dataset(
            {**self.coords, "wavenumber": wavenumber},
            {
                **{name: (self.dims, units, values) for name, (units, values) in columns.items()},
                "wavelength": (("wavenumber",), *wavelength),
                "path_length": (lines, "km", np.asarray(self.range) / 1e3),
                "ends_at_ground": (lines, "1", self.ground),
            },
            self.attributes,
        )

    def plot(self) -> Chart:
        """The spectra as a picture; of a single line of sight, that which `mat spectrum --out NAME.png` writes.

        Raises
        ------
        InputError
            There are more lines of sight than a chart can distinguish.
        """
        if self.coords:
            return super().plot()
        from skyshine.mat.tables.pictures import spectrum_figure

        return Chart(spectrum_figure(self))

    def _panels(self) -> list[Panel]:
        def lines(values: npt.NDArray[np.float64], name: str) -> dict[str, npt.NDArray[np.float64]]:
            return {f"{label} {name}".strip(): row for label, row in zip(labels, values.reshape(rows, -1), strict=True)}

        points = itertools.product(*(values for _, values in self.coords.values()))
        labels = [", ".join(f"{key} {value:g}" for key, value in zip(self.coords, at, strict=True)) for at in points]
        rows = len(labels)
        light = lines(self.path_thermal, "thermal") | lines(self.path_scattered, "scattered")
        return [
            Panel(self.wavelength, "wavelength, µm", "transmittance", lines(self.transmittance, "")),
            Panel(self.wavelength, "wavelength, µm", f"path radiance, {RADIANCE}", light, logarithmic=True),
        ]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file of the format `spectrum` (HDF5, for a name that ends in .h5) or a CSV file (.csv).

        Raises
        ------
        InputError
            The name ends otherwise, the file cannot be written, or there are several lines of sight.
        """
        if self.coords:
            raise InputError(
                f"found lines of sight over {', '.join(self.coords)}; allowed: a single one; use"
                " to_xarray().to_netcdf(path)",
                file=path,
            )
        about = {"range_km": f"{self.range / 1e3:g}", "ends_at_ground": str(self.ground).lower(), **self.attributes}
        ending = os.path.splitext(path)[1].lower()
        if ending == ".h5":
            version, job = about.pop("data_version"), about.pop("job")
            write_spectrum(path, self.columns, about, version, job)
        elif ending == ".csv":
            write_spectrum_csv(
                path,
                self.columns,
                {"filetype": "spectrum", "generator": f"skyshine {metadata.version('skyshine')}", **about},
            )
        else:
            raise InputError("is no name for a spectrum; allowed: a name that ends in .h5 or .csv", file=path)

    def compare(self, file: str | os.PathLike[str]) -> SpectrumComparison:
        """The spectrum beside that of a file, in bins that both cover.

        Parameters
        ----------
        file : path
            tape7, ``.tp7``, tape7.scn or ``.7sc`` of MODTRAN 4 and 5 (its first spectrum), or CSV of
            ``wavenumber[cm^-1]`` or ``wavelength[um]``, ``transmittance``, ``path_thermal`` and ``path_scattered``.

        Returns
        -------
        SpectrumComparison
            Both spectra, their difference, its rms and their means over the bins.

        Raises
        ------
        InputError
            The file cannot be read or has no bin in common, or there are several lines of sight.

        Examples
        --------
        >>> import skyshine.mat
        >>> line = skyshine.mat.spectrum(range=1, wavenumber=(900, 1000))
        >>> line.save("line.csv")
        >>> line.compare("line.csv").rms["transmittance"] < 1e-7
        True
        """
        if self.coords:
            raise InputError(f"found lines of sight over {', '.join(self.coords)}; allowed: a single one; compare each")
        return compared(self, read_other_spectrum(file))

    def __repr__(self) -> str:
        bins = f"<Spectrum {self.wavenumber[0]:g} to {self.wavenumber[-1]:g} cm^-1, {self.wavenumber.size} bins,"
        mean = f"mean transmittance {self.transmittance.mean():.4f}>"
        if self.coords:
            sizes = " x ".join(f"{len(values)} {name}" for name, (_, values) in self.coords.items())
            return f"{bins} lines of sight: {sizes}; {mean}"
        if np.isinf(self.range):
            return f"{bins} to space; {mean}"
        return f"{bins} {self.range / 1e3:.4g} km{' to the ground' if self.ground else ''}; {mean}"


@with_air_keys
def spectrum(
    *,
    wavenumber: tuple[float, float] | None = None,
    wavelength: tuple[float, float] | None = None,
    job: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    state: int = 1,
    altitude: npt.ArrayLike | None = None,
    elevation: npt.ArrayLike = 0.0,
    range: npt.ArrayLike | Literal["space"] = math.inf,
    resolution: float | None = None,
    visibility_km: npt.ArrayLike | None = None,
    source: Literal["sun", "moon", "none"] = "sun",
    source_elevation: float = 45.0,
    source_azimuth: float = 0.0,
    water_continuum: str | None = None,
    line_by_line: str | os.PathLike[str] | None = None,
    continua: str | os.PathLike[str] = "lowtran7",
    **air: Any,
) -> Spectrum:
    """Transmittance and radiance along lines of sight.

    Each of `visibility_km`, `altitude`, `elevation` and `range` may be a one-dimensional array: it is then a dimension
    of the result, in this order, before that of the bins. Lines of sight through one air share the solution of its
    scattered light, with which scattered radiance differs from that of a line alone by less than 0.1 %.

    Parameters
    ----------
    wavenumber, wavelength : (low, high)
        Limits in cm^-1 or in um; one of both.
    job : path or mapping, optional
        Job whose state gives air, ground, aerosol, clouds and rain, and whose day gives the Sun's distance and the
        Moon's phase; it replaces all parameters that describe the air here.
    state : int
        Number of the state of the job, counted from 1.
    altitude : float or (A,) array, optional
        Altitude of the observer above sea level [km]; by default the ground: 0, the bottom of the sounding, or the
        job's site.
    elevation : float or (E,) array
        Elevation of the line of sight above the horizontal [degree]; from the ground at least 0.
    range : float or (R,) array
        [km]; infinite or ``'space'`` for space.
    resolution : float, optional
        Bins [cm^-1], a multiple of the band model's intervals: 1 between 700 and 3400 cm^-1, else 5 and more, which is
        the default. With `line_by_line` 0.01 or more, by
        default 1, a whole number of them between the limits.
    visibility_km : float or (V,) array, optional
        [km]; by default that of the aerosol.
    source : {'sun', 'moon', 'none'}
        Sun at 1 au, full Moon at its mean distance; with `job` those of its day.
    source_elevation, source_azimuth : float
        Geometric elevation, and azimuth from the line of sight [degree].
    water_continuum : str, optional
        Continuum of water vapour; by default the job's, or mt_ckd_4.3_closure.
    line_by_line : path, optional
        Folder of HITRAN 160-column records (01_*.par, 02_*.par, ...; .gz or .xz too), whose lines are summed in place
        of the band model (extra `spectroscopy`): about a second for each cm^-1. The package ships cross sections and no
        lines. Gases without records over the range are those of the band model, averaged over its intervals.
    continua : path or 'lowtran7'
        Continua of N2, O2 and CO2, with `line_by_line`: the packaged ones of LOWTRAN7 (N2, O2), or a folder of MT_CKD's
        files.
    **air
        Keys of a job's state that describe its air, as a job writes them: preset, profile, sounding, humidity_scale,
        co2_ppm, gases, aerosol, aerosol_table, aerosol_optical_depth, angstrom_exponent, aerosol_layers, air_mass,
        stratosphere, season, clouds, rain, night_sky, sea_temperature_c, surface_albedo, and wind_speed_m_s of its
        weather. By default the profile is midlatitude_summer, above a sounding us_standard, and all else as in a job.
        Paths are relative to the working directory. The ground has the temperature of the lowest air.

    Returns
    -------
    Spectrum
        Arrays (B,) of a single line of sight, up to (V, A, E, R, B) of arrays; `dims` and `coords` name them.

    Raises
    ------
    InputError
        A name is unknown, a number is not finite or outside its limits, an array is empty or has two dimensions, the
        line of sight starts below the ground or looks down from it, or the air is described beside a job.

    Examples
    --------
    >>> import skyshine.mat
    >>> line = skyshine.mat.spectrum(profile="tropical", range=5, wavenumber=(900, 1000), source="none")
    >>> line.transmittance.shape
    (20,)
    >>> bool((line.path_scattered == 0).all())
    True
    >>> lines = skyshine.mat.spectrum(elevation=[0, 30, 90], range=[1, "space"], wavenumber=(900, 1000))
    >>> lines.dims, lines.transmittance.shape
    (('elevation', 'range', 'wavenumber'), (3, 2, 20))
    """
    described = {key: value for key, value in {**air, "visibility_km": visibility_km}.items() if value is not None}
    if job is None and state != 1:
        raise InputError(f"found state {state} without a job; allowed: a state of a job; give the job")
    low, high = wavenumber_limits(wavenumber, wavelength)
    source_elevation, source_azimuth = (
        number(name, value)
        for name, value in (("source_elevation", source_elevation), ("source_azimuth", source_azimuth))
    )
    loaded = None if job is None else on_the_day(job, state, described)
    visibilities = None if visibility_km is None else numbers("visibility_km", visibility_km)
    if loaded is not None:
        airs = [state_air(loaded, state, low, high)]
    elif visibilities is None:
        airs = [described_air(described)]
    else:
        airs = [described_air({**described, "visibility_km": value}) for value in visibilities.ravel().tolist()]
    bottom = airs[0].surface_altitude / 1e3
    sights = {
        "altitude": np.array(bottom) if altitude is None else numbers("altitude", altitude),
        "elevation": numbers("elevation", elevation),
        "range": numbers("range", range, infinite=True),
    }
    _check_looking_up(bottom, **sights)
    if water_continuum is None:
        water_continuum = default_water_continuum() if loaded is None else loaded.trimmed.water_continuum
    table = AbsorptionTable.open(water_continuum=water_continuum)
    points = _narrow(table, low, high, resolution) if line_by_line is None else table.points(low, high)
    stated = {"data_version": f"absorption {table.version}", "absorption": f"band model, {table.name}".rstrip(", ")}
    if line_by_line is not None:
        points = _summed(points, line_by_line, continua, low, high, 1.0 if resolution is None else resolution)
        stated["absorption"] = _from_lines(points)
        resolution = None  # the intervals of these points are the bins
    irradiance = source_on_the_day(source, points, None if loaded is None else loaded.trimmed)
    lines = [
        line_spectrum(
            air,
            points,
            irradiance,
            **_of_one_shape(**sights),
            source_elevation=np.radians(source_elevation),
            source_azimuth=np.radians(source_azimuth),
            resolution=resolution,
        )
        for air in airs
    ]
    arguments = {"wavenumber": [low, high], **sights, **air, "visibility_km": visibilities}
    arguments |= {"source": source, "source_elevation": source_elevation, "source_azimuth": source_azimuth}
    arguments |= {"job": job if isinstance(job, str | None) else "in memory", "state": None if job is None else state}
    recorded = {
        key: value if isinstance(value, str | int | float | list | dict) else str(value)
        for key, value in ((key, _plain(value)) for key, value in arguments.items())
        if value is not None
    }
    stated["job"] = yaml.safe_dump(recorded, sort_keys=False)
    given = ({} if visibilities is None else {"visibility_km": visibilities}) | sights
    coords = {name: (_UNITS[name], values) for name, values in given.items() if values.ndim}
    along_visibility = "visibility_km" in coords
    return Spectrum(**_joined(lines, along_visibility), attributes=stated, coords=coords)


_UNITS = {"visibility_km": "km", "altitude": "km", "elevation": "degree", "range": "km"}


def _joined(lines: Sequence[LineSpectrum], stacked: bool) -> dict[str, Any]:
    """Fields of the spectra of several airs, stacked along a dimension before the others; or those of the only one."""
    if not stacked:
        return {item.name: getattr(lines[0], item.name) for item in fields(lines[0])}
    joined = {
        item.name: np.stack([getattr(line, item.name) for line in lines])
        for item in fields(lines[0])
        if item.name not in ("wavenumber", "transmittance_by_gas")
    }
    gases = {gas: np.stack([line.transmittance_by_gas[gas] for line in lines]) for gas in lines[0].transmittance_by_gas}
    return joined | {"wavenumber": lines[0].wavenumber, "transmittance_by_gas": gases}


def _of_one_shape(
    altitude: npt.NDArray[np.float64], elevation: npt.NDArray[np.float64], range: npt.NDArray[np.float64]
) -> dict[str, npt.NDArray[np.float64]]:
    """Altitudes [km], elevations [degree] and ranges [km], each a number or an array, as arguments of `line_spectrum`,
    broadcast to a dimension for each array.
    """
    sights = {"altitude": altitude * 1e3, "elevation": np.radians(elevation), "distance": range * 1e3}
    mesh = iter(np.meshgrid(*(values for values in sights.values() if values.ndim), indexing="ij"))
    return {name: next(mesh) if values.ndim else values for name, values in sights.items()}


def _check_looking_up(
    bottom: float,
    altitude: npt.NDArray[np.float64],
    elevation: npt.NDArray[np.float64],
    range: npt.NDArray[np.float64],
) -> None:
    """Refuse lines of sight from the ground [km] into it, which end where they begin."""
    if np.any(range > 0) and np.any(elevation < 0) and np.any(np.abs(altitude - bottom) < 1e-9):
        raise InputError(
            f"found elevation {elevation.min():g} of an observer on the ground at {bottom:g} km, whose line of sight"
            " ends where it begins; allowed: at least 0 degree there; raise the altitude"
        )


def _narrow(table: AbsorptionTable, low: float, high: float, resolution: float | None) -> SpectralPoints:
    """Points of the table, or of its narrow intervals where the bins [cm^-1] are no multiple of the others."""
    points = table.points(low, high)
    if resolution is None or table.fine is None or np.all(resolution % np.diff(points.interval_edges, axis=1) == 0):
        return points
    covered = any(start <= low and high <= stop for start, stop in table.fine.coverage)
    return table.fine.points(low, high) if covered else points


def _summed(
    band: SpectralPoints,
    lines: str | os.PathLike[str],
    continua: str | os.PathLike[str],
    low: float,
    high: float,
    width: float,
) -> LineByLinePoints:
    """Points of bins of a width [cm^-1] at which the lines of a folder are summed."""
    # Lines are summed with numba, which a plain installation lacks.
    from skyshine.mat.spectroscopy.continua import Continua
    from skyshine.mat.spectroscopy.gases import LineLibrary
    from skyshine.mat.spectroscopy.line_points import LineByLinePoints
    from skyshine.mat.spectroscopy.lowtran_continua import LowtranContinua

    of_gases = LowtranContinua() if continua == LowtranContinua.name else Continua(continua)
    return LineByLinePoints.of(band, LineLibrary(lines), of_gases, low, high, width)


def _from_lines(points: LineByLinePoints) -> str:
    """What absorption is made of, in words."""
    even = [name for name in points.absorbing if name not in points.summed and name != CONTINUUM]
    others = f"; by interval means of the band model: {', '.join(even)}" if even else ""
    return f"line by line: {', '.join(points.summed)}{others}"


def _plain(value: Any) -> Any:
    """Numbers and arrays of numpy as those of Python, which YAML knows."""
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value
