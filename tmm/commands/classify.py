"""``tmm classify``: map the textures of a job to materials."""

import click

from skyshine.schemas.commands import emit_json, json_option, progress, quantity


@click.command(epilog="Example: tmm classify demo.tmm.yaml --out build")
@click.argument("job", type=click.Path())
@click.option("--out", type=click.Path(), help="Output folder; by default the one that the job names.")
@json_option
def command(job: str, out: str | None, as_json: bool) -> None:
    """Map the texels of all textures of JOB to materials and write one database for each."""
    from skyshine.materials.library import load_library
    from skyshine.tmm.run import classify, load_job

    library = load_library()
    loaded, folder = load_job(job, library)
    reports = []
    with progress(len(loaded.textures), "classifying") as advance:
        for result, path in classify(loaded, folder, out, library):
            reports.append(_report(result, path))
            advance(1)
    if as_json:
        emit_json({"textures": reports})
        return
    for report in reports:
        _print(report)


def _report(result, path) -> dict:
    usage = dict(zip(result.names, result.usage.tolist()))
    return {
        "file": str(path),
        "name": result.job.name,
        "width": result.texture.width,
        "height": result.texture.height,
        "distinct_colours": result.distinct_colours,
        "usage": {name: quantity(share, "1") for name, share in usage.items()},
        "unknown": quantity(max(1 - sum(usage.values()), 0.0), "1"),
        "mean_confidence": quantity(float(result.confidence[result.texture.valid].mean()), "1"),
        "held_out_texels": result.quality.tested,
        "overall_accuracy": quantity(result.quality.overall_accuracy, "1"),
        "mean_iou": quantity(result.quality.mean_iou, "1"),
    }


def _print(report: dict) -> None:
    click.echo(f"{report['file']}: {report['width']} x {report['height']}")
    for name, share in report["usage"].items():
        click.echo(f"  {100 * share['value']:5.1f} %  {name}")
    click.echo(f"  {100 * report['unknown']['value']:5.1f} %  unknown")
    if report["held_out_texels"]:
        click.echo(
            f"  held-out seeds: accuracy {report['overall_accuracy']['value']:.3f}, mean IoU "
            f"{report['mean_iou']['value']:.3f} ({report['held_out_texels']} texels)"
        )
    else:
        click.echo("  held-out seeds: none (each material has a single region); draw a second polygon of each")
