"""Writes the reflectance tables of the material library from the source spectra."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from mat.maintain.materials.recipes import Piece, Recipe, Recipes
from mat.maintain.materials.resample import compact_grid, fine_grid, project
from skyshine import materials
from skyshine.schemas.arrays import Floats
from skyshine.schemas.documents import load_model
from skyshine.schemas.errors import InputError

LOWEST = 0.3  # um
_Stretch = tuple[float, float, str, str]  # ends [um], kind and origin
# A joint is matched over this relative width.
_JOINT = 0.04
# Bands whose means the compact table must keep, and how closely.
_BANDS = ((0.3, 0.7), (0.7, 2.5), (3.0, 5.0), (8.0, 12.0))
_BAND_TOLERANCE = 0.002  # largest change of a band mean of reflectance on the compact grid


def compose(recipes: Recipes, name: str, folder: Path) -> tuple[Floats, Floats, Floats, list[_Stretch]]:
    """Spectrum of a recipe on the fine grid, and where each stretch comes from.

    Returns
    -------
    wavelength, reflectance, absorptance : (F,) arrays
    stretches : list of (lower, upper, kind, note)
    """
    recipe = recipes.recipes[name]
    if recipe.like:
        return compose(recipes, recipe.like, folder)
    if recipe.mixture:
        return _mixed(recipes, recipe, folder)
    return _joined(recipe, folder)


def _mixed(recipes: Recipes, recipe: Recipe, folder: Path) -> tuple[Floats, Floats, Floats, list[_Stretch]]:
    """Spectra of parts that lie side by side, weighted by their areas."""
    fine = fine_grid(LOWEST, recipe.upper)
    reflectance = np.zeros(fine.shape)
    for part, share in recipe.mixture.items():
        wavelength, values, *_ = compose(recipes, part, folder)
        reflectance += share * np.interp(fine, wavelength, values)
    words = " and ".join(f"{share:g} of {part}" for part, share in recipe.mixture.items())
    return fine, reflectance, 1.0 - reflectance, [(LOWEST, recipe.upper, "modelled", f"by area {words}")]


def _joined(recipe: Recipe, folder: Path) -> tuple[Floats, Floats, Floats, list[_Stretch]]:
    """Spectrum of the pieces of a recipe."""
    fine = fine_grid(LOWEST, recipe.upper)
    reflectance = np.full(fine.shape, np.nan)
    absorptance = np.full(fine.shape, np.nan)
    stretches: list[_Stretch] = []
    end = LOWEST
    before: Piece | None = None
    for piece in recipe.pieces:
        lower, upper = piece.range
        inside = (fine >= lower) & (fine <= upper)
        value, absorbed = piece.evaluate(folder, fine)
        if piece.match and before is not None:
            value = np.clip(value * _scale(before, piece, folder), 0.0, 1.0)
            absorbed = 1.0 - value
        reflectance[inside], absorptance[inside] = value[inside], absorbed[inside]
        if lower > end:
            stretches.append((end, lower, "held" if before is None else "interpolated", ""))
        stretches.append((max(lower, LOWEST), upper, piece.kind, _origin(piece)))
        end, before = upper, piece
    if end < recipe.upper:
        stretches.append((end, recipe.upper, "held", ""))
    measured = np.isfinite(reflectance)
    return (
        fine,
        np.interp(fine, fine[measured], reflectance[measured]),
        np.interp(fine, fine[measured], absorptance[measured]),
        stretches,
    )


def _scale(before: Piece, piece: Piece, folder: Path) -> float:
    """Factor that brings the stretch to the level of the one before it at their joint."""
    end, start = before.range[1], piece.range[0]
    below = np.linspace(end * (1.0 - _JOINT), end, 50)
    beyond = below if start <= end * 1.001 else np.linspace(start, start * (1.0 + _JOINT), 50)
    return float(before.evaluate(folder, below)[0].mean() / piece.evaluate(folder, beyond)[0].mean())


def _origin(piece: Piece) -> str:
    names = piece.sample or ", ".join(piece.files)
    text = f"[{piece.source}] {names}" if names else f"[{piece.source}]"
    if piece.value is not None:
        text += f" {piece.value:g}"
    if piece.thickness:
        text += f", pane of {piece.thickness * 1000:g} mm"
    if piece.film:
        text += f", {piece.film} of {piece.film_thickness * 1e9:g} nm on its back face"
    if piece.ratio:
        text += f" x {piece.ratio.over} / {piece.ratio.under}"
    if piece.level:
        text += f", scaled to {piece.level.absorptance:g} over {piece.level.over} ({piece.level.source})"
    if piece.match:
        text += ", scaled to meet the stretch below"
    return f"{text}; {piece.note}" if piece.note else text


def table(recipes: Recipes, name: str, folder: Path) -> tuple[Floats, Floats, Floats | None, list[_Stretch]]:
    """Compact table of a recipe: nodes, reflectance, absorptance or None, stretches.

    Raises
    ------
    InputError
        A band mean changed by more than the tolerance.
    """
    fine, reflectance, absorptance, stretches = compose(recipes, name, folder)
    nodes = compact_grid(LOWEST, float(fine[-1]))
    compact = np.clip(project(fine, reflectance, nodes), 0.0, 1.0)
    for lower, upper in _BANDS:
        band = (fine >= lower) & (fine <= upper)
        change = np.mean(np.interp(fine[band], nodes, compact) - reflectance[band])
        if abs(change) > _BAND_TOLERANCE:
            raise InputError(f"the mean over {lower}-{upper} um changes by {change:.4f} on the compact grid; refine it")
    if "pane" not in recipes.sources_of(name):
        return nodes, compact, None, stretches
    absorbed = np.clip(project(fine, absorptance, nodes), 0.0, 1.0 - compact)
    return nodes, compact, absorbed, stretches


def write(recipes: Recipes, name: str, folder: Path, out: Path) -> None:
    """Write `NAME.csv` with its comment header."""
    recipe = recipes.recipes[name]
    nodes, reflectance, absorptance, stretches = table(recipes, name, folder)
    whose = f"the spectrum of {recipe.like}: " if recipe.like else ""
    lines = [
        f"# material: {name}",
        f"# sample: {whose}{' '.join(recipe.sample.split())}",
        "# quantity: hemispherical reflectance at near-normal incidence, fraction of 1, against wavelength in um",
        "# method: sources joined over the stretches below, projected on a logarithmic grid (least squares on hat "
        "functions, which keeps band means)",
        *(f"# {key}: {' '.join(recipes.citations[key].split())}" for key in recipes.sources_of(name)),
    ]
    for lower, upper, kind, note in stretches:
        lines.append(f"# range: {lower:g} {upper:g} {kind}; {note}".rstrip("; "))
    lines.append("wavelength_um,reflectance" + ("" if absorptance is None else ",absorptance"))
    columns = [nodes, reflectance] + ([] if absorptance is None else [absorptance])
    for row in zip(*columns, strict=True):
        lines.append(f"{row[0]:.5g}," + ",".join(f"{value:.5f}" for value in row[1:]))
    (out / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


@click.command()
@click.argument("spectra", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("names", nargs=-1)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), help="Where to write; default: the package.")
def main(spectra: Path, names: tuple[str, ...], out: Path | None) -> None:
    """Derive the library's reflectance tables from the collected source spectra in SPECTRA.

    Example: python -m mat.maintain.materials ../spectra concrete
    """
    recipes = load_model(materials.path("ref/recipes.yaml"), Recipes)
    out = out or materials.path("ref")
    out.mkdir(parents=True, exist_ok=True)
    for name in names or recipes.recipes:
        if name not in recipes.recipes:
            raise click.BadParameter(f"no recipe '{name}'")
        write(recipes, name, spectra, out)
        click.echo(out / f"{name}.csv")


if __name__ == "__main__":
    main()
