"""The boxes that contain seeds, from which the typicality of a place is estimated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from skyshine.tmm.classify.typicality import Boxes, Typicality, fit_boxes
from skyshine.tmm.inputs.seeds import SeedTexels

# Share of the places of what is known, that may be taken for unknown: a twentieth, as tests of significance have it.
# With six clicks a material on twelve aerial sheets 0.7 % of the texels are, where nothing unknown is there; a
# threshold of 0.11 with three places a material loses 4.5 %, for a sheet may contain kinds of a material that no click
# met.
ONE_IN = 20
MOST_PLACES = 12  # largest number of places of a material that are compared with the others: each costs a fit
GROUP_CELLS = 64  # rows and columns of cells whose boxes are computed at a time


@dataclass(frozen=True)
class SeedBoxes:
    """The boxes that contain seeds.

    boxes : Boxes
    features : (M, F) float64
    seed : (M,) int; a seed texel of each; the others of its region in its cell are in the same box.
    material, region : (M,) int
    """

    boxes: Boxes
    features: npt.NDArray[np.float64]
    seed: npt.NDArray[Any]
    material: npt.NDArray[Any]
    region: npt.NDArray[Any]

    def typicality(self, chosen: npt.NDArray[np.bool_] | None = None) -> Typicality:
        """Typicality of the materials of all seeds, or of those that `chosen` (N,) bool keeps."""
        keep = np.ones(len(self.seed), bool) if chosen is None else chosen[self.seed]
        return Typicality(self.boxes, fit_boxes(self.features[keep], self.material[keep], self.region[keep]))

    def of_places(self) -> npt.NDArray[np.float64]:
        """Typicality (P,) of separate places by the boxes of all others: of the median box of each that is not the only
        one of its material, at most `MOST_PLACES` a material. It tells how alike the places of one are on this texture.
        """
        typicality = []
        for material in np.unique(self.material):
            regions = np.unique(self.region[self.material == material])
            for region in regions[:: -(-len(regions) // MOST_PLACES)] if len(regions) > 1 else ():
                mine = (self.region == region) & (self.material == material)
                model = fit_boxes(self.features[~mine], self.material[~mine], self.region[~mine])
                distance = model.squared_distance(self.features[mine]).min(axis=0)
                typicality.append(scipy.special.chdtrc(self.boxes.dimensions, np.median(distance)))
        return np.array(typicality)

    def threshold(self) -> float:
        """Typicality that one place in `ONE_IN` of what is known lies below, by the places of the seeds.

        The k-th least of n exchangeable places has k / (n + 1) below it (conformal prediction; Vovk, Gammerman and
        Shafer 2005, "Algorithmic learning in a random world", Springer): with fewer than `ONE_IN` - 1 places there is
        no such typicality, and the threshold is 0.
        """
        typicality = np.sort(self.of_places())
        rank = (len(typicality) + 1) // ONE_IN
        return float(typicality[rank - 1]) if rank else 0.0


def seed_boxes(boxes: Boxes, seeds: SeedTexels) -> SeedBoxes:
    """Read the boxes that contain the seeds of a texture, from the top to the bottom."""
    row, column = seeds.rows // boxes.cell, seeds.columns // boxes.cell
    groups = np.lexsort((seeds.material, seeds.region, column, row, column // GROUP_CELLS, row // GROUP_CELLS))
    keys = np.stack([row, column, seeds.region, seeds.material])[:, groups]
    distinct = groups[np.append(True, (keys[:, 1:] != keys[:, :-1]).any(axis=0))]
    row, column = row[distinct], column[distinct]
    features = np.empty((len(distinct), boxes.dimensions))
    group = np.stack([row // GROUP_CELLS, column // GROUP_CELLS])
    starts = np.flatnonzero(np.append(True, (group[:, 1:] != group[:, :-1]).any(axis=0)))
    for mine in np.split(np.arange(len(distinct)), starts[1:]):
        top, left = row[mine].min(), column[mine].min()
        means, _ = boxes.features(slice(top, row[mine].max() + 1), slice(left, column[mine].max() + 1))
        features[mine] = means[:, row[mine] - top, column[mine] - left].T
    return SeedBoxes(boxes, features, distinct, seeds.material[distinct], seeds.region[distinct])
