"""A material of one's own: the files of one of the library with other numbers or another spectrum."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path

from skyshine.mat.job.own_materials import (
    BORDER,
    free_codes,
    levelled,
    refuse_transmitting,
    with_emissivity,
    with_spectrum,
)
from skyshine.materials.files import USER
from skyshine.materials.library import ENVIRONMENT, Material, MaterialLibrary, load_library
from skyshine.materials.records import Back
from skyshine.materials.spectrum_files import FileSpectrum
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.whole_files import write_whole

NAME = r"[a-z][a-z0-9_]*"


@dataclass(frozen=True)
class OwnMaterial:
    """What was written.

    Attributes
    ----------
    name : str
    code : int
    folder : Path
        The library it was written to; MATERIALS_DATABASE must name it.
    files : tuple of Path
    borrowed : tuple of (float, float)
        Stretches of the spectrum [um] that come from the material that it is like.
    """

    name: str
    code: int
    folder: Path
    files: tuple[Path, ...]
    borrowed: tuple[tuple[float, float], ...]


def new_material(
    name: str,
    *,
    like: str,
    folder: str | os.PathLike[str],
    absorptance: float | None = None,
    emissivity: float | None = None,
    thermal_emissivity: float | None = None,
    spectrum: FileSpectrum | None = None,
    values: Mapping[str, float] | None = None,
    source: str = USER,
    description: str | None = None,
    code: int | None = None,
) -> OwnMaterial:
    """Write the files of a material that is like one of the library but for what is given.

    Parameters
    ----------
    name : str
        Lower-case letters, digits and underscores.
    like : str
        A material that lets no light pass.
    folder : path
        A library of one's own; made where there is none.
    absorptance, thermal_emissivity : float, optional
        Means over sunlight at the ground and over blackbody radiation of 300 K; the spectrum below and beyond 2.5 um is
        scaled to them.
    emissivity : float, optional
        Emissivity at all wavelengths beyond 2.5 um, so of every infrared band; not with thermal_emissivity or a
        spectrum.
    spectrum : FileSpectrum, optional
        Measured spectrum; outside its range the spectrum of `like` applies.
    values : mapping of str to float, optional
        Numbers of ``ht/NAME.yaml`` by dotted field name, layers counted from 1: "layers.1.thickness"; SI.
    source : str
        Source of all values given here except the spectrum.
    description : str, optional
    code : int, optional
        Code of the material; by default the first free one from 1001.

    Raises
    ------
    InputError
        A name or code that is taken, a material that lets light pass, or numbers that no scaling reaches.
    """
    target = Path(folder)
    library = refuse_taken(name, like, target)
    pattern = library[like]
    number = next(free_codes(library)) if code is None else code
    if number in {library.code(existing) for existing in library.names}:
        raise InputError(f"code {number} is that of '{library.by_code(number).name}'; remove --code for a free one")
    wavelength, reflectance, borrowed = with_spectrum(pattern, spectrum)
    if emissivity is not None:
        if thermal_emissivity is not None or spectrum is not None:
            raise InputError(
                "found emissivity beside a spectrum or a thermal emissivity; allowed: one; remove the others"
            )
        reflectance = with_emissivity(wavelength, reflectance, emissivity)
    reflectance, levels = levelled(wavelength, reflectance, absorptance, thermal_emissivity, source)
    if emissivity is not None:
        levels.append(f"beyond {BORDER:g} um an emissivity of {emissivity:g} at all wavelengths ({source})")
    text = " ".join(description.split()) if description else f"Like {like}, with values of the user"
    contents = {
        target / "ht" / f"{name}.yaml": _thermal_text(pattern, values or {}, source, text),
        target / "ref" / f"{name}.csv": _spectrum_text(
            name, pattern, wavelength, reflectance, spectrum, borrowed, levels
        ),
        target / "spec" / f"{name}.yaml": _specular_text(pattern, text),
    }
    for file, content in contents.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, content)
    index = target / "mat.yaml"
    before = index.read_text(encoding="utf-8").rstrip("\n") if index.is_file() else "data_version: 1.0.0\nmaterials:"
    entry = f"  - {{code: {number}, name: {name}, group: {pattern.group}, description: {json.dumps(text)}}}"
    write_whole(index, f"{before}\n{entry}\n")
    load_library(target)[name]  # what is written is read at once, so that a fault shows here
    return OwnMaterial(name, number, target, (index, *contents), borrowed)


def refuse_taken(name: str, like: str, folder: Path) -> MaterialLibrary:
    """The library with a folder of one's own; InputError where a material `name` like another cannot be added to it."""
    if not re.fullmatch(NAME, name):
        raise InputError(f"found '{name[:60]}'; allowed: lower-case letters, digits and underscores, a letter first")
    library = load_library(folder if (folder / "mat.yaml").is_file() else None)
    if name in library:
        raise InputError(f"there is a material '{name}'; choose another name, or edit its files")
    refuse_transmitting(library[like])
    return library


