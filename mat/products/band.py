"""The ``.band`` database of one band."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from skyshine.mat.measure.band_errors import band_accuracy
from skyshine.mat.products.product import Context, TableIdentity, TaskReport
from skyshine.mat.scene.atmosphere import materials_digest
from skyshine.mat.scene.bands import response_of
from skyshine.mat.scene.sources import LONGEST_WAVE, solar_spectrum
from skyshine.mat.tables.band import band_group
from skyshine.mat.tables.files import BAND
from skyshine.schemas.hdf5 import Group


class BandProduct:
    """Blackbody radiance and material properties of a band."""

    def identity(self, context: Context) -> tuple[TableIdentity, ...]:
        """The one file of a band."""
        job, library, materials = context.loaded.trimmed, context.library, context.materials
        resolved: dict[str, Any] = {
            "band": {
                **job.bands[context.task.band - 1].model_dump(mode="json"),
                "name": job.band_name(context.task.band),
            },
            "materials": list(materials),
            "materials_sha256": materials_digest(library, materials),
            "seed": job.accuracy.seed,
        }
        return (TableIdentity(context.task.files[0], BAND, f"materials {library.version}", resolved),)

    def compute(self, context: Context, report: TaskReport) -> Iterator[Group]:
        """The tables of the band, and their errors."""
        job = context.loaded.trimmed
        with report.stage("tables"):
            materials = [context.library[name] for name in context.materials]
            response = response_of(job.bands[context.task.band - 1])
            root = band_group(response, materials, solar_spectrum(LONGEST_WAVE))
        root.attributes["band"] = job.band_name(context.task.band)
        with report.stage("accuracy"):
            root.groups["accuracy"] = band_accuracy(root, response, materials, job.accuracy.seed)
        yield root
