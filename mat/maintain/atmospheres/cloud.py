"""Derive optical properties of water cloud, ice cloud and rain from Mie theory.

    python -m mat.maintain.atmospheres.cloud FOLDER --out atmospheres/cloud

FOLDER contains H2O__Segelstein.yml (Segelstein 1981: water at 25 C) and H2O__Warren-2008.yml (Warren and Brandt 2008:
ice at -7 C) of the refractiveindex.info database. Droplets and crystals have gamma distributions of effective variance
0.1 (Hansen and Travis 1974), rain that of Marshall and Palmer 1948. Crystals are taken as spheres of their ratio of
volume to area (Grenfell and Warren 1999); below 2.7 um their absorption and asymmetry are those of rough aggregates
(Raisanen et al. 2015).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np
import numpy.typing as npt
import yaml
from scipy.integrate import trapezoid

from skyshine.mat.atmosphere.particles.crystals import JOIN, crystal_asymmetry, crystal_coalbedo
from skyshine.mat.atmosphere.particles.mie import sphere_efficiencies
from skyshine.mat.atmosphere.particles.rain import SLOPE_EXPONENT, SLOPE_PER_CM
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import write_csv

WATER_RADII = (2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 20, 25, 30)  # um, effective
ICE_RADII = (5, 7, 10, 15, 20, 30, 40, 60, 80, 100)
RAIN_RATES = (0.1, 1, 10, 100)  # mm/h
DENSITY = {"water": 997.0, "ice": 918.0}  # kg m^-3 at 25 C and -7 C (CRC Handbook)
VARIANCE = 0.1
# Wavelengths, um: closer together where the refractive indices have their bands.
WAVELENGTHS = np.unique(
    np.concatenate(
        [
            np.geomspace(0.2, 2.5, 36),
            np.arange(2.6, 3.7, 0.1),
            np.geomspace(3.75, 32, 56),
            np.geomspace(36, 1000, 24),
            [0.55],
        ]
    ).round(4)
)
# Radii integrated over, um: enough of them to smooth the ripple of single spheres.
RADII, DROPS = np.geomspace(0.1, 500, 1500), np.geomspace(20, 4500, 300)
# Beyond the fit of rough aggregates: roughened crystals scatter sunlight with an asymmetry near 0.76 (Yang et al. 2013,
# J. Atmos. Sci. 70, 330), spheres with 0.87. The difference lies in light that has passed through the crystal; where
# ice is black, spheres and crystals agree (diffraction).
ROUGHNESS = 0.11


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), required=True, help="Folder to write to.")
def main(folder: Path, out: Path) -> None:
    water, ice = (refractive_index(folder / f"H2O__{name}.yml") for name in ("Segelstein", "Warren-2008"))
    droplets = cloud_table(water, WATER_RADII, DENSITY["water"])
    write_table(
        out / "water.csv",
        "droplets of liquid water by Mie theory",
        "Segelstein 1981 (water)",
        "effective_radius[um]",
        WATER_RADII,
        droplets,
    )
    crystals = crystal_table(ice)
    write_table(
        out / "ice.csv",
        "ice crystals by Mie theory and, below 2.7 um, by Raisanen et al. 2015",
        "Warren and Brandt 2008 (ice)",
        "effective_radius[um]",
        ICE_RADII,
        crystals,
    )
    write_table(
        out / "rain.csv",
        "rain by Mie theory",
        "Segelstein 1981 (water)",
        "rain_rate[mm/h]",
        RAIN_RATES,
        rain_table(water),
    )


def refractive_index(file: Path, wavelengths: Floats = WAVELENGTHS) -> npt.NDArray[np.complex128]:
    """Refractive index (W,) at wavelengths [um] from a file of refractiveindex.info; the logarithm of its imaginary
    part is interpolated.
    """
    rows = yaml.safe_load(file.read_text(encoding="utf-8"))["DATA"][0]["data"]
    wavelength, real, imaginary = np.array([line.split() for line in rows.splitlines() if line.strip()], float).T
    log = np.log(wavelengths)
    absorbed = np.exp(np.interp(log, np.log(wavelength), np.log(imaginary)))
    return np.asarray(np.interp(log, np.log(wavelength), real) + 1j * absorbed)


def sphere_table(index: npt.NDArray[np.complex128], radii: Floats) -> Floats:
    """Extinction and absorption cross section [um^2] and asymmetry times scattering cross section, (3, W, R)."""
    size = 2 * np.pi * radii / WAVELENGTHS[:, None]
    extinction, scattering, asymmetry = sphere_efficiencies(size, index[:, None])
    efficiencies = np.array([extinction, np.maximum(extinction - scattering, 0.0), asymmetry * scattering])
    return np.asarray(efficiencies * np.pi * radii**2)


def bulk(sphere: Floats, number: Floats, radii: Floats) -> Floats:
    """Extinction, absorption [um^2] and asymmetry (3, W) of a distribution `number` (R,) per radius."""
    extinction, absorption, forward = np.asarray(trapezoid(sphere * number, radii, axis=-1))
    return np.array([extinction, absorption, forward / (extinction - absorption)])


def cloud_table(index: npt.NDArray[np.complex128], effective_radii: Sequence[float], density: float) -> Floats:
    """Extinction and absorption [m^2 kg^-1] and asymmetry, (3, E, W)."""
    sphere = sphere_table(index, RADII)
    result = []
    for effective in effective_radii:
        number = RADII ** ((1 - 3 * VARIANCE) / VARIANCE) * np.exp(-RADII / (effective * VARIANCE))
        extinction, absorption, asymmetry = bulk(sphere, number, RADII)
        mass = density * trapezoid(4 / 3 * np.pi * RADII**3 * number, RADII) * 1e-6  # um^3 to um^2 m
        result.append((extinction / mass, absorption / mass, asymmetry))
    return np.array(result).transpose(1, 0, 2)


def crystal_table(index: npt.NDArray[np.complex128]) -> Floats:
    """As `cloud_table`, of rough aggregates of ice."""
    extinction, absorption, asymmetry = cloud_table(index, ICE_RADII, DENSITY["ice"])
    asymmetry = rough(extinction, absorption, asymmetry)
    # Beyond the fit ice refracts less than air in places, where the fit has no meaning.
    fitted = JOIN[1] > WAVELENGTHS
    size = 2 * np.pi * np.array(ICE_RADII, float)[:, None] / WAVELENGTHS[fitted]
    low, high = np.log(JOIN)
    share = np.clip((high - np.log(WAVELENGTHS[fitted])) / (high - low), 0.0, 1.0)
    coalbedo, cosine = crystal_coalbedo(size, index[fitted]), crystal_asymmetry(size, index[fitted])
    absorption[:, fitted] += share * (extinction[:, fitted] * coalbedo - absorption[:, fitted])
    asymmetry[:, fitted] += share * (cosine - asymmetry[:, fitted])
    return np.array([extinction, absorption, asymmetry])


def rough(extinction: Floats, absorption: Floats, asymmetry: Floats) -> Floats:
    """Asymmetry of roughened crystals from that of spheres."""
    albedo = 1 - absorption / extinction
    return np.asarray(asymmetry - ROUGHNESS * np.maximum(2 * albedo - 1, 0.0) / albedo)


def rain_table(index: npt.NDArray[np.complex128]) -> Floats:
    """Extinction and absorption over twice the cross section of the drops, and asymmetry, (3, rates, W)."""
    sphere = sphere_table(index, DROPS)
    result = []
    for rate in RAIN_RATES:
        number = np.exp(-SLOPE_PER_CM * rate**SLOPE_EXPONENT * 2 * DROPS * 1e-4)
        extinction, absorption, asymmetry = bulk(sphere, number, DROPS)
        twice = 2 * trapezoid(np.pi * DROPS**2 * number, DROPS)
        result.append((extinction / twice, absorption / twice, asymmetry))
    return np.array(result).transpose(1, 0, 2)


def write_table(path: Path, particles: str, source: str, axis: str, nodes: Sequence[float], table: Floats) -> None:
    """Write one CSV: extinction, absorption and asymmetry against the axis and wavelength."""
    header = (
        f"Optical properties of {particles}; refractive index of {source}, from the"
        " refractiveindex.info database (CC0).",
        "Derived by mat.maintain.atmospheres.cloud.",
    )
    unit = "" if axis.startswith("rain") else "[m2/kg]"
    columns = (axis, "wavelength[um]", f"extinction{unit}", f"absorption{unit}", "asymmetry")
    rows = [
        (node, wavelength, *(f"{x:.6g}" for x in table[:, i, j]))
        for i, node in enumerate(nodes)
        for j, wavelength in enumerate(WAVELENGTHS)
    ]
    write_csv(path, header, columns, rows)


if __name__ == "__main__":
    main()
