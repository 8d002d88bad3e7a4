"""``tmm info``: content of a texture database."""

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
    """Show the content of FILE: texture, materials, levels and quality, or the classes of a trained model."""
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
    quality = {key: _plain(value) for key, value in root.groups["quality"].attributes.items()}
    result = {
        "file": file,
        **{key: str(attributes[key]) for key in keys},
        "materials": list(model.names),
        "quality": quality,
    }
    if as_json:
        emit_json(result)
        return
    for key in keys:
        click.echo(f"{key}: {result[key]}")
    click.echo(f"classifier of textures: {', '.join(model.names)}")
    if quality.get("tested_texels"):
        click.echo(
            f"textures held out: accuracy {quality['overall_accuracy']:.3f}, mean IoU {quality['mean_iou']:.3f} "
            f"({quality['tested_texels']} texels of {quality['textures']} textures)"
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
    click.echo(f"expected accuracy, by the confidence of its texels: {quality['expected_accuracy']:.3f}")
    if not quality["tested_places"]:
        click.echo("accuracy on seeds held out was not measured: no material had two places that were not asked for")
        return
    click.echo(
        f"{quality['tested_places']} of {quality['separate_places']} places of seeds held out (often the clear places; "
        f"elsewhere it may be less): accuracy {quality['overall_accuracy']:.3f}, mean IoU {quality['mean_iou']:.3f}, "
        f"{quality['tested_texels']} of {quality['seed_texels']} texels in {quality['folds']} parts"
    )
