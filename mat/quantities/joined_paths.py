"""Lines of sight computed together: their segments one after the other, as one long ray."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.schemas.arrays import Floats, Integers, Reals

# Lines joined at most, and numbers of lines times sources: their arrays stay within a processor's cache, and numpy's
# calls are few.
_LINES, _LINES_BY_SOURCES = 32, 640


@dataclass(frozen=True, eq=False)
class JoinedPaths:
    """L lines of sight, each ended at R ranges, at P spectral points.

    Attributes
    ----------
    segments : Segments
        Segments of all lines, K in number: a segment without air separates two lines.
    depths : Depths
        Optical depths of the segments.
    """

    paths: Sequence[LineOfSight]
    segments: Segments
    depths: Depths

    @classmethod
    def of(cls, paths: Sequence[LineOfSight]) -> JoinedPaths:
        """Join lines that have as many ranges each."""
        segments, offset = Segments.joined([path.segments for path in paths])
        if len(paths) == 1:
            return cls(paths, segments, paths[0].segment_depths)
        per_segment = [path.segment_depths.per_segment for path in paths]
        gap = np.zeros((1, per_segment[0].shape[1]), per_segment[0].dtype)
        rows = [part for line in per_segment for part in (line, gap)][:-1]
        return cls(paths, segments, Depths(np.concatenate(rows), offset))

    @property
    def node(self) -> Integers:
        """Segment end at each range, (L, R)."""
        return np.stack([path.node for path in self.paths]) + self.depths.starts[:, None]

    @property
    def beyond(self) -> Floats:
        """Part of each range behind the ground, (L, R) [m]."""
        return np.stack([path.beyond for path in self.paths])

    @property
    def depth(self) -> Reals:
        """Optical depth to each range, (L, R, P)."""
        return np.stack([path.depth for path in self.paths])

    @property
    def elevation(self) -> Floats:
        """Elevation of the lines at their observers, (L,) [rad]."""
        return np.array([path.elevation for path in self.paths])


def in_groups(lines: int, sources: int) -> Iterator[slice]:
    """Lines to be joined, of so many with so many sources each."""
    together = max(1, min(_LINES, _LINES_BY_SOURCES // max(sources, 1)))
    for start in range(0, lines, together):
        yield slice(start, min(start + together, lines))
