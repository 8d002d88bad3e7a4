"""Which source spectra make up the spectrum of each material: the models of `materials/ref/recipes.yaml`."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from mat.maintain.materials import optics, readers
from skyshine.mat.atmosphere.sources.solar import ground_sunlight
from skyshine.mat.radiometry.levels import blackbody_weight, odds_factor, with_odds
from skyshine.schemas.arrays import Floats
from skyshine.schemas.documents import StrictModel
from skyshine.schemas.errors import InputError

# A stretch may reach this far (relative) beyond the first and last point of its source.
_REACH = 0.002
# Wavelengths at which the mean over a stretch is taken.
LEVEL_POINTS = 4000

Wavelength = Annotated[float, Field(gt=0.0, le=1000.0)]


class Ratio(StrictModel):
    """Factor that turns one state of a sample into another: a quotient of two spectra of the USGS library."""

    over: str
    under: str


class Level(StrictModel):
    """The level that a stretch is brought to: one broadband number from the literature for the shape of a sample.

    Attributes
    ----------
    over : str
        "sunlight": the mean of absorptance over sunlight at the ground; "300 K": over blackbody radiation. Both within
        the stretch.
    source : str
        Reference of the number.
    """

    over: Literal["sunlight", "300 K"]
    absorptance: Annotated[float, Field(gt=0.0, lt=1.0)]
    source: Annotated[str, Field(min_length=1)]

    def factor(self, wavelength: Floats, reflectance: Floats) -> float:
        """Factor on the odds of reflection that gives a spectrum (W,) at wavelengths (W,) [um] this level.

        Raises
        ------
        InputError
            No factor from 1e-4 to 1e4 does.
        """
        if self.over == "sunlight":
            weight = np.interp(wavelength, *ground_sunlight())
        else:
            weight = blackbody_weight(wavelength, 300.0)
        return odds_factor(reflectance, weight * np.gradient(wavelength), self.absorptance)


class Piece(StrictModel):
    """One stretch of a spectrum and the source it is read from.

    Attributes
    ----------
    source : str
        Collection, which is also the citation key; "literature" for a constant.
    file : str or list of str
        Path below the spectra folder; several are averaged (ecostress) or joined in wavelength (constants).
    sample : str
        Column of the SLUM tables; "lightest" or "darkest" of the NIST skins, by default all.
    range : (float, float)
        [um]
    kind : str
        Kind as in `SpectralRange`.
    note : str
        What a reader of the table should know of this stretch.
    unit : str
        Unit of an ECOSTRESS file.
    thickness : float
        Thickness of a pane [m].
    film : str
        Optical constants of a film on the back face of a pane, path below the spectra folder.
    film_thickness : float
        [m]
    value : float
        Value of a constant.
    ratio : Ratio
        Multiplies the stretch.
    level : Level
        Scales the odds of reflection of the stretch to a number from the literature.
    match : bool
        Scale the stretch so that it meets the one before it: by the quotient of their means within 4 % in
        wavelength of the joint.
    """

    source: Literal["ecostress", "aster_jhu", "slum", "usgs", "nist_skin", "fresnel", "pane", "literature"]
    range: tuple[Wavelength, Wavelength]
    kind: Literal["measured", "modelled", "fresnel", "proxy", "constant"]
    note: str = ""
    file: str | list[str] = []
    sample: str = ""
    unit: Literal["percent", "fraction"] = "percent"
    thickness: float = 0.0
    film: str = ""
    film_thickness: float = 0.0
    value: float | None = None
    ratio: Ratio | None = None
    level: Level | None = None
    match: bool = False

    @model_validator(mode="after")
    def _complete(self) -> Self:
        needs = {"slum": "sample", "literature": "value", "pane": "thickness"}.get(self.source, "file")
        if getattr(self, needs) in (None, "", [], 0.0):
            raise ValueError(f"a piece from {self.source} needs '{needs}'; add it")
        return self

    @property
    def files(self) -> list[str]:
        """Paths below the spectra folder."""
        return [self.file] if isinstance(self.file, str) else list(self.file)

    def evaluate(self, folder: Path, wavelength: Floats) -> tuple[Floats, Floats]:
        """Reflectance and absorptance (W,) at wavelengths (W,) [um]; constant beyond the ends of the source."""
        if self.source == "pane":
            return self._pane(folder, wavelength)
        reflectance = self._state(folder, wavelength)
        if self.level is not None:
            levels = np.geomspace(*self.range, LEVEL_POINTS)
            reflectance = with_odds(reflectance, self.level.factor(levels, self._state(folder, levels)))
        return reflectance, 1.0 - reflectance

    def _state(self, folder: Path, wavelength: Floats) -> Floats:
        """Reflectance of the sample (W,), in another state where the recipe has a ratio."""
        reflectance = self._reflectance(folder, wavelength)
        if self.ratio is None:
            return reflectance
        over, divisor = (
            np.interp(wavelength, *readers.read_usgs(folder / file)) for file in (self.ratio.over, self.ratio.under)
        )
        return reflectance * over / divisor

    def _reflectance(self, folder: Path, wavelength: Floats) -> Floats:
        if self.source == "literature":
            return np.full(wavelength.shape, self.value)
        if self.source == "slum":
            samples = [readers.read_slum(folder / "slum", sample) for sample in self.sample.split(", ")]
            return np.asarray(np.mean([self._interpolated(wavelength, *sample) for sample in samples], axis=0))
        if self.source == "fresnel":
            return optics.fresnel_reflectance(self._index(folder, self.files, wavelength))
        spectra = [self._read(folder / file) for file in self.files]
        return np.asarray(np.mean([self._interpolated(wavelength, *spectrum) for spectrum in spectra], axis=0))

    def _interpolated(self, wavelength: Floats, um: Floats, value: Floats) -> Floats:
        """A spectrum (N,) at wavelengths (W,), as `_check_covered` allows."""
        self._check_covered(um)
        return np.interp(wavelength, um, value)

    def _check_covered(self, um: Floats) -> None:
        """Refuse a source that does not cover the stretch: a constant continuation must not be called measured."""
        lower, upper = self.range
        if lower < um[0] * (1.0 - _REACH) or upper > um[-1] * (1.0 + _REACH):
            name = self.sample or ", ".join(self.files)
            raise InputError(f"{name} covers {um[0]:g} to {um[-1]:g} um; the recipe says {lower:g} to {upper:g}")

    def _read(self, file: Path) -> tuple[Floats, Floats]:
        if self.source in ("ecostress", "aster_jhu"):
            return readers.read_ecostress(file, self.unit)
        return readers.read_usgs(file) if self.source == "usgs" else readers.read_nist_skin(file, self.sample)

    def _pane(self, folder: Path, wavelength: Floats) -> tuple[Floats, Floats]:
        index = self._index(folder, self.files, wavelength)
        if not self.film:
            return optics.pane(index, wavelength, self.thickness)
        film = self._index(folder, [self.film], wavelength)
        return optics.coated_pane(index, film, wavelength, self.thickness, self.film_thickness)

    def _index(self, folder: Path, files: Sequence[str], wavelength: Floats) -> npt.NDArray[np.complex128]:
        """Refractive index n + ik at wavelengths (W,) [um]."""
        tables = [readers.read_constants(folder / file) for file in files]
        um = np.concatenate([table[0] for table in tables])
        index = np.concatenate([table[1] for table in tables])
        order = np.argsort(um)
        self._check_covered(um[order])
        return np.asarray(np.interp(wavelength, um[order], index[order]), complex)


class Recipe(StrictModel):
    """The spectrum of one material: from source spectra, of parts that lie side by side, or another material's own.

    Attributes
    ----------
    sample : str
        What was measured.
    upper : float
        Upper end of the table [um].
    pieces : list of Piece
        Pieces by increasing wavelength; gaps between them are interpolated, and the ends are extended as constants.
    mixture : dict of str to float
        Shares of the area that show the spectra of other recipes; their sum is 1. `sample` says why these shares.
    like : str
        The recipe whose spectrum it is.
    """

    sample: str
    upper: Wavelength = 15.0
    pieces: list[Piece] = []
    mixture: dict[str, Annotated[float, Field(gt=0.0, lt=1.0)]] = {}
    like: str = ""

    @model_validator(mode="after")
    def _one_origin(self) -> Self:
        if sum(map(bool, (self.pieces, self.mixture, self.like))) != 1:
            raise ValueError("a recipe has one of 'pieces', 'mixture' and 'like'; write one of them")
        if self.mixture and abs(sum(self.mixture.values()) - 1.0) > 1e-9:
            raise ValueError(f"found shares with a sum of {sum(self.mixture.values()):g}; allowed: 1; correct them")
        return self

    @model_validator(mode="after")
    def _rising(self) -> Self:
        edges = [edge for piece in self.pieces for edge in piece.range]
        if any(b < a for a, b in itertools.pairwise(edges)):
            raise ValueError("pieces overlap or are not in order of wavelength; correct their ranges")
        return self

    @property
    def parts(self) -> list[str]:
        """The recipes that it is made of."""
        return [*self.mixture, *([self.like] if self.like else [])]


class Recipes(StrictModel):
    """`materials/ref/recipes.yaml`."""

    citations: dict[str, str]
    recipes: dict[str, Recipe]

    @model_validator(mode="after")
    def _parts_known(self) -> Self:
        for name, recipe in self.recipes.items():
            for part in recipe.parts:
                if part not in self.recipes or self.recipes[part].like:
                    raise ValueError(f"found {part} in {name}; allowed: recipes with a spectrum of their own")
        return self

    def sources_of(self, name: str) -> list[str]:
        """Keys of the citations behind a recipe, those of its parts included, each once."""
        recipe = self.recipes[name]
        keys: list[str] = [piece.source for piece in recipe.pieces]
        if any(piece.ratio for piece in recipe.pieces):
            keys.append("usgs")
        for part in recipe.parts:
            keys += self.sources_of(part)
        return list(dict.fromkeys(keys))
