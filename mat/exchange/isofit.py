"""Look-up tables for ISOFIT: the atmosphere of an imaging spectrometer over a grid of water vapour and aerosol.

Names, dimensions and units are those that ISOFIT's readers ask for (isofit 3.x ``radiative_transfer/luts.py``, 4.x
``atmosphere/atmosphere.py``, class Keys): arrays over (wl, then the grid), wl in nm, ``RT_mode`` "transm". Radiance at
the sensor over a Lambertian ground of reflectance rho and emission L_s is there

    L = (rhoatm + (dir-dir + dif-dir + dir-dif + dif-dif) rho / (1 - sphalb rho)) mu F / pi
      + thermal_upwelling + thermal_downwelling rho / (1 - sphalb rho) + (transm_up_dir + transm_up_dif) L_s,

with F ``solar_irr`` and mu ``coszen``. It is solved for by computing each line of sight over a black ground and over
one of reflectance `ALBEDO` (the two-albedo method; Vermote et al. 1997, IEEE TGRS 35:675, for the terms): at every
spectral point, before means over a channel are taken, so that ``dir-dir`` and the other coupling terms are means of
products and not products of means.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import scipy

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.spectra.spectrum import line_points
from skyshine.mat.atmosphere.state.gas_amounts import CARBON_DIOXIDE_PPM, GasAmounts
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.scene.bands import absorption_table
from skyshine.schemas.arrays import Floats, Reals
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file

FILETYPE = "isofit_lut"
# Chosen: bright enough that differences keep their digits, and one of the two of ISOFIT's own runs of MODTRAN.
ALBEDO = 0.5
_REACH = 1.5  # full widths from the middle of a channel to where its Gaussian ends, at 1/500 of the peak
_MICROWATT = 100.0  # uW cm^-2 in a W m^-2
_NOTHING = 1e-12  # share of the light outside the atmosphere: less than this at the ground has no effect
LONG_NAMES = {
    "rhoatm": "path reflectance, of scattered sunlight over black ground",
    "sphalb": "spherical albedo of the atmosphere from below, mean over the light that reaches ground and sensor",
    "transm_down_dir": "transmittance of direct sunlight to the ground",
    "transm_down_dif": "transmittance of scattered sunlight to the ground, over black ground",
    "transm_up_dir": "transmittance from the ground to the sensor",
    "transm_up_dif": "transmittance by scattering from the ground around to the sensor",
    "thermal_upwelling": "radiance that the air emits towards the sensor, over cold black ground",
    "thermal_downwelling": "radiance of the sky's emission at the sensor, by ground of reflectance 1 without return",
    "dir-dir": "mean product of transm_down_dir and transm_up_dir",
    "dif-dir": "mean product of transm_down_dif and transm_up_dir",
    "dir-dif": "mean product of transm_down_dir and transm_up_dif",
    "dif-dif": "mean product of transm_down_dif and transm_up_dif",
}
GRID = {
    "H2OSTR": ("g cm^-2", "water vapour from the ground to space"),
    "AOT550": ("1", "vertical optical depth of aerosol at 0.55 um"),
    "surface_elevation_km": ("km", "ground above sea level"),
    "observer_zenith": ("degree", "of the line from the sensor, 0 straight down"),
    "relative_azimuth": ("degree", "of the Sun from the line of sight"),
}


@dataclass(frozen=True)
class Lut:
    """What a look-up table is computed for.

    Attributes
    ----------
    wavelength, fwhm : tuple of float
        Channels [nm].
    water, optical_depth, ground, observer_zenith, relative_azimuth : tuple of float
        The grid: g cm^-2, 1, km, degree, degree.
    solar_zenith : float
        [degree]
    altitude : float
        Altitude of the sensor above sea level [km].
    profile, aerosol : str
        A standard profile and an aerosol model.

    Examples
    --------
    >>> grid = Lut(wavelength=(550, 560), fwhm=(10, 10), water=(1, 2), optical_depth=(0.1,))
    >>> grid.size
    2
    """

    wavelength: tuple[float, ...]
    fwhm: tuple[float, ...]
    water: tuple[float, ...]
    optical_depth: tuple[float, ...]
    ground: tuple[float, ...] = (0.0,)
    observer_zenith: tuple[float, ...] = (0.0,)
    relative_azimuth: tuple[float, ...] = (0.0,)
    solar_zenith: float = 45.0
    altitude: float = 100.0
    profile: str = "midlatitude_summer"
    aerosol: str = "rural"

    def __post_init__(self) -> None:
        for name, values in zip(GRID, self.grid, strict=True):
            if not values or any(b <= a for a, b in pairwise(values)):
                raise InputError(f"{name}: found {list(values)}; allowed: values that increase, one at least")
        if not self.wavelength or any(b <= a for a, b in pairwise(self.wavelength)):
            raise InputError("found wavelengths that do not increase; allowed: nm, in increasing order")
        if len(self.fwhm) != len(self.wavelength) or min(self.fwhm) <= 0:
            raise InputError("found a channel without a width; allowed: a full width at half maximum above 0 nm")
        if not 0 <= self.solar_zenith < 85:
            raise InputError(f"found the solar zenith {self.solar_zenith:g}; allowed: 0 to below 85 degree")
        if not (self.observer_zenith[0] >= 0 and self.observer_zenith[-1] <= 70):
            raise InputError(f"observer_zenith: found {list(self.observer_zenith)}; allowed: 0 to 70 degree")

    @property
    def grid(self) -> tuple[tuple[float, ...], ...]:
        """Values of each axis, in the order of `GRID`."""
        return self.water, self.optical_depth, self.ground, self.observer_zenith, self.relative_azimuth

    @property
    def size(self) -> int:
        """Number of points of the grid."""
        return int(np.prod([len(values) for values in self.grid]))


def write_lut(lut: Lut, path: Path, advance: Callable[[int], object] = lambda _: None) -> None:
    """Compute a look-up table and write it as netCDF-4.

    Parameters
    ----------
    lut : Lut
    path : Path
    advance : callable, optional
        Called with 1 when a point of the grid is computed.

    Raises
    ------
    InputError
        A name is unknown, a wavelength is not covered, the air cannot contain the water, or the file cannot be written.

    Examples
    --------
    >>> import skyshine.mat
    >>> grid = skyshine.mat.Lut(wavelength=(550, 560), fwhm=(10, 10), water=(1, 2), optical_depth=(0.1,))
    >>> skyshine.mat.lut(grid, Path("lut.nc"))  # doctest: +SKIP
    """
    table = absorption_table()
    reach = _REACH * np.array(lut.fwhm)
    low, high = float(np.min(lut.wavelength - reach)), float(np.max(lut.wavelength + reach))
    points = table.points(1e7 / high, 1e7 / low)
    channels = Channels.of(points, np.array(lut.wavelength), np.array(lut.fwhm))
    axis_values = {
        name: values for name, values in zip(GRID, lut.grid, strict=True) if len(values) > 1 or name in _ALWAYS
    }
    results: dict[str, Floats] = {}
    for number, (water, depth, ground, zenith, azimuth) in enumerate(product(*lut.grid)):
        air = AtmosphericState.from_profile(
            lut.profile,
            surface_altitude=1e3 * ground,
            gas_amounts=GasAmounts(ppm={"CO2": CARBON_DIOXIDE_PPM}, water_column=10.0 * water),
            aerosol=Aerosol(lut.aerosol, optical_depth=None if lut.aerosol == "none" else depth),
        )
        for name, values in point_terms(air, points, channels, lut, zenith, azimuth).items():
            results.setdefault(name, np.empty((len(lut.wavelength), lut.size)))[:, number] = values
        advance(1)
    shape = (len(lut.wavelength), *(len(values) for values in axis_values.values()))
    dims = ("wl", *axis_values)
    axes = {"wl": Axis(np.array(lut.wavelength), "nm", "middle of the channel")}
    axes |= {name: Axis(np.array(values), *GRID[name]) for name, values in axis_values.items()}
    variables = {
        name: Variable(dims, values.reshape(shape), _units(name), LONG_NAMES[name]) for name, values in results.items()
    }
    variables["solar_irr"] = Variable(("wl",), channels.solar, "uW cm^-2 nm^-1", "solar irradiance at 1 au")
    variables["fwhm"] = Variable(("wl",), np.array(lut.fwhm), "nm", "full width of the channel at half maximum")
    solzen, coszen = lut.solar_zenith, float(np.cos(np.radians(lut.solar_zenith)))
    variables["solzen"] = Variable((), np.float64(solzen), "degree", "zenith angle of the Sun at the ground")
    variables["coszen"] = Variable((), np.float64(coszen), "1", "its cosine")
    fixed = {name: values[0] for name, values in zip(GRID, lut.grid, strict=True) if name not in axis_values}
    attributes = {
        "RT_mode": "transm",
        "ISOFIT status": "success",
        "atmosphere": lut.profile,
        "aerosol": lut.aerosol,
        "observer_altitude_km": lut.altitude,
        **fixed,
    }
    job = "\n".join(f"{name}: {getattr(lut, name)}" for name in lut.__dataclass_fields__)
    header = Header(FILETYPE, f"absorption {table.version}", job, "look-up table for ISOFIT")
    write_file(path, Group(axes, variables, {}, attributes), header)


_ALWAYS = ("H2OSTR", "AOT550")  # ISOFIT's own state vector


@dataclass(frozen=True, eq=False)
class Channels:
    """Gaussian channels over the spectral points.

    Attributes
    ----------
    weight : (C, P) array
        Weights of means over wavelength.
    solar_weight : (C, P) array
        Weights of means over wavelength, multiplied by sunlight.
    solar : (C,) array
        Irradiance of the Sun at 1 au [uW cm^-2 nm^-1].
    irradiance : (P,) array
        The same at the points [W m^-2 (cm^-1)^-1].
    per_nm : (P,) array
        uW cm^-2 nm^-1 for a W m^-2 (cm^-1)^-1.
    """

    weight: Floats
    solar_weight: Floats
    solar: Floats
    irradiance: Floats
    per_nm: Floats

    @classmethod
    def of(cls, points: SpectralPoints, wavelength: Floats, fwhm: Floats) -> Channels:
        """Channels of middles and full widths at half maximum (C,) [nm].

        Raises
        ------
        InputError
            A channel is narrower than an interval of the band model, or reaches beyond it.
        """
        low, high = points.interval_edges.T
        long, short = 1e7 / low, 1e7 / high
        sigma = (fwhm / np.sqrt(8.0 * np.log(2.0)))[:, None]

        def below(edge: Floats) -> Floats:
            bounded = np.clip(edge[None, :] - wavelength[:, None], -_REACH * fwhm[:, None], _REACH * fwhm[:, None])
            share: Floats = 0.5 * scipy.special.erf(bounded / (np.sqrt(2.0) * sigma))
            return share

        share = below(long) - below(short)
        widest = np.where(share > 1e-3, (long - short)[None, :], 0.0).max(axis=1)
        if np.any(narrow := fwhm < widest):
            at = int(np.argmax(narrow))
            raise InputError(
                f"found a channel at {wavelength[at]:g} nm of {fwhm[at]:g} nm; allowed: {widest[at]:.2g} nm, an"
                " interval of the band model there, or wider"
            )
        weight = share[:, points.interval] * points.weight
        weight /= weight.sum(axis=1, keepdims=True)
        middle, width = (low + high) / 2, high - low
        irradiance = solar_irradiance(middle, width)[points.interval]
        per_nm = _MICROWATT * points.wavenumber**2 / 1e7
        light = weight * (irradiance * per_nm)
        return cls(weight, light / light.sum(axis=1, keepdims=True), light.sum(axis=1), irradiance, per_nm)


def point_terms(
    air: AtmosphericState, points: SpectralPoints, channels: Channels, lut: Lut, zenith: float, azimuth: float
) -> dict[str, Floats]:
    """The arrays (C,) of one point of the grid, by ISOFIT's names; `zenith` and `azimuth` of the line in degree."""
    mu, light = np.cos(np.radians(lut.solar_zenith)), channels.irradiance

    def over(albedo: float) -> dict[str, Reals]:
        values, _ = line_points(
            replace(air, surface_albedo=albedo),
            points,
            light,
            altitude=1e3 * lut.altitude,
            elevation=np.radians(zenith - 90.0),
            distance=np.inf,
            source_elevation=np.radians(90.0 - lut.solar_zenith),
            source_azimuth=np.radians(azimuth),
        )
        return values

    black, bright = over(0.0), over(ALBEDO)
    direct, arriving = mu * black["direct_irradiance"], mu * bright["direct_irradiance"] + bright["sky_scattered"]
    diffuse = black["sky_scattered"]
    illuminated = arriving > _NOTHING * light
    safe = np.where(illuminated, arriving, 1.0)
    # E(a) = E(0) / (1 - a S), and what a ground of radiance a E(a) / pi adds to the path.
    spherical = np.where(illuminated, (arriving - direct - diffuse) / (ALBEDO * safe), 0.0)
    up_diffuse = np.where(
        illuminated, np.pi * (bright["path_scattered"] - black["path_scattered"]) / (ALBEDO * safe), 0.0
    )
    up_direct, outside = black["transmittance"], mu * light
    down = {"dir": direct / outside, "dif": diffuse / outside}
    up = {"dir": up_direct, "dif": up_diffuse}
    emitted = planck_wavenumber(points.wavenumber, air.surface_temperature)
    # What the black ground emitted came back from the air and into the path; it is taken away.
    sky = black["sky_thermal"] - spherical * np.pi * emitted
    path = black["path_thermal"] - up_diffuse * emitted

    def mean(values: Reals) -> Floats:
        averaged: Floats = channels.weight @ values
        return averaged

    def in_light(values: Reals) -> Floats:
        averaged: Floats = channels.solar_weight @ values
        return averaged

    # Spherical albedo acts on the light that reaches the ground and the sensor: its mean is over that light.
    through = (down["dir"] + down["dif"]) * (up["dir"] + up["dif"])
    reached = in_light(through)
    return {
        "rhoatm": in_light(np.pi * black["path_scattered"] / outside),
        "sphalb": np.where(reached > _NOTHING, in_light(spherical * through) / np.maximum(reached, _NOTHING), 0.0),
        "transm_down_dir": in_light(down["dir"]),
        "transm_down_dif": in_light(down["dif"]),
        "transm_up_dir": mean(up_direct),
        "transm_up_dif": mean(up_diffuse),
        "thermal_upwelling": mean(path * channels.per_nm),
        "thermal_downwelling": mean(sky / np.pi * (up_direct + up_diffuse) * channels.per_nm),
        **{f"{a}-{b}": in_light(down[a] * up[b]) for a, b in product(("dir", "dif"), ("dir", "dif"))},
    }


def _units(name: str) -> str:
    return "uW cm^-2 sr^-1 nm^-1" if name.startswith("thermal") else "1"


def read_channels(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Middles and full widths [nm] of a wavelength file of ISOFIT: columns of a number, wavelength and width, or the
    latter two; um where all wavelengths are below 100.

    Raises
    ------
    InputError
        With file and line of the first that does not fit.
    """
    from skyshine.schemas.csv_table import read_text

    rows: list[Sequence[float]] = []
    for number, line in enumerate(read_text(path).splitlines(), 1):
        cells = line.replace(",", " ").split()
        if not cells or cells[0].startswith("#"):
            continue
        try:
            values = [float(cell) for cell in cells]
        except ValueError:
            values = []
        if len(values) not in (2, 3):
            raise InputError(f"found '{line.strip()}'; allowed: [number] wavelength width", file=path, line=number)
        rows.append(values[-2:])
    if not rows:
        raise InputError("contains no channel; allowed: lines of [number] wavelength width", file=path)
    scale = 1e3 if max(row[0] for row in rows) < 100 else 1.0
    return tuple(scale * row[0] for row in rows), tuple(scale * row[1] for row in rows)
