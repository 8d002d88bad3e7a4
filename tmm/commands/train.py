"""``tmm train``: a classifier for a library of textures."""

import click

from skyshine.schemas.commands import allow_outside_option, emit_json, json_option
from skyshine.schemas.quantity import quantity


@click.command(epilog="Example: tmm train library.tmm.yaml --out library.tmm-model.h5")
@click.argument("job", type=click.Path())
@click.option("--out", type=click.Path(), required=True, help="Model file to write; a job names it as `model`.")
@allow_outside_option
@json_option
def command(job: str, out: str, as_json: bool) -> None:
    """Train one classifier on the seeds of all textures of JOB, with the classifier settings of its first texture.

    Quality and calibration are measured on textures omitted from the training.
    """
    import yaml

    from skyshine.materials.library import load_library
    from skyshine.tmm.classify.model_file import write_model
    from skyshine.tmm.job.load import load_job
    from skyshine.tmm.training.library import train_library

    library = load_library()
    loaded, folder = load_job(job, library)
    model, measured = train_library(loaded, folder, library)
    quality = {
        "textures": len(loaded.textures),
        "tested_texels": measured.quality.tested,
        "overall_accuracy": measured.quality.overall_accuracy,
        "mean_iou": measured.quality.mean_iou,
        "calibration_error": measured.quality.calibration_error,
    }
    first_texture = loaded.textures[0]
    settings = {
        "classifier": first_texture.classifier.model_dump(mode="json"),
        "held_out": first_texture.held_out.model_dump(mode="json"),
    }
    text = yaml.safe_dump(settings | {"textures": [texture.image for texture in loaded.textures]}, sort_keys=False)
    write_model(model, out, text, f"materials {library.version}", quality)
    if as_json:
        counts = {name: value for name, value in quality.items() if isinstance(value, int)}
        shares = {name: quantity(value, "1") for name, value in quality.items() if isinstance(value, float)}
        emit_json({"file": out, "materials": list(model.names), **counts, **shares})
        return
    click.echo(f"{out}: {len(model.names)} materials from {len(loaded.textures)} textures")
    if measured.quality.tested:
        click.echo(
            f"  textures held out: accuracy {measured.quality.overall_accuracy:.3f}, mean IoU "
            f"{measured.quality.mean_iou:.3f}, calibration error {measured.quality.calibration_error:.3f} "
            f"({measured.quality.tested} texels)"
        )
    else:
        click.echo("  no texture held out: the job has a single one")
