"""`mat materials`: list, show and plot the material library."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skyshine.mat.commands import completions
from skyshine.mat.commands.fit_material import fit
from skyshine.mat.commands.material_card import draw_card, draw_spectra
from skyshine.mat.commands.new_material import new
from skyshine.schemas.chart_style import chart_style, name_lines, new_figure, save_figure
from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.materials.library import Material, MaterialLibrary
    from skyshine.materials.records import Back

NAMED_LINES = 30  # whose names have room beside the chart


class _ByName(click.Group):
    """`mat materials concrete` is `mat materials show concrete`: what is no subcommand is the name of a material."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if not args or (args[0] not in self.list_commands(ctx) and args[0] not in ctx.help_option_names):
            args = ["show", *args]
        return super().parse_args(ctx, args)


@click.group(
    cls=_ByName,
    subcommand_metavar="[NAME | COMMAND] ...",
    epilog="Example: mat materials concrete --out concrete.png",
)
def command() -> None:
    """The material library: list it, show one material, write your own, fit one to a record.

    With the NAME or code of a material, or without any, `show`.
    """


for part in (fit, new):
    command.add_command(part)


@command.command("show", epilog="Example: mat materials show concrete --out concrete.png")
@click.argument("name", required=False, shell_complete=completions.materials)
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    help="PNG file to draw: the card of NAME, or all reflectances.",
)
@json_option
def show(name: str | None, out: Path | None, as_json: bool) -> None:
    """List the materials, those that a word such as 'road' may mean, or show the one called NAME (or of this code) with
    the source of each value.

    Solar absorptance is the mean over sunlight at the ground (ASTM G173, air mass 1.5); emissivities are of 300 K.
    MATERIALS_DATABASE in the environment adds a folder of your own.
    """
    from skyshine.mat.scene.material_summary import material_summary
    from skyshine.materials.library import load_library
    from skyshine.materials.words import matches

    library = load_library()
    if name and not name.isdecimal() and name not in library and (similar := matches(name, library.names)):
        chosen, name = [library[match] for match in similar], None  # a word for several materials lists them
    else:
        chosen = [_find(library, name)] if name else list(library)
    summaries = {material.name: material_summary(material) for material in chosen}
    if out and name:
        draw_card(chosen[0], summaries[chosen[0].name], out)
    elif out:
        _plot(chosen, out)
    if as_json:
        emit_json(_json(library, chosen, summaries, bool(name)))
    elif name:
        _show(library, chosen[0], summaries[chosen[0].name])
    else:
        _list(library, chosen, summaries)


def _find(library: MaterialLibrary, name: str) -> Material:
    return library.by_code(int(name)) if name.isdecimal() else library[name]


def _list(library: MaterialLibrary, materials: list[Material], summaries: dict[str, dict[str, float]]) -> None:
    click.echo(f"material library {library.version}, {len(library)} materials")
    click.echo(f"{'code':>5}  {'name':<30} {'group':<11} {'solar':>6} {'3-5':>6} {'8-12':>6} {'thermal':>7}")
    click.echo(f"{'':>5}  {'':<30} {'':<11} {'absorp':>6} {'emissivity at 300 K':>21}")
    for material in materials:
        values = " ".join(f"{value:6.3f}" for value in summaries[material.name].values())
        click.echo(f"{material.code:5d}  {material.name:<30} {material.group:<11} {values}")


def _show(library: MaterialLibrary, material: Material, summary: dict[str, float]) -> None:
    click.echo(f"{material.code}  {material.name}  ({material.group}): {material.description}")
    for key, value in summary.items():
        click.echo(f"  {key:<34} {value:.4f}")
    for key, number, units in _numbers(material):
        number_text = (
            f"{number:g}" if isinstance(number, (int, float)) and not isinstance(number, bool) else str(number)
        )
        click.echo(f"  {key:<34} {number_text} {units}".rstrip() + f"    {material.sources[key]}")
    if material.soil is not None:
        click.echo("  answers to soil_moisture of a job: conductivity, heat capacity, reflectance and evaporation")
    if material.stand is not None:
        click.echo("  answers to leaf_area_index of a job: soil is seen and lit through gaps between its leaves")
    if material.thermal.light:
        share = sum(part.share for part in material.thermal.light)
        click.echo(f"  absorbs {share:.0%} of the sunlight it takes below its surface")
    click.echo("reflectance")
    for stretch in material.ranges:
        click.echo(f"  {stretch.lower:7.3f} - {stretch.upper:7.3f} um  {stretch.kind:<12} {stretch.note}")
    for line in material.reflectance_note.splitlines():
        click.echo(f"  {line}")
    if material.transmits:
        click.echo("  transmits: absorptance is given beside reflectance and is less than 1 - reflectance")
    click.echo("references")
    for key, text in _cited(library, material).items():
        click.echo(f"  [{key}] {text}")


