"""The ``.band`` database of one band."""

from __future__ import annotations

from pathlib import Path

from skyshine.mat.job.extra_tables import NORMALISATION_BY_ANGLE
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.plan import Task
from skyshine.mat.products.product import Product, TaskReport
from skyshine.mat.scene.atmosphere import materials_digest
from skyshine.mat.scene.bands import response_of
from skyshine.mat.scene.sources import LONGEST_WAVE, solar_spectrum
from skyshine.mat.tables.band import band_group, with_fine_normalisation
from skyshine.mat.tables.files import BAND, BAND_WITH_EXTRAS
from skyshine.materials.library import load_library


def run(
    task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...], fresh: bool, report: TaskReport
) -> None:
    """Build the properties of a band; arguments as `products.run_task`."""
    library = load_library()
    band = loaded.job.bands[task.band - 1]
    resolved = {
        "band": band.model_dump(mode="json", exclude={"name"}),
        "materials": list(materials),
        "materials_sha256": materials_digest(library, materials),
    }
    fine = NORMALISATION_BY_ANGLE in loaded.job.extra_tables
    if fine:
        resolved |= {"extra_tables": [NORMALISATION_BY_ANGLE], "seed": loaded.job.accuracy.seed}
    product = Product(
        folder / task.files[0], BAND_WITH_EXTRAS if fine else BAND, f"materials {library.version}", resolved
    )
    if not fresh and product.is_there():
        report.kept = True
        return
    with report.stage("tables"):
        chosen = [library[name] for name in materials]
        root = band_group(response_of(band), chosen, solar_spectrum(LONGEST_WAVE))
    if fine:
        with report.stage(NORMALISATION_BY_ANGLE):
            root = with_fine_normalisation(root, chosen, loaded.job.accuracy.seed)
    with report.stage("write"):
        product.write(root)
