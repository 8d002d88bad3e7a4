"""Default axes of the atmospheric tables of a job: their ends are what the channels are for."""

from __future__ import annotations

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
# fmt: on
