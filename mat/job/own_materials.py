"""Materials of a job of its own: each like one of the library but for the numbers that the job gives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from skyshine.mat.atmosphere.sources.solar import ground_sunlight
from skyshine.mat.job.fields import Fraction
from skyshine.mat.job.files import JobFile, TextFile
from skyshine.mat.radiometry.levels import blackbody_weight, odds_factor, with_odds
from skyshine.materials.files import USER, Conductivity, Density, HeatCapacity, Thickness
from skyshine.materials.library import MaterialLibrary, Name, load_library, unknown_material
from skyshine.materials.records import Layer, Material, SpectralRange, ThermalStack
from skyshine.materials.spectrum_files import FileSpectrum, Said, read_spectrum
from skyshine.schemas.arrays import Floats
from skyshine.schemas.documents import StrictModel, Text
from skyshine.schemas.errors import InputError

FIRST_CODE, LAST_CODE = 1001, 65535  # beyond the codes of the library, up to 16 bits
BORDER = 2.5  # um; sunlight below, heat beyond
GAP = 1.2  # neighbouring points of a spectrum further apart than this ratio leave a gap
ROUNDS = 4  # rounds of the two levels, each of which moves the other by the little light beyond its side of the border
THERMAL = ("conductivity", "density", "heat_capacity", "thickness")


class OwnMaterial(StrictModel):
    """A material that is like one of the library but for the numbers given."""

    like: Name = Field(description="Material of the library for all that is not given; one that lets no light pass.")
    spectrum: JobFile | None = Field(
        None,
        description=(
            "Measured spectrum, relative to the job: ECOSTRESS, ASTER, USGS text or CSV; outside its range that of"
            " `like` applies."
        ),
    )
    absorptance: Fraction | None = Field(
        None, description="Absorptance of sunlight at the ground; scales the spectrum below 2.5 um."
    )
    emissivity: Fraction | None = Field(
        None,
        description=(
            "Emissivity at all wavelengths beyond 2.5 um, so in every infrared band; with a spectrum, which keeps its"
            " shape, its mean over radiation of 300 K."
        ),
    )
    conductivity: Conductivity | None = Field(
        None, description="Thermal conductivity of skin and first layer, W m^-1 K^-1."
    )
    density: Density | None = Field(None, description="Density of skin and first layer, kg m^-3.")
    heat_capacity: HeatCapacity | None = Field(None, description="Specific heat of skin and first layer, J kg^-1 K^-1.")
    thickness: Thickness | None = Field(None, description="Thickness of the first layer, m.")
    description: Text | None = Field(None, description="One line that says what it is.")


OwnMaterials = Annotated[dict[Name, OwnMaterial | None], Field(min_length=1)]
Definitions = tuple[tuple[str, OwnMaterial], ...]


def own_names(data: Any) -> tuple[str, ...]:
    """Names that the key `materials` of a job defines, in plain data that nobody has checked."""
    materials = data.get("materials") if isinstance(data, Mapping) else None
    return tuple(str(name) for name in materials) if isinstance(materials, Mapping) else ()


@lru_cache(maxsize=4)
def library_with(library: MaterialLibrary, definitions: Definitions) -> MaterialLibrary:
    """A library with the materials of a job, whose codes are the first free ones from 1001.

    Raises
    ------
    InputError
        A name is codes, a material is like none of the library or like one that lets light pass, or no scaling of a
        spectrum reaches an absorptance.
    """
    codes = free_codes(library)
    return library.with_materials([_made(name, stated, library, next(codes)) for name, stated in definitions])


def job_materials(definitions: Definitions) -> MaterialLibrary:
    """The packaged library with the user's folder and the materials of a job."""
    return library_with(load_library(), definitions) if definitions else load_library()


def free_codes(library: MaterialLibrary) -> Iterator[int]:
    """Codes from 1001 on that no material of a library has."""
    codes = {library.code(name) for name in library.names}
    return (code for code in range(FIRST_CODE, LAST_CODE + 1) if code not in codes)


