"""``tmm info``: what a texture database holds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.tmm.database.reader import TmmFile


@click.command(epilog="Example: tmm info build/yellowstone_road.tmm.h5")
@click.argument("file", type=click.Path())
@json_option
def command(file: str, as_json: bool) -> None:
    """Show what FILE holds: texture, materials, levels, quality; of a trained model also its image encoder."""
    from skyshine.tmm.classify.model_file import is_model
    from skyshine.tmm.database.reader import open_tmm

    if is_model(file):
        _show_model(file, as_json)
        return
    with open_tmm(file) as source:
        result = {
            "file": file,
            **{key: _plain(value) for key, value in source.attributes.items()},
            "levels": source.levels,
            "materials": [
                {"code": code, "name": name, "share": quantity(source.usage[name], "1")}
                for code, name in source.materials.items()
            ],
            "texels": source.group_attributes("usage"),
            "quality": source.group_attributes("quality"),
            "confusion": _confusion(source),
            "mixtures": int(source.array("composites/composite").size),
        }
    if as_json:
        emit_json(result)
    else:
        _print(result)


def _show_model(file: str, as_json: bool) -> None:
    from skyshine.schemas.hdf5 import read_file
    from skyshine.tmm.classify.model_file import FILETYPE, read_model

    model = read_model(file)
    root, attributes = read_file(file, FILETYPE)
    keys = ("filetype", "format_version", "data_version", "generator", "content_sha256")
    encoder = {} if model.tokens is None else {key: _plain(value) for key, value in vars(model.tokens.encoder).items()}
    quality = {key: _plain(value) for key, value in root.groups["quality"].attributes.items()}
    result = {
        "file": file,
        **{key: str(attributes[key]) for key in keys},
        "materials": list(model.names),
        "method": "colour" if model.network is None else "textured",
        "quality": quality,
        "encoder": None if model.tokens is None else {**encoder, "components": model.tokens.count},
    }
    if as_json:
        emit_json(result)
        return
    for key in keys:
        click.echo(f"{key}: {result[key]}")
    click.echo(f"classifier of textures, {result['method']}: {', '.join(model.names)}")
    if quality.get("tested_texels"):
        click.echo(
            f"textures held out: accuracy {quality['overall_accuracy']:.3f}, mean IoU {quality['mean_iou']:.3f} "
            f"({quality['tested_texels']} texels of {quality['textures']} textures)"
        )
    if encoder:
        click.echo(
            f"image encoder, which a job names in classifier.features: SHA-256 {encoder['sha256']}, output "
            f"'{encoder['output']}', {encoder['rows']} x {encoder['columns']} tokens of {encoder['side']} x "
            f"{encoder['side']} texels, {model.tokens.count if model.tokens else 0} components"
        )


def _confusion(source: TmmFile) -> dict[int, list[int]]:
    """Held-out texels of each material that has seeds, found as unknown and as each of these materials."""
    if not source.has("quality/confusion"):
        return {}
    return dict(zip(source.array("quality/material").tolist(), source.array("quality/confusion").tolist(), strict=True))


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def _print(result: dict[str, Any]) -> None:
    for key in (
        "filetype",
        "format_version",
        "data_version",
        "generator",
        "content_sha256",
        "texture",
        "texture_sha256",
    ):
        click.echo(f"{key}: {result[key]}")
    click.echo(
        f"size: {result['width']} x {result['height']} {result['pixel_type']}, {result['encoding']}, "
        f"{result['levels']} levels, {result['mixtures']} mixtures"
    )
    if "geo_affine" in result:
        click.echo(f"ground: {result['geo_crs'] or 'no coordinate system named'}, affine {result['geo_affine']}")
    click.echo("materials (code, name, share; then held-out texels found as unknown and as each material):")
    width = max(len(material["name"]) for material in result["materials"])
    for material in result["materials"]:
        counts = " ".join(f"{count:6d}" for count in result["confusion"].get(material["code"], []))
        click.echo(f"  {material['code']:5d}  {material['name']:{width}}  {material['share']['value']:.4f}  {counts}")
    quality = result["quality"]
    if not result["confusion"]:
        return
    click.echo(
        "held-out seeds (where seeds were drawn, often the clear places; elsewhere it may be less): "
        f"accuracy {quality['overall_accuracy']:.3f}, mean IoU {quality['mean_iou']:.3f}, "
        f"{quality['tested_texels']} of {quality['seed_texels']} texels in {quality['folds']} parts"
    )
