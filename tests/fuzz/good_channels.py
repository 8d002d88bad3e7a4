"""A small good atmospheric database in channels, of smooth functions of its axes, so that no build is needed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skyshine.mat.quantities.channels.coordinates import RayCoordinates
from skyshine.mat.quantities.channels.nodes import ChannelNodes, NodeCounts
from skyshine.mat.quantities.channels.parts import Parts
from skyshine.mat.quantities.channels.path_fields import BandLight, PathFields
from skyshine.mat.quantities.channels.source_parts import SourceParts
from skyshine.mat.quantities.channels.surface_light import LightParts, SurfaceLight
from skyshine.mat.quantities.channels.wavelength_shares import WavelengthShares
from skyshine.mat.quantities.scattering_points import ScatteringPoints
from skyshine.mat.radiometry.band_wavelengths import band_wavelengths
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.tables.channels import ChannelContent, channel_group
from skyshine.schemas.hdf5 import Group

POINTS, ABSORBERS, DIRECTIONS = 5, 2, 2
DARK_BELOW = -26.0
WAVELENGTH = band_wavelengths(SpectralResponse.rectangular(8.0, 12.0))


def waves(shape: Sequence[int], offset: float, height: float) -> np.ndarray:
    """A smooth function on a grid, unlike at any two nodes, in offset - height to offset + height."""
    phases = np.meshgrid(*(np.linspace(0.3, 1.1 + 0.2 * k, size) for k, size in enumerate(shape)), indexing="ij")
    return offset + height * sum(np.sin(phase) for phase in phases) / len(shape)


def channels(accuracy: Group, attributes: dict) -> Group:
    """The layout of a file for ranges to 20 km, observers to 1 km and a source of -20 to 60 degree."""
    nodes = ChannelNodes.of(NodeCounts(4, 3, 3, 3, 3), (0.01, 1.0))
    rays = RayCoordinates(0.0, nodes.height_root, waves([3], 7000.0, 300.0))
    weight = waves([POINTS], 1.0, 0.5)
    content = ChannelContent(
        rays,
        nodes,
        np.linspace(900.0, 1000.0, POINTS),
        weight,
        Parts(np.arange(ABSORBERS), waves([POINTS, ABSORBERS], 0.6, 0.5)),
        BandLight(waves([POINTS], 3.0, 0.5), weight / weight.sum(), ScatteringPoints(None, np.arange(POINTS), weight)),
        PathFields(
            np.exp(waves([ABSORBERS, *nodes.shape], -2.5, 0.7)),
            waves(nodes.shape, 0.9, 0.2),
            waves([DIRECTIONS, *nodes.shape], 0.4, 0.2),
            waves(nodes.shape, -5e-3, 4e-3),
        ),
        SourceParts(
            np.array([-20.0, 20.0, 60.0]),
            np.array([0.0, 90.0, 180.0]),
            np.array([20.0, 60.0]),
            np.array([30.0, 150.0]),
            waves([DIRECTIONS, 3, 3], 0.3, 0.6),
        ),
        _surface(),
        WavelengthShares(WAVELENGTH, _rows(0.5), _rows(1.5)),
        True,
        (0.001, 20.0),
        (0.01, 1.0),
        DARK_BELOW,
        *(1e-5, 1e-5),
    )
    return channel_group(content, accuracy, attributes)


def _rows(offset: float) -> np.ndarray:
    """Shares of the wavelengths in each channel."""
    shares = waves([POINTS, WAVELENGTH.size], offset, 0.5)
    return shares / shares.sum(axis=1, keepdims=True)


def _surface() -> SurfaceLight:
    def light(*shape: int) -> LightParts:
        return LightParts(waves([2, *shape], 2.0, 0.4), waves([POINTS, 2], 0.5, 0.3))

    return SurfaceLight(
        np.array([0.0, 0.5, 2.0]),
        np.array([-20.0, 10.0, 60.0]),
        np.array([0.0, 1.0, 30.0]),
        np.array([-0.6, -1.2, -6.0]),
        np.array([0.0, 5.0, 70.0]),
        light(3, 3),
        light(3),
        light(3, 3),
        light(3, 6),
        light(3, 3, 6),
        light(3, 3),
        waves([4, POINTS], 0.2, 0.1),
    )
