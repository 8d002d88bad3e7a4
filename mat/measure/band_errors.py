"""The errors of a ``.band`` table: its arrays read between their nodes against direct computation."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.sampling import random_coordinates
from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance
from skyshine.mat.radiometry.equivalent_temperature import SHORTEST
from skyshine.mat.radiometry.lobe import normalisation_to_grazing
from skyshine.mat.radiometry.reflectance import band_emissivity, band_reflectance
from skyshine.mat.tables.stated_error import ErrorMeasure, accuracy_group, measure
from skyshine.materials.records import Material
from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.hdf5 import Group

BLACK_BODIES, EMITTERS = 1000, 50  # random temperatures: of black bodies, and of each material
# Random angles of incidence of each width of a lobe, by the axis of the arrays; each takes 1.4 ms.
ANGLES = {"source_angle": 20, "incidence_angle": 200}
NORMALISATIONS = {
    "source_angle": ("normalisation", "normalisation_by_angle"),
    "incidence_angle": ("normalisation_fine",),
}
COLD_K, HOT_K = 250.0, 350.0  # at both, errors are stated separately
_SMALLEST = float(np.finfo(np.float32).tiny)  # W m^-2 sr^-1, of light that an array of 4-byte floats can represent
_STEP = 1e-4  # relative, of a temperature, over which the slope of radiance is taken

METHOD = (
    "linear interpolation against direct computation, at random temperatures of cells that are as likely as each other"
    " and at random angles of incidence; normalisation, a mean over angles, is read at any of them; kelvin and percent"
    f" are of the light of a black body of that temperature; cold: below {COLD_K:g} K, ambient: to {HOT_K:g} K, hot:"
    " above"
)


def band_accuracy(root: Group, response: SpectralResponse, materials: Sequence[Material], seed: int) -> Group:
    """The group ``/accuracy`` of a band.

    Parameters
    ----------
    root : Group
        The tables of the band.
    materials : (M,) sequence of Material
        Materials in the order of the table.
    seed : int
        Seed of the random points.
    """
    generator = random_stream(seed, Stream.BAND_ERROR)
    errors = [_black_body(root, response, generator)]
    for name, computed in (("reflectance_planck", _reflectance), ("emissivity_planck", band_emissivity)):
        errors.append(_by_temperature(root, name, response, [_of(m, response, computed) for m in materials], generator))
    errors += _lobes(root, materials, generator)
    return accuracy_group(errors, {}, {}, {"seed": seed, "method": METHOD})


Computed = Callable[[Material, SpectralResponse, Floats], "float | Floats"]


def _reflectance(material: Material, response: SpectralResponse, kelvin: Floats) -> float | Floats:
    return band_reflectance(material, response, "planck", temperature=kelvin)


def _of(material: Material, response: SpectralResponse, computed: Computed) -> Callable[[Floats], Floats]:
    return lambda kelvin: np.asarray(computed(material, response, kelvin), float)


def _black_body(root: Group, response: SpectralResponse, generator: np.random.Generator) -> ErrorMeasure:
    nodes = np.asarray(root.axes["temperature"].values, float)
    kelvin = random_coordinates(nodes, BLACK_BODIES, generator)
    error = np.interp(kelvin, nodes, _stored(root, "blackbody_radiance")) - band_radiance(response, kelvin)
    return _measured("blackbody_radiance", error, error, kelvin, response)


def _by_temperature(
    root: Group,
    name: str,
    response: SpectralResponse,
    computed: Sequence[Callable[[Floats], Floats]],
    generator: np.random.Generator,
) -> ErrorMeasure:
    """Errors of an array of materials by temperature, at temperatures of their own for each."""
    nodes, stored = np.asarray(root.axes["planck_temperature"].values, float), _stored(root, name)
    kelvin = np.array([random_coordinates(nodes, EMITTERS, generator) for _ in computed])
    pairs = zip(kelvin, stored, computed, strict=True)
    error = np.array([np.interp(at, nodes, row) - direct(at) for at, row, direct in pairs])
    return _measured(name, error, error * band_radiance(response, kelvin), kelvin, response)


def _measured(
    name: str, error: Floats, radiance_error: Floats, kelvin: Floats, response: SpectralResponse
) -> ErrorMeasure:
    """Errors in their own unit and of radiance, both of the shape of the temperatures of the light; in kelvin from 2.5
    um on.
    """
    light = band_radiance(response, kelvin)
    slope = np.full(kelvin.shape, np.nan)
    if response.upper >= SHORTEST:
        warmer, colder = (band_radiance(response, kelvin * (1 + step)) for step in (_STEP, -_STEP))
        slope = (warmer - colder) / (2 * _STEP * kelvin)
    percent = 100 * radiance_error / np.maximum(light, _SMALLEST)
    return measure(name, error, radiance_error / slope, percent, regions=_regions(kelvin))


def _regions(kelvin: Floats) -> dict[str, Booleans]:
    return {
        "cold": kelvin < COLD_K,
        "ambient": (kelvin >= COLD_K) & (kelvin <= HOT_K),
        "hot": kelvin > HOT_K,
    }


def _lobes(root: Group, materials: Sequence[Material], generator: np.random.Generator) -> list[ErrorMeasure]:
    """Errors of each array of N_s, against (43) at random angles of the array's axis."""
    widths, which = np.unique([material.lobe_fwhm for material in materials], return_inverse=True)
    errors = []
    for axis, count in ANGLES.items():
        names = [name for name in NORMALISATIONS[axis] if name in root.variables]
        if not names:
            continue
        nodes = np.asarray(root.axes[axis].values, float)
        angle = np.sort(random_coordinates(nodes[[0, -1]], count, generator))
        exact = np.array([normalisation_to_grazing(width, angle) for width in widths])[which]
        for name in names:
            stored = _stored(root, name)
            by_angle = stored if stored.ndim > 1 else np.repeat(stored[:, None], nodes.size, axis=1)
            error = np.array([np.interp(angle, nodes, row) for row in by_angle]) - exact
            errors.append(measure(name, error, np.full(error.shape, np.nan)))
    return errors


def _stored(root: Group, name: str) -> Floats:
    """An array as stored in the file."""
    return np.asarray(root.variables[name].data).astype(np.float32).astype(float)