def default_folder() -> Path:
    """The folder that MATERIALS_DATABASE names, or `materials` here."""
    return Path(os.environ.get(ENVIRONMENT) or "materials")


def _spectrum_text(
    name: str,
    pattern: Material,
    wavelength: Floats,
    reflectance: Floats,
    spectrum: FileSpectrum | None,
    borrowed: tuple[tuple[float, float], ...],
    levels: list[str],
) -> str:
    sample = spectrum.title or "spectrum of the user" if spectrum else f"like {pattern.name}"
    lines = [
        f"# material: {name}",
        f"# sample: {sample}",
        "# quantity: hemispherical reflectance at near-normal incidence, fraction of 1, against wavelength in um",
        *(f"# {words}" for words in levels),
    ]
    if spectrum:
        lines.append(f"# file: {spectrum.read_as}")
    # The credit lines of the pattern's sources go with its values.
    lines += [f"# {line}" for line in pattern.reflectance_note.splitlines() if borrowed and _is_citation(line)]
    position = float(wavelength[0])
    for lower, upper in (*borrowed, (float(wavelength[-1]), float(wavelength[-1]))):
        if lower > position:
            lines.append(f"# range: {position:g} {lower:g} measured; {USER}")
        if upper > lower:
            lines.append(f"# range: {lower:g} {upper:g} proxy; {pattern.name}")
        position = upper
    rows = [f"{x:.5g},{y:.5f}" for x, y in zip(wavelength, reflectance, strict=True)]
    return "\n".join([*lines, "wavelength_um,reflectance", *rows]) + "\n"


def _is_citation(line: str) -> bool:
    return not line.startswith(("material:", "sample:", "quantity:", "method:", "range:", "file:"))


def _thermal_text(pattern: Material, stated: Mapping[str, float], source: str, description: str) -> str:
    """`ht/NAME.yaml`: the numbers of the pattern with their sources, and own ones."""

    def shown(key: str, value: object) -> str:
        if key not in stated:
            return _sourced(pattern, key, value)
        return f"{stated[key]:g}" if source == USER else f"{{value: {stated[key]:g}, source: {json.dumps(source)}}}"

    lines = [f"# {description}. m, W m^-1 K^-1, kg m^-3, J kg^-1 K^-1, K, W m^-2 K^-1; plain numbers are the user's."]
    stack = pattern.thermal
    for key, layer in (("skin", stack.skin), *((f"layers.{n}", layer) for n, layer in enumerate(stack.layers, 1))):
        if key != "layers.2":
            lines.append(f"{key.partition('.')[0]}:")
        for position, field in enumerate(fields(layer)):
            lead = "  " if key == "skin" else "  - " if position == 0 else "    "
            lines.append(f"{lead}{field.name}: {shown(f'{key}.{field.name}', getattr(layer, field.name))}")
    lines.append("back:")
    lines += [f"  {line}" for line in _back_lines(stack.back, "back", shown)]
    if stack.light:
        lines.append("light:")
    for number, light in enumerate(stack.light, 1):
        lines.append(f"  - share: {shown(f'light.{number}.share', light.share)}")
        lines.append(f"    extinction: {shown(f'light.{number}.extinction', light.extinction)}")
    for name, part in (("surface", pattern.surface), ("soil", pattern.soil), ("stand", pattern.stand)):
        if part is not None:
            lines.append(f"{name}:")
            for field in fields(part):
                if (key := f"{name}.{field.name}") in pattern.sources or name == "surface":
                    lines.append(f"  {field.name}: {shown(key, getattr(part, field.name))}")
    if pattern.operated:
        lines.append("operated:")
    for name, back in pattern.operated.items():
        lines += [f"  {name}:", *(f"    {line}" for line in _back_lines(back, f"operated.{name}", shown))]
    return "\n".join(lines) + "\n"


def _back_lines(back: Back, prefix: str, formatted: Callable[[str, object], str]) -> Iterator[str]:
    """`KEY: VALUE` of each value that a back has."""
    for field in fields(back):
        value = getattr(back, field.name)
        if field.name == "temperature" and value is None and back.kind in ("fixed", "convective"):
            value = "daily_mean_air"
        if value is not None:
            yield f"{field.name}: {formatted(f'{prefix}.{field.name}', value)}"


def _specular_text(pattern: Material, description: str) -> str:
    lines = [
        f"# {description}: share of the specular lobe in the reflected light (1), its width at half maximum (degree)."
    ]
    lines += [f"{key}: {_sourced(pattern, key, getattr(pattern, key))}" for key in ("specular_fraction", "lobe_fwhm")]
    return "\n".join(lines) + "\n"


def _sourced(pattern: Material, key: str, value: object) -> str:
    source = pattern.sources.get(key, "").replace('"', "'")
    text = str(value).lower() if isinstance(value, bool) else list(value) if isinstance(value, tuple) else value
    return f'{{value: {text}, source: "like {pattern.name}{": " if source else ""}{source}"}}'
