"""Air, lines of sight and sources on which the kernel is compared with numpy."""

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight, lines_of_sight
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.quantities.joined_paths import JoinedPaths
from skyshine.mat.quantities.line_sources import LineSources

# Spectral points from 5 to 0.83 um, of cross sections from none to one that nothing gets through.
MANY, FEW = 61, 9
ELEVATIONS = -20, -10, -6, -4, -2, 0, 2, 5.5, 12, 23, 38, 57, 90
STATES = {
    "clear": {"aerosol": Aerosol("none")},
    "below the sea": {"aerosol": Aerosol("none"), "surface_altitude": -400.0, "surface_albedo": 0.8},
    "haze": {"aerosol": Aerosol("rural", visibility_km=8.0)},
    "fog": {"aerosol": Aerosol("fog_radiation")},
    "cloud": {"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 8.0)], "surface_albedo": 0.4},
    "opaque cloud": {"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 1e4)]},
    "cirrus": {"clouds": [CloudLayer("ice", 9e3, 10e3, 60.0, 0.5)]},
}
# Altitude m, elevation degree, length m.
LINES = (
    (0.0, 30.0, 1e6),
    (0.0, 90.0, 1e6),
    (0.0, 0.0, 50e3),
    (2.0, 0.3, 1.0),
    (1500.0, 0.0, 3e3),  # level, inside the cloud
    (1600.0, 10.0, 1e6),  # out of the cloud
    (1200.0, -20.0, 1e6),  # out of it, and ended by the ground
    (9e3, -90.0, 1e6),
    (12e3, -3.0, 600e3),  # grazing
    (3e5, 5.0, 1e6),  # sees space alone
    (700e3, -25.0, 5e6),  # through the limb
    (700e3, -60.0, 5e6),  # from space to the ground
    (20.0, -1.0, 1e6),
)
SOURCES = np.radians([-18.0, -10.0, -4.5, -1.0, 0.0, 2.0, 5.6, 30.0, 90.0])
AZIMUTHS = np.radians([20.0, 180.0, 60.0, 0.0, 90.0, 3.0, 120.0, 150.0, 0.0])
OFF_LINE = np.radians([0.0, 0.4, 3.0, 15.0, 39.0])  # azimuths of sources as high as the line: in the aureole


@dataclass
class Lines:
    """Joined lines with sources of their own: what the functions of light take."""

    segments: Segments
    depths: Depths
    to_source: np.ndarray
    deflection: np.ndarray
    paths: list[LineOfSight]

    @property
    def arguments(self):
        return self.segments, self.depths, self.to_source, self.deflection

    @property
    def air(self):
        """Segments (K,) that hold air, not between two lines."""
        return self.segments.lower + self.segments.upper > 0

    def of_depth(self, depth):
        """The same lines, all segments of which have one optical depth."""
        per_segment = np.where(self.air[:, None], depth, np.zeros_like(self.depths.per_segment))
        return replace(self, depths=Depths(per_segment, self.depths.starts))

    def of_source(self, source):
        """Arguments with one of the sources."""
        some = slice(source, source + 1)
        return self.segments, self.depths, self.to_source[:, some], self.deflection[:, some]


def air_of(name, points, synthetic_points):
    """Air of a state at so many spectral points."""
    state = AtmosphericState.from_profile("midlatitude_summer", **{"aerosol": Aerosol("rural"), **STATES[name]})
    sections = np.where(np.arange(points) % 7 == 0, 0.0, np.geomspace(1e-30, 1e-20, points))
    mixed = sections[np.arange(points) * 17 % points]
    edges = np.geomspace(2000.0, 12000.0, points + 1)
    air = SpectralAir.of(state, synthetic_points(edges, {"CO2": mixed}))
    # A field of plane layers under fewer elevations is solved quicker.
    return air if points == MANY else replace(air, spherical=False, elevations=ELEVATIONS)


def lines_through(air, lines=LINES):
    """Lines of sight in air; altitudes below 5 km are above its ground."""
    altitude, elevation, length = np.array(lines).T
    altitude = altitude + np.where(altitude < 5e3, air.state.altitude[0], 0.0)
    elevation = np.radians(elevation)
    paths = list(lines_of_sight(air, length[:, None], altitude, elevation))
    sources = [
        LineSources.at(np.append(SOURCES, np.full(OFF_LINE.size, max(of_line, -0.3))), np.append(AZIMUTHS, OFF_LINE))
        for of_line in elevation
    ]
    joined = JoinedPaths.of(paths)
    to_source, deflection = (
        np.concatenate([angle(of_line, path.ends) for of_line, path in zip(sources, paths, strict=True)])
        for angle in (LineSources.to_source, LineSources.deflection)
    )
    return Lines(joined.segments, joined.depths, to_source, deflection, paths)
