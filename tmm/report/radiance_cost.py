"""The part of ``tmm score`` that turns wrong texels into errors of radiance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

from skyshine.mat.runtime.misclassification import ErrorByTime, misclassification_cost, surface_radiance
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.surface_tables import BandTable, TemperatureTable
from skyshine.mat.tables.table import Table
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity
from skyshine.tmm.report.score import Score

RADIANCE = "W m^-2 sr^-1"

Tables = tuple[TemperatureTable, BandTable, AtmosphereTable | None]
TableKind = TypeVar("TableKind", bound=Table)


def open_tables(htt: str | None, bands: Sequence[str], airs: Sequence[str]) -> list[Tables]:
    """Tables of temperature, band and (or None) atmosphere, one set a band; empty where no cost is asked for.

    Raises InputError: a file is missing or of another type, or the options do not go together.
    """
    if htt is None and not bands and not airs:
        return []
    if htt is None or not bands:
        raise InputError("the cost in radiance needs --htt and --band; give both")
    if airs and len(airs) != len(bands):
        raise InputError(
            f"found {len(airs)} --atmq for {len(bands)} --band; allowed: one for each, in the same order, or none"
        )
    temperatures = _opened(htt, TemperatureTable, "htt")
    tables = [_opened(band, BandTable, "band") for band in bands]
    if not airs:
        return [(temperatures, table, None) for table in tables]
    atmospheres = [_opened(air, AtmosphereTable, "atmq") for air in airs]
    return [(temperatures, table, air) for table, air in zip(tables, atmospheres, strict=True)]


def _opened(path: str, kind: type[TableKind], filetype: str) -> TableKind:
    table = open_table(path)
    if not isinstance(table, kind) or table.filetype != filetype:
        raise InputError(f"holds '{table.filetype}'; allowed: '{filetype}'; name another file", file=path)
    return table


def report(
    score: Score, htt: TemperatureTable, band: BandTable, air: AtmosphereTable | None, surface: dict[str, Any]
) -> dict[str, Any]:
    """What wrong texels of a score cost in one band, as ``--json`` prints it; `surface` as `surface_radiance` takes it.

    Raises InputError: the tables lack a material that was scored, or do not go together.
    """
    rows = score.quality.confusion
    used = [k for k in range(len(score.names)) if rows[k].any() or rows[:, k + 1].any()]
    names = [score.names[k] for k in used]
    sent = surface_radiance(htt, band, names, air=air, **surface)
    cost = misclassification_cost(rows[used][:, [0, *(k + 1 for k in used)]], sent)
    return {
        "band": band.path.name,
        "reflected_sky": air is not None,
        "texels": cost.texels,
        "unknown_texels": cost.unknown,
        "time": quantity(cost.times, "h"),
        "radiance": _errors(cost.radiance, RADIANCE),
        "equivalent_temperature": _errors(cost.kelvin, "K"),
        "pairs": [
            {
                "true": pair.true,
                "found": pair.found,
                "texels": pair.texels,
                "radiance_rms": quantity(pair.radiance_rms, RADIANCE),
                "temperature_rms": quantity(pair.kelvin_rms, "K"),
                "temperature_maximum": quantity(pair.kelvin_maximum, "K"),
                "time_of_maximum": quantity(pair.hour, "h"),
                "contribution": quantity(pair.contribution, "1"),
            }
            for pair in cost.pairs
        ],
    }


def _errors(error: ErrorByTime, units: str) -> dict[str, Any]:
    day = {"rms": error.day_rms, "p95": error.day_p95, "maximum": error.day_maximum}
    hourly = {"mean": error.mean, "rms": error.rms, "p95": error.p95, "maximum": error.maximum}
    return {
        "day": {name: quantity(value, units) for name, value in day.items()},
        "by_time": {name: quantity(values, units) for name, values in hourly.items()},
    }