def refuse_transmitting(pattern: Material) -> None:
    """InputError where a material lets light pass, which no other can be like."""
    if pattern.transmits:
        raise InputError(
            f"'{pattern.name}' lets light pass, so its spectrum has two columns; choose a material that does not"
        )


def _made(name: str, stated: OwnMaterial, library: MaterialLibrary, code: int) -> Material:
    if name in library:
        raise InputError(f"{name}: found a name of the library; allowed: another name; rename it")
    if stated.like not in library:
        raise InputError(f"{name}.like: {unknown_material(stated.like, library.names)}")
    pattern = library[stated.like]
    try:
        refuse_transmitting(pattern)
        spectrum = None if stated.spectrum is None else _read(stated.spectrum)
        wavelength, reflectance, borrowed = with_spectrum(pattern, spectrum)
        if stated.emissivity is not None and spectrum is None:
            reflectance = with_emissivity(wavelength, reflectance, stated.emissivity)
        mean_emissivity = None if spectrum is None else stated.emissivity
        reflectance, levels = levelled(wavelength, reflectance, stated.absorptance, mean_emissivity, USER)
    except InputError as error:
        raise InputError(f"{name}: {error.message}") from None
    sample = f"like {stated.like}" if stated.spectrum is None else stated.spectrum.name
    values = of_first_layer({key: value for key in THERMAL if (value := getattr(stated, key)) is not None})
    return replace(
        pattern,
        code=code,
        name=name,
        description=stated.description or f"Like {stated.like}, with values of the job",
        thermal=_with_values(pattern.thermal, values),
        reflectance=reflectance,
        absorptance=1.0 - reflectance,
        ranges=_ranges(wavelength, borrowed, stated.like),
        sources=pattern.sources | dict.fromkeys(values, USER),
        reflectance_note="\n".join([f"sample: {sample}", *levels]),
    )


def _read(file: TextFile) -> FileSpectrum:
    """The spectrum of a file of a job, which itself says what its columns are."""
    try:
        return read_spectrum(Path(file.path), Said())
    except InputError as error:
        more = "; mat materials new --spectrum takes it with these" if "--" in error.message else ""
        raise InputError(f"{file.name}: {error.message}{more}") from None


def _ranges(wavelength: Floats, borrowed: tuple[tuple[float, float], ...], like: str) -> tuple[SpectralRange, ...]:
    """Stretches of the spectrum that are measured, and those of the material that it is like."""
    ranges, position = [], float(wavelength[0])
    for lower, upper in (*borrowed, (float(wavelength[-1]), float(wavelength[-1]))):
        if lower > position:
            ranges.append(SpectralRange(position, lower, "measured", USER))
        if upper > lower:
            ranges.append(SpectralRange(lower, upper, "proxy", like))
        position = upper
    return tuple(ranges)


def _with_values(stack: ThermalStack, values: Mapping[str, float]) -> ThermalStack:
    """A stack whose skin and first layer have other numbers, by dotted name."""

    def changed(layer: Layer, prefix: str) -> Layer:
        numbers = {key.removeprefix(prefix): value for key, value in values.items() if key.startswith(prefix)}
        return replace(layer, **numbers)

    top, *deeper = stack.layers
    return replace(stack, skin=changed(stack.skin, "skin."), layers=(changed(top, "layers.1."), *deeper))


def of_first_layer(thermal: Mapping[str, float]) -> dict[str, float]:
    """`values` of a material whose skin and first layer have the numbers of `THERMAL`; the skin keeps its thickness."""
    numbers = {f"layers.1.{name}": value for name, value in thermal.items()}
    return numbers | {f"skin.{name}": value for name, value in thermal.items() if name != "thickness"}


def with_emissivity(wavelength: Floats, reflectance: Floats, emissivity: float) -> Floats:
    """The reflectance (W,) with one emissivity at all wavelengths [um] beyond `BORDER`."""
    return np.where(wavelength < BORDER, reflectance, 1.0 - emissivity)


