"""The errors that a user can fix, and the lines that report them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

from skyshine.schemas.paths import StrPath


class InputError(Exception):
    """The input is wrong. The text is one line: where, what was found, what is allowed, what to do.

    Parameters
    ----------
    message : str
        What was found, what is allowed and what to do about it.
    file, line, column : optional
        Location of the error; lines and columns count from 1.
    """

    def __init__(
        self,
        message: str,
        *,
        file: StrPath | None = None,
        line: int | None = None,
        column: int | None = None,
    ) -> None:
        position = [str(part) for part in (file, line, column) if part is not None]
        self.message = " ".join(str(message).split())
        self.file, self.line, self.column = file, line, column
        super().__init__(": ".join([":".join(position), self.message] if position else [self.message]))

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (self.message, self.file, self.line, self.column)


def _rebuild(message: str, file: StrPath | None, line: int | None, column: int | None) -> InputError:
    return InputError(message, file=file, line=line, column=column)


class CheckFailed(Exception):
    """A check that was asked for failed; commands end with status 1."""


def nearest(name: object, allowed: Iterable[str]) -> str:
    """Words that list what is allowed and name the nearest choice first, for the end of a message."""
    choices = [str(choice) for choice in allowed]
    close = difflib.get_close_matches(str(name), choices, n=1, cutoff=0.5)
    hint = f"did you mean '{close[0]}'? " if close else ""
    return f"{hint}allowed: {', '.join(choices)}"
