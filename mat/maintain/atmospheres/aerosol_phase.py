"""Derive scattering by aerosols of known components from Mie theory, by humidity.

    python -m mat.maintain.atmospheres.aerosol_phase INDICES WATER --out atmospheres/aerosol/phase.h5

INDICES is pymopsmap/data/opac/kappa.nc of the wheel `pymopsmap` 0.5.1 on PyPI (Apache 2.0), which has the refractive
indices of the dry components of OPAC; WATER is H2O__Hale.yml (Hale and Querry 1973) of the refractiveindex.info
database. The file contains the components of OPAC, of one particle per cm^3 each, and the models of Shettle and Fenn,
whose components have the same indices. Particles are spheres; a humid one has the index of its dry material and of
water by volume.

References
----------
Hess et al. 1998, Bull. Am. Meteorol. Soc. 79, 831, Table 1c (sizes of OPAC). Shettle and Fenn 1979, AFGL-TR-79-0214,
Tables 1 and 2. d'Almeida et al. 1991, Atmospheric Aerosols (origin of the indices).
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click
import h5py
import numpy as np

from mat.maintain.atmospheres.cloud import refractive_index
from mat.maintain.atmospheres.phase import MOMENT_BITS, PHASE_BITS, shortened
from skyshine.mat.atmosphere.particles.moments import MOMENTS
from skyshine.mat.atmosphere.particles.size_distribution import (
    RADII,
    LogNormalMode,
    ModeScattering,
    RefractiveIndex,
    scattering_of_modes,
)
from skyshine.mat.atmosphere.particles.tables import PHASE_FILETYPE
from skyshine.schemas.arrays import Floats
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file

# um: all of the indices, which have one of them, 2.7, between 2.5 and 3 um in their source only.
WAVELENGTHS = np.concatenate(
    [
        np.arange(0.25, 0.81, 0.05),
        [0.9, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.2, 3.39, 3.5, 3.75, 4.0, 4.5, 5.0, 5.5, 6.0, 6.2, 6.5, 7.2, 7.9],
        [8.2, 8.5, 8.7, 9.0, 9.2, 9.5, 9.8, 10.0, 10.6, 11.0, 11.5, 12.5, 13.0, 14.0, 14.8, 15.0, 16.4, 17.2, 18.0],
        [18.5, 20.0, 21.3, 22.5, 25.0, 27.9, 30.0, 35.0, 40.0],
    ]
).round(2)
# Degree.
ANGLES = np.concatenate(
    [
        np.arange(0, 0.3, 0.05),
        np.arange(0.3, 1, 0.1),
        np.arange(1, 2, 0.2),
        np.arange(2, 6, 0.5),
        np.arange(6, 15, 1),
        np.arange(15, 120, 3),
        np.arange(120, 176, 2),
        np.arange(176, 180.1, 1),
    ]
).round(2)
# Percent.
HUMIDITY = (0.0, 50.0, 70.0, 80.0, 90.0, 95.0, 98.0, 99.0)
DRY = (0.0,)  # percent
LOWTRAN_HUMIDITY = (0.0, 70.0, 80.0, 99.0)  # percent


@dataclass(frozen=True)
class Material:
    """What spheres are of: dry components by volume, and the mode radii [um] at the humidities."""

    parts: tuple[tuple[str, float], ...]
    radii: tuple[float, ...]
    geometric_sd: float
    number: float = 1.0
    largest_dry: float = RADII[1]


# Components of OPAC (Hess et al. 1998): mode radii by humidity, geometric standard deviation, largest dry radius.
OPAC = {
    "inso": Material((("inso", 1.0),), (0.471,), 2.51, largest_dry=20.0),
    "waso": Material(
        (("waso", 1.0),), (0.0212, 0.0262, 0.0285, 0.0306, 0.0348, 0.0399, 0.0476, 0.0534), 2.24, largest_dry=20.0
    ),
    "soot": Material((("soot", 1.0),), (0.0118,), 2.0, largest_dry=20.0),
    "ssam": Material(
        (("ssam", 1.0),), (0.209, 0.336, 0.378, 0.416, 0.497, 0.605, 0.801, 0.995), 2.03, largest_dry=20.0
    ),
    "sscm": Material((("sscm", 1.0),), (1.75, 2.82, 3.17, 3.49, 4.18, 5.11, 6.84, 8.59), 2.03, largest_dry=60.0),
    "minm": Material((("minm", 1.0),), (0.07,), 1.95, largest_dry=20.0),
    "miam": Material((("miam", 1.0),), (0.39,), 2.0, largest_dry=20.0),
    "micm": Material((("micm", 1.0),), (1.9,), 2.15, largest_dry=60.0),
    "mitr": Material((("mitr", 1.0),), (0.5,), 2.2, largest_dry=5.0),
    "suso": Material(
        (("suso", 1.0),), (0.0695, 0.0983, 0.109, 0.118, 0.135, 0.158, 0.195, 0.231), 2.03, largest_dry=20.0
    ),
}
# Shettle and Fenn 1979: modes of the rural and urban aerosols and of the sea; 0.35 and 0.4 are standard deviations of
# the logarithm to base 10. The urban aerosol is rural with a fifth of soot by volume.
_RURAL = (("waso", 0.7), ("inso", 0.3))
_URBAN = (("waso", 0.56), ("inso", 0.24), ("soot", 0.2))
_SMALL, _LARGE = 10**0.35, 10**0.4
_SMALL_RURAL = (0.027, 0.02846, 0.03274, 0.05215)
MODELS = {
    "rural": (
        Material(_RURAL, _SMALL_RURAL, _SMALL, 0.999875),
        Material(_RURAL, (0.43, 0.4571, 0.5477, 1.1755), _LARGE, 0.000125),
    ),
    "urban": (
        Material(_URBAN, (0.025, 0.02911, 0.03514, 0.06847), _SMALL, 0.999875),
        Material(_URBAN, (0.4, 0.4777, 0.5805, 1.4858), _LARGE, 0.000125),
    ),
    "maritime": (
        Material(_RURAL, _SMALL_RURAL, _SMALL, 0.99),
        Material((("ssam", 1.0),), (0.16, 0.2041, 0.318, 0.7505), _LARGE, 0.01),
    ),
    "tropospheric": (Material(_RURAL, _SMALL_RURAL, _SMALL),),
}


@click.command(help=__doc__)
@click.argument("indices", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("water", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), required=True, help="File to write.")
@click.option("--processes", type=click.IntRange(1), default=1, help="Humidities computed at a time.")
def main(indices: Path, water: Path, out: Path, processes: int) -> None:
    index = component_indices(indices)
    index["water"] = np.asarray(refractive_index(water, WAVELENGTHS))
    mixtures: dict[str, tuple[tuple[float, ...], tuple[Material, ...]]] = {
        f"opac_{name}": (HUMIDITY if len(material.radii) > 1 else DRY, (material,)) for name, material in OPAC.items()
    }
    mixtures |= {name: (LOWTRAN_HUMIDITY, materials) for name, materials in MODELS.items()}
    groups = {}
    with ProcessPoolExecutor(processes) as pool:
        for name, (humidity, materials) in mixtures.items():
            modes = [humid_modes(materials, step, index) for step in range(len(humidity))]
            light = list(pool.map(partial(scattering_of_modes, wavelength=WAVELENGTHS, angle=ANGLES), modes))
            groups[name] = tabulated(np.array(humidity), light)
            click.echo(name)
    about = {
        "source": "Mie theory; sizes by Hess et al. 1998 and Shettle and Fenn 1979, refractive indices of OPAC as in"
        " pymopsmap (Apache 2.0), of water by Hale and Querry 1973 (refractiveindex.info, CC0)",
        "program": "mat.maintain.atmospheres.aerosol_phase",
    }
    header = Header(PHASE_FILETYPE, "1", "", "Scattering by aerosols of known components")
    write_file(out, Group(groups=groups, attributes=about), header)


def component_indices(path: Path) -> dict[str, np.ndarray]:
    """Refractive indices n + ik (W,) of the dry components at `WAVELENGTHS`."""
    result = {}
    with h5py.File(path) as file:
        for name in OPAC:
            group = file[f"{name}/only"]
            wavelength, real, imaginary = (np.asarray(group[key][:], float) for key in ("wl", "n_real", "n_imag"))
            if not np.allclose(wavelength, WAVELENGTHS):
                raise click.ClickException(f"{path}: '{name}' has other wavelengths than this program expects")
            result[name] = real + 1j * imaginary
    return result


def humid_modes(materials: tuple[Material, ...], step: int, index: dict[str, np.ndarray]) -> tuple[LogNormalMode, ...]:
    """Modes at one of the humidities: dry material and water mix by volume (Hess et al. 1998, section 3c)."""
    modes = []
    for material in materials:
        dry = np.sum([share * index[name] for name, share in material.parts], axis=0)
        radius = material.radii[step]
        growth = radius / material.radii[0]
        humid = index["water"] + (dry - index["water"]) / growth**3
        modes.append(
            LogNormalMode(
                radius,
                material.geometric_sd,
                material.number,
                RefractiveIndex(tuple(WAVELENGTHS), tuple(humid.real), tuple(humid.imag)),
                min(material.largest_dry * growth, RADII[1]),
            )
        )
    return tuple(modes)


def tabulated(humidity: Floats, light: list[ModeScattering]) -> Group:
    """The group of one component or model at humidities (H,) [percent]."""
    axes = {
        "node": Axis(humidity, "percent", "relative humidity"),
        "wavelength": Axis(WAVELENGTHS, "um", "wavelength"),
        "angle": Axis(ANGLES, "degree", "scattering angle"),
        "order": Axis(np.arange(MOMENTS), "1", "order of the Legendre polynomial"),
    }

    def variable(name: str, third: str, bits: int, unit: str, words: str) -> Variable:
        values = np.array([getattr(part, name).T for part in light])
        names = ("node", "wavelength", third) if third else ("node", "wavelength")
        return Variable(names, shortened(values, bits), unit, words)

    variables = {
        "extinction": variable("extinction", "", MOMENT_BITS, "um^2", "extinction cross section of a particle"),
        "absorption": variable("absorption", "", MOMENT_BITS, "um^2", "absorption cross section of a particle"),
        "phase": variable("phase", "angle", PHASE_BITS, "1", "phase function, mean 1"),
        "moments": variable("moments", "order", MOMENT_BITS, "1", "Legendre moments, the first 1"),
    }
    return Group(axes, variables)


if __name__ == "__main__":
    main()
