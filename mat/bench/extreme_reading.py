"""Random extreme bands, lobes and tables: very narrow filters, mirrors and diffusers, cells of any size."""

from __future__ import annotations

import numpy as np

from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance, brightness_temperature
from skyshine.mat.radiometry.lobe import FWHM_LIMITS, lobe_integral, normalisation, shininess, specular_lobe
from skyshine.mat.tables.axes import FOLDED, LINEAR, PERIODIC, AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

_ANGLES = (0.0, 45.0, 75.0, 89.0, 89.99)  # degree, of the source


def band_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """A band between 0.3 and 1000 um, of any width and shape, seen at 1 K to 10,000 K."""
    low = float(np.exp(generator.uniform(np.log(0.3), np.log(900.0))))
    width = float(np.exp(generator.uniform(np.log(1e-6), np.log(3.0))))
    count = int(generator.choice([2, 3, 50]))
    response = SpectralResponse(
        low * np.linspace(1, 1 + width, count), np.append(generator.uniform(0, 1, count - 1), 1.0)
    )
    kelvin = np.sort(np.exp(generator.uniform(0.0, np.log(1e4), 12)))
    radiance = band_radiance(response, kelvin)
    positive = radiance > 1e-290  # below, radiance has fewer digits than double precision
    back = brightness_temperature(response, radiance[positive])
    cold = radiance[:-1] - radiance[1:]
    return {
        "not finite": (float(np.count_nonzero(~np.isfinite(radiance)) + np.count_nonzero(~np.isfinite(back))), 0.0),
        "radiance below 0": (max(0.0, -float(radiance.min())), 0.0),
        "radiance that falls with temperature": (max(0.0, float(np.max(cold))), 0.0),
        "temperature of the radiance, relative": (
            float(np.max(np.abs(back / kelvin[positive] - 1), initial=0.0)),
            1e-9,
        ),
    }


def lobe_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Lobes from the width of the Sun's disc to the hemisphere, at any incidence up to grazing."""
    fwhm = float(np.exp(generator.uniform(*np.log(FWHM_LIMITS))))
    fwhm = float(generator.choice([fwhm, *FWHM_LIMITS]))
    power = shininess(fwhm)
    angles = np.append(_ANGLES, generator.uniform(0, 89.99))
    area, scale = lobe_integral(power, angles), normalisation(fwhm, angles)
    directions = generator.normal(size=(3, 200, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    source, observer, normal = directions
    lobe = specular_lobe(power, source, observer, normal)
    other_way = specular_lobe(power, observer, source, normal)
    against = specular_lobe(power, source, -source, normal)
    return {
        "not finite": (float(sum(np.count_nonzero(~np.isfinite(a)) for a in (area, scale, lobe, against))), 0.0),
        "integral over the hemisphere, over 2 pi": (float(np.max(area)) / (2 * np.pi), 1.0),
        "integral or scale not above 0": (
            max(0.0, -float(min(area.min(), scale.min()))) + float(np.any(area == 0) or np.any(scale == 0)),
            0.0,
        ),
        "lobe above 1": (max(0.0, float(lobe.max()) - 1), 0.0),
        "lobe the other way round": (float(np.max(np.abs(lobe - other_way))), 1e-12),
    }


def table_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Tables of up to five axes, nodes 1e-6 to 1e6 apart, values of any size; read inside, on and beyond the nodes."""
    rules = [_random_axis(generator, number) for number in range(int(generator.integers(1, 6)))]
    values = 10.0 ** generator.uniform(-300, 300, [rule.nodes.size for rule in rules]) * generator.choice([-1.0, 1.0])
    where = {}
    for rule in rules:
        low, high = rule.nodes[[0, -1]]
        inside = low + (high - low) * generator.random(60)
        where[rule.name] = np.clip(_some_of(generator, inside, rule.nodes), low, high)
    read = interpolate(values, rules, where)
    axis_rule = rules[0]
    scale = np.abs(values).max()
    corner = interpolate(values, rules, {rule.name: rule.nodes[-1:] for rule in rules})
    refused = axis_rule.interpolation != LINEAR
    if not refused:
        try:
            interpolate(values, rules, {**where, axis_rule.name: np.array([np.nextafter(axis_rule.nodes[-1], np.inf)])})
        except InputError:
            refused = True
    return {
        "not finite": (float(np.count_nonzero(~np.isfinite(read))), 0.0),
        "outside the nodes' values, relative": (
            float(max(read.max() - values.max(), values.min() - read.min(), 0.0)) / scale,
            1e-12,
        ),
        # An axis that repeats rounds to its length.
        "a node read back, relative": (float(abs(corner.item() - values[(-1,) * values.ndim])) / scale, 1e-6),
        "values beyond the axis that were read": (float(not refused), 0.0),
    }


def _random_axis(generator: np.random.Generator, number: int) -> AxisRule:
    count = int(generator.choice([1, 2, 3, 7]))
    steps = 10.0 ** generator.uniform(-6, 6, count)
    nodes = float(generator.choice([0.0, -1e3, 1e3])) + np.cumsum(steps)
    kind = str(generator.choice([LINEAR, LINEAR, PERIODIC, FOLDED]))
    if kind == PERIODIC:
        return AxisRule(f"a{number}", nodes, kind, float(np.ptp(nodes) * 1.5 + 1.0))
    if kind == FOLDED:
        half = np.cumsum(steps) - steps[0]
        return AxisRule(f"a{number}", half, kind, 2 * float(half[-1]) if count > 1 else 360.0)
    return AxisRule(f"a{number}", nodes)


def _some_of(generator: np.random.Generator, values: Floats, ends: Floats) -> Floats:
    return np.where(generator.random(values.size) < 0.3, generator.choice(ends, values.size), values)
