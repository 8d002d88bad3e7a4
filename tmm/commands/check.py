"""``tmm check``: read a job, its images and its seeds."""

import click

from skyshine.schemas.commands import emit_json, json_option


@click.command(epilog="Example: tmm check demo.tmm.yaml")
@click.argument("job", type=click.Path())
@json_option
def command(job: str, as_json: bool) -> None:
    """Check JOB: read its images and find its seeds; nothing is classified or written."""
    from skyshine.materials.library import load_library
    from skyshine.tmm.build import load_texture
    from skyshine.tmm.run import load_job

    library = load_library()
    loaded, folder = load_job(job, library)
    reports = []
    for entry in loaded.textures:
        texture, seeds = load_texture(entry, folder, library)
        counts = {name: int((seeds.material == k).sum()) for k, name in enumerate(seeds.names)}
        reports.append(
            {
                "name": entry.name,
                "image": entry.image,
                "width": texture.width,
                "height": texture.height,
                "pixel_type": texture.pixels.dtype.name,
                "encoding": texture.encoding,
                "texels_with_data": int(texture.valid.sum()),
                "seed_texels": counts,
                "conflicting_seed_texels": seeds.conflicting,
            }
        )
    if as_json:
        emit_json({"job": job, "textures": reports})
        return
    for report in reports:
        click.echo(
            f"{report['name']}: {report['image']}, {report['width']} x {report['height']} {report['pixel_type']}, "
            f"{report['encoding']}, {report['texels_with_data']} texels with data"
        )
        for name, count in report["seed_texels"].items():
            click.echo(f"  {name}: {count} seed texels")
        if report["conflicting_seed_texels"]:
            click.echo(f"  left out, claimed by several materials: {report['conflicting_seed_texels']} texels")
    click.echo(f"{job}: holds")
