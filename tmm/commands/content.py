"""What `tmm preview` prints: content of a texture database or of a trained model, shares of materials of several."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import emit_json
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.tmm.database.reader import TmmFile


def show_shares(files: Sequence[str], as_json: bool) -> None:
    """Print the share of each material in the texels of each file, and of all together."""
    from skyshine.tmm.database.usage import library_usage, read_usage

    shares = {file: read_usage(file) for file in files}
    total = library_usage(files)
    if as_json:
        emit_json(
            {
                "files": {
                    file: {name: quantity(share, "1") for name, share in usage.items()}
                    for file, usage in shares.items()
                },
                "all": {name: quantity(share, "1") for name, share in total.items()},
            }
        )
        return
    for file, usage in [*shares.items(), ("all", total)]:
        click.echo(f"{file}:")
        for name, share in sorted(usage.items(), key=lambda item: -item[1]):
            click.echo(f"  {100 * share:5.1f} %  {name}")


def show_content(file: str, as_json: bool) -> None:
    """Print texture, materials, levels and quality of a database, or the classes of a trained model."""
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
