"""``mat needs``: what a scene reads, as the needs of its job."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.schemas.commands import allow_outside_option, emit_json, json_option, progress
from skyshine.schemas.errors import InputError


@click.command(epilog="Example: mat needs scene.yaml --job job.yaml --output scene_job.yaml")
@click.argument("scene", type=click.Path())
@click.option("--job", type=click.Path(), help="Job whose site places the Sun; its tables must reach what is read.")
@click.option("--output", type=click.Path(dir_okay=False), help="Copy of the job with these needs, in its folder.")
@click.option(
    "--least-share",
    type=click.FloatRange(0, 0.5),
    default=1e-3,
    show_default=True,
    help="Of the pixels; materials with less are left out, and the most similar one stands for them.",
)
@allow_outside_option
@json_option
def command(scene: str, job: str | None, output: str | None, least_share: float, as_json: bool) -> None:
    """Cast the rays of the camera of SCENE, and print what its frames read as the key 'needs' of a job.

    A build leaves out what lies outside: ranges, elevations, altitudes, slopes and azimuths, materials, hours, bands,
    elevations of the source.
    """
    from skyshine.mat.job.load import load_job
    from skyshine.mat.render.needs_text import needs_text, with_needs
    from skyshine.mat.render.query_limits import scene_needs
    from skyshine.mat.render.reads import scene_reads
    from skyshine.mat.render.scene_file import load_scene
    from skyshine.materials.library import load_library

    if output is not None and job is None:
        raise InputError("found --output without --job; allowed: with the job that is copied; add --job")
    loaded_scene = load_scene(scene)
    loaded = None if job is None else load_job(job)
    if loaded is not None and output is not None:
        place = Path(output).resolve()
        if place.parent != loaded.folder or place == loaded.file.resolve():
            raise InputError(
                f"found --output {output}; allowed: another file in the folder of the job, {loaded.folder}, to which"
                " its paths are relative"
            )
    needs = scene_needs(loaded_scene, scene_reads(loaded_scene, progress), load_library(), loaded, least_share)
    text = needs_text(loaded_scene.document.file.name, needs)
    if loaded is not None and output is not None:
        _write(Path(output), with_needs(loaded.file.read_text(encoding="utf-8"), text))
    if as_json:
        emit_json(
            {
                "needs": {limit.key: limit.value for limit in needs.limits},
                "reasons": {limit.key: limit.reason for limit in needs.limits},
                "replaced_materials": needs.replaced,
                "replaced_share": needs.replaced_share,
                "notes": list(needs.notes),
            }
        )
        return
    click.echo(text, nl=False) if output is None else click.echo(output)


def _write(path: Path, text: str) -> None:
    """Write a job whole, once it is known to load."""
    from skyshine.mat.job.load import load_job
    from skyshine.schemas.whole_files import part_file

    part = part_file(path)
    try:
        part.write_text(text, encoding="utf-8")
        load_job(part)
        part.replace(path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}; name another file", file=path) from None
    finally:
        part.unlink(missing_ok=True)