def with_spectrum(
    pattern: Material, spectrum: FileSpectrum | None
) -> tuple[Floats, Floats, tuple[tuple[float, float], ...]]:
    """Nodes (W,) [um] of a pattern, a spectrum on them (W,), and stretches [um] that the pattern fills."""
    wavelength, reflectance = pattern.wavelength, pattern.reflectance.copy()
    if spectrum is None:
        return wavelength, reflectance, ((float(wavelength[0]), float(wavelength[-1])),)
    edges = np.concatenate([[wavelength[0]], np.sqrt(wavelength[1:] * wavelength[:-1]), [wavelength[-1]]])
    x, y = spectrum.wavelength, spectrum.reflectance
    measured = (wavelength >= x[0]) & (wavelength <= x[-1])
    for index in np.flatnonzero(x[1:] / x[:-1] > GAP):
        measured &= (wavelength <= x[index]) | (wavelength >= x[index + 1])
    if not measured.any():
        raise InputError(
            f"the spectrum covers {x[0]:g} to {x[-1]:g} um, none of {wavelength[0]:g} to {wavelength[-1]:g} um"
        )
    # Means over the cells of the nodes: files are often finer than the library's 1 %.
    within = np.union1d(x, edges[(edges > x[0]) & (edges < x[-1])])
    values = np.interp(within, x, y)
    integral = np.concatenate([[0.0], np.cumsum(np.diff(within) * (values[1:] + values[:-1]) / 2)])
    low, high = np.clip(edges[:-1], x[0], x[-1]), np.clip(edges[1:], x[0], x[-1])
    width = high - low
    mean = (np.interp(high, within, integral) - np.interp(low, within, integral)) / np.where(width > 0, width, 1.0)
    reflectance[measured] = np.where(width > 0, mean, np.interp(wavelength, x, y))[measured]
    return wavelength, np.clip(reflectance, 0.0, 1.0), _stretches(wavelength, ~measured)


def _stretches(wavelength: Floats, chosen: np.ndarray) -> tuple[tuple[float, float], ...]:
    """First and last wavelength of each run of chosen nodes."""
    runs = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(int)))
    return tuple((float(wavelength[a]), float(wavelength[b - 1])) for a, b in zip(runs[::2], runs[1::2], strict=True))


def levelled(
    wavelength: Floats, reflectance: Floats, absorptance: float | None, emissivity: float | None, source: str
) -> tuple[Floats, list[str]]:
    """The spectrum (W,) with these means, and what was done to it."""
    fine = np.geomspace(wavelength[0], 100.0, 8000)
    value = np.interp(fine, wavelength, reflectance)
    light = np.interp(fine, *ground_sunlight(), left=0.0, right=0.0) * np.gradient(fine)
    heat = blackbody_weight(fine, 300.0) * np.gradient(fine)
    below, factors = fine < BORDER, [1.0, 1.0]
    for _ in range(ROUNDS):
        for side, (inside, weight, level) in enumerate(((below, light, absorptance), (~below, heat, emissivity))):
            if level is not None:
                beyond = with_odds(value[~inside], factors[1 - side])
                outside = float((1.0 - beyond) @ weight[~inside])
                share = (level * weight.sum() - outside) / weight[inside].sum()
                if not 0.0 < share < 1.0:
                    raise InputError(f"no scaling of the sample gives an absorptance of {level:g}; choose another")
                factors[side] = odds_factor(value[inside], weight[inside], share)
    scaled = np.where(wavelength < BORDER, with_odds(reflectance, factors[0]), with_odds(reflectance, factors[1]))
    words = []
    if absorptance is not None:
        words.append(f"below {BORDER:g} um scaled to a solar absorptance of {absorptance:g} ({source})")
    if emissivity is not None:
        words.append(f"beyond {BORDER:g} um scaled to a thermal emissivity of {emissivity:g} ({source})")
    return scaled, words
