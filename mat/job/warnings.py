"""Warnings about a job: what is allowed but hardly meant, with numbers."""

from __future__ import annotations

from collections.abc import Iterable


def merged(warnings: Iterable[tuple[int, str]]) -> list[str]:
    """One line for each text, with the states that it concerns.

    Parameters
    ----------
    warnings : iterable of (int, str)
        Number of a state, counted from 1, and text.

    Examples
    --------
    >>> merged([(1, "dry"), (2, "dry"), (3, "dry"), (4, "cold"), (6, "dry")])
    ['states 1 to 3, 6: dry', 'state 4: cold']
    """
    numbers: dict[str, list[int]] = {}
    for number, text in warnings:
        numbers.setdefault(text, []).append(number)
    return [f"{'state' if len(states) == 1 else 'states'} {_spans(states)}: {t}" for t, states in numbers.items()]


def _spans(numbers: list[int]) -> str:
    spans: list[list[int]] = []
    for number in numbers:
        if spans and number == spans[-1][-1] + 1:
            spans[-1][1:] = [number]
        else:
            spans.append([number])
    return ", ".join(" to ".join(map(str, span)) for span in spans)
