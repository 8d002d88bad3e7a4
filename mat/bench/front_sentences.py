"""Summary of a front in sentences: the job's own point, and the marginal gain of run time and of error."""

from __future__ import annotations

from typing import Any

ENOUGH = 1.1  # times the least error, of a setting that is good enough
KELVIN, SHARE = "K", "% of radiance"


def sentences(rungs: list[dict[str, Any]], units: str) -> list[str]:
    """Sentences on the job's own point, and on the marginal gain of run time and of error.

    Parameters
    ----------
    rungs : list of dict
        Rungs in order of their times, with ``name``, ``chosen``, ``time``, ``error``, ``on_the_front``.
    units : str
        Units of the error.
    """
    if not rungs:
        return ["No setting of this job could be built and measured."]
    chosen = next((rung for rung in rungs if rung["chosen"]), None)
    front = _distinct([rung for rung in rungs if rung["on_the_front"]], chosen)
    if chosen is None:
        start, summary = front[0], "The job as it is written could not be built and measured."
    elif chosen["on_the_front"]:
        start = chosen
        summary = f"The job as written reaches {_point(chosen, units)}; no other setting beats it."
    else:
        start = next(rung for rung in reversed(front) if _time(rung) <= _time(chosen))
        summary = (
            f"The job as written reaches {_point(chosen, units)}; {start['name']} beats it with {_point(start, units)}."
        )
    index = front.index(start)
    finer = front[index + 1] if index + 1 < len(front) else None
    coarser = front[index - 1] if index else None
    return [
        _headline(rungs, units),
        summary,
        _next_second(start, finer, units),
        _next_kelvin(start, coarser, units),
        _floor(front[-1], units),
    ]


def _headline(rungs: list[dict[str, Any]], units: str) -> str:
    """What to set: the cheapest rung that errs little more than the best."""
    least = min(map(_error, rungs))
    best = min((rung for rung in rungs if _error(rung) <= ENOUGH * least), key=_time)
    what = "Leave the accuracy of the job as it is written" if best["chosen"] else f"Set accuracy: {best['name']}"
    how = " by the model" if best["modelled"] else ""
    return (
        f"{what}: 99 % of the pixels of this scene are within {_error(best):.3g} {units} for {_time(best):.3g} s of a"
        f" processor{how}; the least error of all settings is {least:.3g} {units}."
    )


def _floor(best: dict[str, Any], units: str) -> str:
    return (
        f"The least error, {_error(best):.3g} {units}, has {best['name']}; with exact tables the equations of the"
        f" runtime would err by {float(best['floor']['value']):.3g} {units} (dashed)."
    )


def _distinct(front: list[dict[str, Any]], chosen: dict[str, Any] | None) -> list[dict[str, Any]]:
    """One rung of each point: the job as it is written where that is one of several."""
    points = {(_time(rung), _error(rung)): rung for rung in front}
    if chosen is not None and chosen["on_the_front"]:
        points[_time(chosen), _error(chosen)] = chosen
    return [points[point] for point in sorted(points)]


def _next_second(start: dict[str, Any], finer: dict[str, Any] | None, units: str) -> str:
    if finer is None:
        return f"More run time reduces the error no further: no setting errs less than {start['name']}."
    gain, cost = _error(start) - _error(finer), _time(finer) - _time(start)
    return (
        f"The next second: from {start['name']} to {finer['name']} the error falls from {_error(start):.3g} to"
        f" {_error(finer):.3g} {units} for {cost:.3g} s more, {gain / cost:.2g} {units} a second."
    )


def _next_kelvin(start: dict[str, Any], coarser: dict[str, Any] | None, units: str) -> str:
    if coarser is None:
        return (
            f"A larger error saves no time: no setting of the front takes less than {start['name']}"
            f" ({_time(start):.3g} s)."
        )
    loss, saved = _error(coarser) - _error(start), _time(start) - _time(coarser)
    unit = "kelvin" if units == KELVIN else "per cent"
    return (
        f"The next {unit}: {coarser['name']} errs {loss:.3g} {units} more and saves {saved:.3g} s,"
        f" {saved / loss:.2g} s a {unit}."
    )


def _point(rung: dict[str, Any], units: str) -> str:
    return f"{_error(rung):.3g} {units} in {_time(rung):.3g} s"


def _time(rung: dict[str, Any]) -> float:
    return float(rung["time"]["value"])


def _error(rung: dict[str, Any]) -> float:
    return float(rung["error"]["value"])
