"""Response to shade of leaves and the soil in their gaps, as readers have it: of one temperature to one heat."""

from __future__ import annotations

import numpy as np

from skyshine.mat.surface.canopy import CanopyBalance, gap_to_sky, gap_towards, light_shares, seen_temperature
from skyshine.mat.surface.canopy_conduction import CanopyConduction
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import DAY
from skyshine.schemas.arrays import Floats, Integers, Reals

_LEAST_SLOPE = 1e-3  # W m^-2 K^-1, as in Newton's matrix
_SHADOW = 3.0  # h: chosen, of shadows by which the parts of leaves and soil are weighed
_DARK = 1.0  # W m^-2 of sunlight, chosen, below which longwave alone changes
_COLDEST = 20.0  # K: as of the table of losses


class CanopyResponse:
    """Response of some columns about a solution in N steps of a day, at H of them.

    Parameters
    ----------
    material : SurfaceMaterial
        Material with a canopy.
    forcing : Forcing
        Forcing at N steps.
    sources : (columns, 2 N) ndarray
        Temperatures of leaves and soil [K].
    scheme : str
        Scheme, as in `conduction.Conduction`.
    at : (H,) ndarray
        Numbers of the steps.

    Attributes
    ----------
    kernel : (columns, H, N) ndarray
        Kelvin of the temperature seen per heat absorbed at each step [K m^2 W^-1].
    slope : (columns, H) ndarray
        Slope of the heat loss with which the kernel was made, by the apparent temperature [W m^-2 K^-1].

    Notes
    -----
    Readers give a change of absorbed heat q: the material's absorptance times the change of sunlight and its emissivity
    times that of longwave. Leaves and soil have of it what they absorb of direct light at the time, of even light where
    the Sun does not shine on the plane, and of longwave at night.
    The temperature seen changes by the weights of their radiances. What their heat losses exceed the linear ones by is
    made one heat by what either does to the temperature seen, and both temperatures move with that as they do under a
    shadow of `_SHADOW`, with slopes midway between the day's mean, by which leaves and soil differ too little at night,
    and those of the time, by which they differ too much by day. With the day's mean, midway and with those of the time
    shade errs on level grass by 0.26, 0.19 and 0.15 K rms, on random planes, read between the stored, by 0.21, 0.18 and
    0.19 K.
    """

    def __init__(self, material: SurfaceMaterial, forcing: Forcing, sources: Floats, scheme: str, at: Integers) -> None:
        assert material.canopy is not None
        canopy, steps = material.canopy, forcing.shape[1]
        balance = CanopyBalance(forcing, material)
        self._balance = CanopyBalance(forcing.times(at), material)
        _, slope = balance.loss_and_slope(sources)
        # Day's means (columns, 2) of leaves and soil, by the units of their rows.
        mean = np.maximum(slope.reshape(-1, 2, steps).mean(axis=2), _LEAST_SLOPE)
        received = _received(material, forcing, balance.cover)
        conduction = CanopyConduction(canopy, steps, DAY, scheme)
        gap = float(gap_towards(canopy.leaf_area, 1.0))
        both = sources.reshape(-1, 2, steps)[:, :, at]
        self._both, self._seen = both, seen_temperature(canopy, both.reshape(len(both), -1))
        weight = np.array([1 - gap, gap])[:, None] * (both / self._seen[:, None]) ** 3
        recent = (at[:, None] - np.arange(steps)) % steps < round(_SHADOW / 24.0 * steps)
        unit = np.eye(2 * steps)[:, np.concatenate([at, steps + at])]

        def moved(its_slope: Floats) -> Floats:
            """Rows of J^-1: of leaves and soil, at H steps, by heat to either, then."""
            inverse = np.linalg.solve((conduction.matrix + np.diag(its_slope)).T, unit).T
            return inverse.reshape(2, at.size, 2, steps).astype(float, copy=False)

        kernels, follows, counts = [], [], []
        for column, its_mean in enumerate(mean):
            heat, its_weight = received[column].reshape(2, steps), weight[column][..., None]
            rows = moved(np.repeat(its_mean, steps))
            kernel = (its_weight * (rows * heat).sum(axis=2)).sum(axis=0)
            counts.append(((its_weight[..., None] * rows).sum(axis=0) * recent[:, None]).sum(axis=2).T)
            counts[-1] /= (kernel * recent).sum(axis=1)
            kernels.append(kernel)
            between = (np.repeat(its_mean, steps) + np.maximum(slope[column], _LEAST_SLOPE)) / 2
            both = ((moved(between) * heat).sum(axis=2) * recent).sum(axis=2)
            follows.append(both / (weight[column] * both).sum(axis=0))
        self.kernel, self._follows, self._counts = np.stack(kernels), np.stack(follows), np.stack(counts)
        self.slope = (self._counts * self._follows * mean[..., None]).sum(axis=1)

    def loss(self, temperature: Reals) -> Floats:
        """Net outward flux (columns, H) [W m^-2] of leaves and soil by the temperature seen [K], as one heat."""
        moved = self._both + self._follows * (np.asarray(temperature, float) - self._seen)[:, None]
        columns, _, hours = moved.shape
        lost = self._balance.loss(np.maximum(moved, _COLDEST).reshape(columns, 2 * hours))
        total: Floats = (self._counts * lost.reshape(moved.shape)).sum(axis=1)
        return total


def _received(material: SurfaceMaterial, forcing: Forcing, cover: float) -> Floats:
    """Of a unit of absorbed heat, what leaves, by the area that they cover, and soil have (columns, 2 N)."""
    canopy = material.canopy
    assert canopy is not None
    beam, spread = light_shares(canopy, forcing)
    through = np.where(forcing.shortwave_direct > 0, beam, spread) + np.zeros(forcing.shape)
    absorptance = [part.solar_absorptance for part in (canopy.leaves, canopy.soil, material)]
    emissivity = [part.thermal_emissivity for part in (canopy.leaves, canopy.soil, material)]
    dark = (forcing.shortwave_direct + forcing.shortwave_diffuse < _DARK) & np.ones(forcing.shape, bool)
    through = np.where(dark, gap_to_sky(canopy.leaf_area), through)
    leaves, soil, both = (np.where(dark, *pair) for pair in zip(emissivity, absorptance, strict=True))
    shares: Floats = np.concatenate([(1 - through) / cover * leaves, through * soil], axis=1)
    received: Floats = shares / np.tile(np.maximum(both, 1e-9), 2)
    return received
