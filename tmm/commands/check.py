"""``tmm check``: a job with its images and seeds, or a database against ground truth."""

from typing import Any

import click

from skyshine.schemas.commands import allow_outside_option, emit_json, json_option
from skyshine.schemas.errors import InputError
from skyshine.tmm.commands.problems import raise_all


@click.command(epilog="Example: tmm check demo/job.tmm.yaml")
@click.argument("job", metavar="JOB|DATABASE", type=click.Path())
@click.option(
    "--truth",
    metavar="LABELS",
    type=click.Path(),
    help="Compare DATABASE with the ground truth in LABELS: a YAML file that names a label image (image, palette), or"
    " a list of answers.",
)
@allow_outside_option
@json_option
def command(job: str, truth: str | None, as_json: bool) -> None:
    """Check JOB: read its images and find its seeds; nothing is classified or written. All textures are checked even if
    one is wrong; the exit status is then 2.

    With --truth, print accuracy and confusion of a DATABASE. A list of answers at places drawn at random ('tmm suggest
    --random') gives the share of right texels, with its interval of 95 % confidence. What wrong texels cost in kelvin
    is a row of 'mat report'.
    """
    if truth is not None:
        from skyshine.tmm.commands.ground_truth import compare_with_truth

        compare_with_truth(job, truth, as_json)
        return
    from skyshine.materials.library import load_library
    from skyshine.tmm.job.load import load_job
    from skyshine.tmm.mapping.run import check

    library = load_library()
    loaded, folder = load_job(job, library)
    reports, problems = [], []
    for entry in loaded.textures:
        try:
            reports.append(check(entry, folder, library))
        except InputError as problem:
            problems.append((entry.name, problem))
    if as_json:
        failed = [{"name": name, "error": str(problem)} for name, problem in problems]
        emit_json({"job": job, "textures": reports, "failed": failed})
    else:
        for report in reports:
            _print(report)
    raise_all(problems, len(loaded.textures))
    if not as_json:
        click.echo(f"{job}: OK")


def _print(report: dict[str, Any]) -> None:
    click.echo(
        f"{report['name']}: {report['image']}, {report['width']} x {report['height']} {report['pixel_type']}, "
        f"{report['encoding']}, {report['texels_with_data']} texels with data; materials by {report['way']}"
    )
    click.echo("  taken as " + "; ".join(f"{key}: {value}" for key, value in report["taken_as"].items()))
    lost = ", ".join(f"{reason} {100 * share['value']:.3g} %" for reason, share in report["without_data"].items())
    if lost:
        click.echo(f"  without data: {lost}")
    for warning in report["warnings"]:
        click.echo(f"  warning: {warning}")
    for name, count in report["seed_texels"].items():
        click.echo(f"  {name}: {count} seed texels")
    if report["conflicting_seed_texels"]:
        click.echo(f"  skipped, claimed by several materials: {report['conflicting_seed_texels']} texels")
    for cluster in report["clusters"]:
        click.echo(
            f"  cluster {cluster['number']}: {cluster['colour']}, {100 * cluster['share']['value']:.1f} %, "
            f"{cluster['name'] or 'not named, stays unknown'}"
        )
