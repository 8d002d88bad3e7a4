"""Numbers as text: what tables and command lines may write."""

from __future__ import annotations

import re

# Python also reads 2_9.7 and digits of other alphabets; in a table these are slips of the pen.
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")


def plain_number(text: str) -> float:
    """The number that a text writes in ASCII digits, such as ``-2.5e-3``.

    Raises
    ------
    ValueError
        It writes no number, or one that is not finite.
    """
    if not _NUMBER.fullmatch(text.strip(" \t")):
        raise ValueError(f"found '{text[:40]}'; allowed: a decimal number")
    value = float(text)
    if value in (float("inf"), -float("inf")):
        raise ValueError(f"found '{text[:40]}'; allowed: a finite number")
    return value
