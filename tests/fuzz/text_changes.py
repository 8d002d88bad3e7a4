"""Changes to a text that keep its form: numbers, words, fields, lines; of JSON the values, keys and places in its tree.

Bytes changed at random seldom pass the syntax of a file. These do, and reach what a reader does with its values.
"""

from __future__ import annotations

import copy
import json
import random
import re
from collections.abc import Callable
from typing import Any

MOST_CHANGES = 4
_NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
_WORD = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_SEPARATORS = ",;\t "
NUMBERS = ("0", "-1", "1", "24", "-9999", "99999999999999999999", "1e308", "1e999", "1e-320", "nan", "inf", "", "0.5")
NUMBERS += ("2147483648", "-0.0", "1,5", "1_0", "0x1F", "1 2")
WORDS = ("", "x", "nan", "None", "true", "é", "a" * 300, "\x00", "[K]", "2026-02-30", "12:60", "%41", "../in")
VALUES: tuple[Any, ...] = (
    None, True, "", "x", -1, 0, 1, 2, 3, 7, 255, 10**9, 10**30, 0.5, -0.25, 1e308, float("nan"), float("inf"),
    [], {}, [0], [[]], {"x": 0}, "a" * 300, "data:,", "VEC3", "SCALAR", 5120, 5121, 5123, 5125, 5126,
)  # fmt: skip


def changed_text(seed: bytes, draw: random.Random) -> bytes:
    """A text with a few of its numbers, words, fields or lines changed."""
    text = seed.decode("utf-8", "replace")
    for _ in range(draw.randint(1, MOST_CHANGES)):
        text = draw.choice(_TEXT_CHANGES)(text, draw)
    return text.encode(draw.choice(["utf-8"] * 6 + ["utf-16", "latin-1"]), "replace")


def changed_json(seed: bytes, draw: random.Random) -> bytes:
    """A document with a few of its values or keys changed, moved or taken away."""
    tree = json.loads(seed)
    for _ in range(draw.randint(1, MOST_CHANGES)):
        places = list(_places(tree))
        if not places:
            break
        holder, key = draw.choice(places)
        kind = draw.randrange(5)
        if kind == 0:
            del holder[key]
        elif kind == 1:
            other, name = draw.choice(places)
            holder[key] = copy.deepcopy(other[name])
        elif kind == 2 and isinstance(holder[key], int | float) and not isinstance(holder[key], bool):
            holder[key] = holder[key] + draw.choice([-1, 1, 0.5, 2**31, -(2**31)])
        elif kind == 3 and isinstance(holder, list):
            holder.insert(draw.randrange(len(holder) + 1), copy.deepcopy(holder[key]))
        else:
            holder[key] = copy.deepcopy(draw.choice(VALUES))
    return json.dumps(tree).encode()


def _places(tree: Any) -> Any:
    """Every holder and key or index of a tree."""
    pairs = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in pairs:
        yield tree, key
        yield from _places(value)


def _one_match(pattern: re.Pattern[str], values: tuple[str, ...]) -> Callable[[str, random.Random], str]:
    def change(text: str, draw: random.Random) -> str:
        matches = list(pattern.finditer(text))
        if not matches:
            return text
        match = draw.choice(matches)
        other = draw.choice([*values, draw.choice(matches).group()])
        return text[: match.start()] + other + text[match.end() :]

    return change


def _lines(text: str, draw: random.Random) -> str:
    """One line less, twice, elsewhere, cut short or empty."""
    lines = text.splitlines(keepends=True)
    if not lines:
        return text
    at, other = draw.randrange(len(lines)), draw.randrange(len(lines))
    kind = draw.randrange(6)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(other, lines[at])
    elif kind == 2:
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == 3:
        lines[at] = lines[at][: draw.randrange(len(lines[at]) + 1)] + "\n"
    elif kind == 4:
        lines = lines[:at]
    else:
        lines[at] = "\n"
    return "".join(lines)


def _fields(text: str, draw: random.Random) -> str:
    """A field of one line, or of all lines, less or twice."""
    separator = draw.choice(_SEPARATORS)
    lines = text.split("\n")
    at, everywhere, place, twice = (
        draw.randrange(len(lines)),
        draw.random() < 0.5,
        draw.randrange(8),
        draw.random() < 0.5,
    )
    for number, line in enumerate(lines):
        fields = line.split(separator)
        if (everywhere or number == at) and place < len(fields) > 1:
            fields[place : place + 1] = [fields[place]] * 2 if twice else []
            lines[number] = separator.join(fields)
    return "\n".join(lines)


def _everywhere(text: str, draw: random.Random) -> str:
    """Another separator, decimal sign or end of line in the whole text."""
    old, new = draw.choice(
        [(",", ";"), (".", ","), (",", "\t"), ("\n", "\r\n"), ("\n", "\r"), (" ", "\u00a0"), (":", "")]
    )
    return text.replace(old, new)


_TEXT_CHANGES: tuple[Callable[[str, random.Random], str], ...] = (
    *[_one_match(_NUMBER, NUMBERS)] * 4,
    *[_one_match(_WORD, WORDS)] * 2,
    *[_lines] * 2,
    _fields,
    _everywhere,
)
