"""Default nodes of the atmospheric tables: of the axes of a job, and of single quantities on them.

The quantities bend at different places. beta* is steep in range near the observer, and in altitude where water vapour
or air thins out. Direct light begins where the source rises over the horizon of the surface, 10 degree lower 100 km up
than at the ground. Path and ambient radiance hardly depend on the range; path radiance around the source follows the
scattering angle, which replaces the azimuth on its axis. So each quantity has nodes of its own on the axes that a job
does not write; those that it writes serve all quantities.
"""

from __future__ import annotations

from collections.abc import Sequence

# fmt: off
RANGES_KM = (
    0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 7, 10, 14, 20, 28, 40, 60, 90,
    130, 200, 300, 1000,
)
OBSERVER_HEIGHTS_KM = (0.002, 0.05, 0.2, 0.5, 1, 2, 3, 5, 8, 12, 20, 40)  # above the site's ground
ELEVATIONS_DEG = (
    -90, -60, -40, -30, -20, -15, -10, -7, -5, -3, -2, -1, 0, 1, 2, 3, 5, 7, 10, 15, 20, 30, 40, 60, 90,
)
SOURCE_ELEVATIONS_DEG = (-10, -5, -2, 0, 2, 5, 10, 20, 30, 45, 60, 75, 90)
SOURCE_AZIMUTHS_DEG = (0, 5, 10, 20, 30, 45, 60, 75, 90, 110, 130, 155, 180)

_FAR_RANGES = (0.2, 1, 2, 4, 7, 10, 14, 28, 40, 90, 130, 300)
_OWN: dict[str, dict[str, tuple[float, ...]]] = {
    "beta_star": {
        "altitude_km": (0.05, 0.2, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 5, 6, 7, 8, 10, 12, 14, 17, 20, 25, 30, 35),
        "elevation_deg": (
            -60, -40, -30, -25, -20, -15, -12.5, -10, -8.5, -7, -6, -5, -4, -3, -2, -1, 0, 1, 2, 3, 5, 7, 10, 15, 20,
            30, 40, 60,
        ),
    },
    "beta_star_thermal": {"altitude_km": (0.05, 0.2, 0.5, 1, 2, 3, 5, 8, 12, 20, 30)},
    "direct_radiance": {
        "altitude_km": (0.05, 0.2, 0.5, 1, 2, 3, 5, 8, 10, 12, 14, 17, 20, 25, 30, 35),
        "source_elevation_deg": (
            -9, -8, -7, -6.5, -6, -5.5, -5, -4.5, -4, -3.5, -3, -2.5, -2, -1.5, -1, -0.5, 0, 0.5, 1, 1.5, 2, 5, 10, 20,
            30, 45, 60, 75,
        ),
    },
    "ambient_radiance": {"range_km": _FAR_RANGES},
    "path_radiance_ratio": {
        "range_km": _FAR_RANGES,
        "altitude_km": (0.1, 0.2, 0.5, 1, 1.5, 2, 3, 4, 5, 8, 12, 20),
        "elevation_deg": (-40, -20, -10, -7, -5, -3, -2, -1, -0.5, 0, 0.5, 1, 2, 4, 7, 11, 18, 30, 50),
        "source_elevation_deg": (-7, -3.5, -1.5, 0, 1.5, 3.5, 5, 7.5, 10, 15, 20, 30, 40, 55, 72),
        "source_azimuth_deg": (1, 2, 3.5, 5, 7.5, 11, 16, 22, 30, 45, 65, 95, 135),  # scattering angles
    },
}
# fmt: on


def own_nodes(
    quantity: str, axis: str, nodes: Sequence[float], default: Sequence[float], lift: float = 0.0
) -> list[float]:
    """Nodes of a quantity on an axis that a job does not write.

    Parameters
    ----------
    quantity, axis : str
        Names as in the files, and as the job has them.
    nodes, default : sequences of float
        The axis of the job, and before anything is trimmed.
    lift : float
        Added to the heights of the default nodes, km: the altitude of the ground.

    Returns
    -------
    list of float
        Those of the quantity between the ends of the job's axis, and these, so that all quantities have the same ends.
    """
    own, low, high = _OWN.get(quantity, {}).get(axis), nodes[0], nodes[-1]
    if own is None:
        return list(nodes)
    plain = {round(lift + height, 9) for height in OBSERVER_HEIGHTS_KM} if axis == "altitude_km" else set(default)
    inside = [node for node in default if node not in plain] + [round(lift + node, 9) for node in own]
    return sorted({low, high, *(node for node in inside if low < node < high)})