def _numbers(material: Material) -> Iterator[tuple[str, object, str]]:
    """Each sourced value of a material as (field, value, units)."""
    units = {"thickness": "m", "conductivity": "W m^-1 K^-1", "density": "kg m^-3", "heat_capacity": "J kg^-1 K^-1"}
    layers = (("skin", material.thermal.skin), *((f"layers.{n}", x) for n, x in enumerate(material.thermal.layers, 1)))
    for prefix, layer in layers:
        for field, unit in units.items():
            yield f"{prefix}.{field}", getattr(layer, field), unit
    yield from _back_numbers("back", material.thermal.back)
    surface = material.surface
    yield "surface.roughness_length", surface.roughness_length, "m"
    yield "surface.wetness", surface.wetness, "1"
    yield "surface.surface_resistance", surface.surface_resistance, "s m^-1"
    yield "surface.canopy", surface.canopy, ""
    yield "surface.snow", surface.snow, ""
    yield "surface.exposure", surface.exposure, ""
    if surface.delivered:
        yield "surface.delivered", surface.delivered, "1"
        yield "surface.delivered_per_kelvin", surface.delivered_per_kelvin, "K^-1"
    for number, part in enumerate(material.thermal.light, 1):
        yield f"light.{number}.share", part.share, "1"
        yield f"light.{number}.extinction", part.extinction, "m^-1"
    if material.soil is not None:
        yield "soil.texture", material.soil.texture, ""
        yield "soil.porosity", material.soil.porosity, "1"
        yield "soil.solid_conductivity", material.soil.solid_conductivity, "W m^-1 K^-1"
        yield "soil.layers", material.soil.layers, ""
    if material.stand is not None:
        yield "stand.leaf_area_index", material.stand.leaf_area_index, "m2 m^-2"
        yield "stand.soil", material.stand.soil, ""
        if material.stand.moisture is not None:
            yield "stand.moisture", material.stand.moisture, "m3 m^-3"
        if "stand.clumping" in material.sources:
            yield "stand.clumping", material.stand.clumping, "1"
    for name, back in material.operated.items():
        yield from _back_numbers(f"operated.{name}", back)
    yield "specular_fraction", material.specular_fraction, "1"
    yield "lobe_fwhm", material.lobe_fwhm, "degree"


def _back_numbers(prefix: str, back: Back) -> Iterator[tuple[str, object, str]]:
    """Each value of a back boundary, as `_numbers`."""
    yield f"{prefix}.kind", back.kind, ""
    if back.kind in ("fixed", "convective"):
        if back.temperature is None:
            yield f"{prefix}.temperature", "daily mean air", ""
        else:
            yield f"{prefix}.temperature", back.temperature, "K"
    numbers = {
        "coefficient": "W m^-2 K^-1",
        "exchange": "W m^-2 K^-1",
        "capacity": "J m^-2 K^-1",
        "heat_flux": "W m^-2",
    }
    for field, unit in numbers.items():
        if getattr(back, field) is not None:
            yield f"{prefix}.{field}", getattr(back, field), unit


def _cited(library: MaterialLibrary, material: Material) -> dict[str, str]:
    """References that the sources of a material's values cite, by key."""
    text = " ".join(material.sources.values())
    return {key: reference for key, reference in library.references.items() if f"[{key}]" in text}


def _json(
    library: MaterialLibrary, materials: list[Material], summaries: dict[str, dict[str, float]], single: bool
) -> dict[str, Any]:
    """The list, or one material with its values and spectrum, as plain values."""
    entries = [_entry(material, summaries[material.name]) for material in materials]
    result: dict[str, Any] = {"data_version": library.version}
    if not single:
        return {**result, "materials": entries}
    material = materials[0]
    numbers = {
        key: {
            **(quantity(value, units) if isinstance(value, (int, float, tuple)) and units else {"value": value}),
            "source": material.sources[key],
        }
        for key, value, units in _numbers(material)
    }
    spectrum = {
        "wavelength": quantity(material.wavelength, "um"),
        "reflectance": quantity(material.reflectance, "1"),
        "absorptance": quantity(material.absorptance, "1"),
        "ranges": [vars(stretch) for stretch in material.ranges],
        "source": material.reflectance_note.splitlines(),
    }
    return {**result, **entries[0], "values": numbers, "spectrum": spectrum, "references": _cited(library, material)}


def _entry(material: Material, summary: dict[str, float]) -> dict[str, Any]:
    return {
        "code": material.code,
        "name": material.name,
        "group": material.group,
        "description": material.description,
        "transmits": material.transmits,
        **{key: quantity(value, "1") for key, value in summary.items()},
    }


def _plot(materials: list[Material], file: Path) -> None:
    """Draw the reflectances of several materials against wavelength."""
    with chart_style():
        figure = new_figure(10, 5)
        axes = figure.add_subplot()
        draw_spectra(axes, materials)
        if len(materials) <= NAMED_LINES:
            name_lines(axes)
        else:
            axes.legend(fontsize=7, ncols=len(materials) // 40 + 1, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        save_figure(figure, file)


@command.command("specular", epilog="Example: mat materials specular --fwhm 30")
@click.option("--fwhm", type=float, required=True, help="Full width of the lobe at half maximum, degree (0.1 to 180).")
@json_option
def specular(fwhm: float, as_json: bool) -> None:
    """Print shininess and normalisation N_s of a specular lobe.

    N_s is the mean over source angles of 0 to 75 degrees from the normal; the spread is that of the single angles
    about it.
    """
    import numpy as np

    from skyshine.mat.radiometry.lobe import SOURCE_ANGLES, normalisation, shininess

    by_angle = normalisation(fwhm)
    mean = by_angle.mean()
    spread = 100.0 * (np.array([by_angle.min(), by_angle.max()]) / mean - 1.0)
    exponent = float(shininess(fwhm))
    if as_json:
        emit_json(
            {
                "fwhm": quantity(fwhm, "degree"),
                "shininess": quantity(exponent, "1"),
                "n_s": quantity(mean, "1"),
                "spread_percent": quantity(spread, "percent"),
                "source_angle": quantity(SOURCE_ANGLES, "degree"),
                "n_s_by_source_angle": quantity(by_angle, "1"),
            }
        )
        return
    click.echo(f"lobe width (FWHM)  {fwhm:g} degree")
    click.echo(f"shininess          {exponent:.6g}")
    click.echo(f"N_s                {mean:.6g}  ({spread[0]:+.2f} % to {spread[1]:+.2f} %)")
    click.echo("source angle       N_s")
    for angle, value in zip(SOURCE_ANGLES, by_angle, strict=True):
        click.echo(f"{angle:6.0f} degree      {value:.6g}")
