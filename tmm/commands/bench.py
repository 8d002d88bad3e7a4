"""``tmm bench``: error against run time of the classifiers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import allow_outside_option, echo_table, emit_json, json_option, progress
from skyshine.schemas.process_memory import peak_memory
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.tmm.report.bench import Row


@click.command(epilog="Example: tmm bench library.tmm.yaml truth.yaml --plot bench.png")
@click.argument("job", type=click.Path())
@click.argument("truth", type=click.Path())
@click.option("--plot", "picture", type=click.Path(), help="PNG file to draw error against run time in.")
@allow_outside_option
@json_option
def command(job: str, truth: str, picture: str | None, as_json: bool) -> None:
    """Error against run time of all classifiers and settings on the textures of JOB, against the labels of TRUTH.

    TRUTH is a YAML file with the key `truth`: names of textures, each with `image` and `palette` of a label image.
    Each classifier stands alone, then seeds and the graph of superpixels together with the `model` that a texture
    names, and two classifiers of scikit-learn. Confidence is as the classifiers give it, before calibration. Needs
    scikit-learn, the extra 'train'.
    """
    import shutil
    from pathlib import Path

    from skyshine.materials.library import load_library
    from skyshine.tmm.job.load import load_job
    from skyshine.tmm.report import bench

    library = load_library()
    loaded, folder = load_job(job, library)
    colours = {}
    with progress(len(loaded.textures), "classifying") as advance:
        for entry, number, rows in bench.bench(loaded, folder, Path(truth), library):  # noqa: B007 (the last rows count every texture)
            colours[entry.name] = number
            advance(1)
    if picture:
        bench.plot(rows, Path(picture))
    peak = peak_memory()
    result = {
        "job": job,
        "distinct_colours": colours,
        "peak_memory": None if peak is None else quantity(peak / 2**20, "MiB"),
        "orfeo_toolbox": (
            "installed; compare by its own commands" if shutil.which("otbcli_ImageClassifier") else "not installed"
        ),
        "classifiers": [_report(row) for row in rows],
    }
    if as_json:
        emit_json(result)
    else:
        _print(result)


def _report(row: Row) -> dict[str, Any]:
    quality = row.quality
    return {
        "name": row.name,
        "mean_iou": quantity(quality.mean_iou, "1"),
        "overall_accuracy": quantity(quality.overall_accuracy, "1"),
        "calibration_error": quantity(quality.calibration_error, "1"),
        "training": quantity(row.training, "s"),
        "classifying": quantity(row.classifying, "s"),
        "rate": quantity(row.rate / 1e6, "Mtexel s^-1"),
    }


def _print(result: dict[str, Any]) -> None:
    keys = ("mean_iou", "overall_accuracy", "calibration_error", "training", "rate")
    rows = [[each["name"], *(f"{each[key]['value']:.3f}" for key in keys)] for each in result["classifiers"]]
    echo_table(("classifier", "mean IoU", "accuracy", "calibration error", "training [s]", "Mtexel/s"), rows)
    numbers = result["distinct_colours"].values()
    peak = result["peak_memory"]
    memory = "not measured on this system" if peak is None else f"{peak['value']:.0f} MiB"
    click.echo(f"distinct colours of a texture: {min(numbers)} to {max(numbers)}; peak memory {memory}")
    click.echo(f"Orfeo ToolBox: {result['orfeo_toolbox']}")
