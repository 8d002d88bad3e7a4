"""Materials by the words that people use for them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

from pydantic import RootModel

from skyshine.schemas.documents import load_model

NAMED = 5  # materials that a message names
ALIKE = 0.5  # least ratio of `difflib` of a name that may be a slip of the pen


class Aliases(RootModel[dict[str, tuple[str, ...]]]):
    """Materials by word."""


@lru_cache(maxsize=1)
def aliases() -> dict[str, tuple[str, ...]]:
    """The words of `aliases.yaml` and the materials that each means, the most usual first."""
    return load_model(Path(__file__).with_name("aliases.yaml"), Aliases).root


def matches(word: str, names: Iterable[str]) -> list[str]:
    """Materials that a word means, the most usual first: what it is used for, and names that contain it.

    Parameters
    ----------
    word : str
    names : iterable of str
        Names of the available materials.

    Examples
    --------
    >>> matches("lawn", ["asphalt_road", "grass_dry", "grass_green"])
    ['grass_green', 'grass_dry']
    >>> matches("asphalt", ["asphalt_road", "tar"])
    ['asphalt_road']
    """
    choices = list(names)
    lower = word.lower()
    forms = [lower, *([lower[:-1]] if lower.endswith("s") else [])]
    by_alias = [name for form in forms for name in aliases().get(form, ()) if name in choices]
    containing = [name for form in forms for name in choices if re.search(rf"(^|_){re.escape(form)}", name)]
    containing.sort(key=lambda name: (not name.startswith(forms[-1]), len(name)))
    return list(dict.fromkeys([*by_alias, *containing]))


def meant(word: str, names: Iterable[str]) -> str:
    """Words for the end of a message: the materials that a name may mean, or is spelt much like, and how to see all."""
    choices = list(names)
    matching = matches(word, choices)
    suggestions = matching or difflib.get_close_matches(word, choices, n=NAMED, cutoff=ALIKE)
    hint = f"did you mean '{suggestions[0]}'? " if suggestions else ""
    more = f"; others: {', '.join(suggestions[1:NAMED])}" if len(suggestions) > 1 else ""
    text = word if matching and re.fullmatch(r"[\w.-]+", word) else ""
    return f"{hint}'mat materials{' ' + text if text else ''}' lists what there is{more}"
