"""The error budget of built databases."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.budget.budget import STEPS, Budget, error_budget
from skyshine.mat.budget.page import render
from skyshine.mat.budget.summary import describe_all
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.job.load import LoadedJob, load_job
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.tables.dataset import dataset
from skyshine.mat.tables.result import Result
from skyshine.schemas.errors import InputError, nearest

if TYPE_CHECKING:
    import xarray

_log = logging.getLogger("skyshine.mat.report")
MEASURES = ("rms", "p95", "p99", "maximum")


@dataclass(frozen=True, eq=False, repr=False)
class Report(Result):
    """Error budgets of the tables of a job, one for each state, band and source.

    Attributes
    ----------
    budgets : tuple of Budget
        The errors of each view themselves.
    numbers : dict
        The same as plain values with units: what `mat report --json` prints.
    """

    budgets: tuple[Budget, ...]
    numbers: dict[str, Any]

    @property
    def notes(self) -> list[str]:
        """What could not be measured, and why."""
        return list(self.numbers["notes"])

    def to_xarray(self) -> xarray.Dataset:
        """Rms, 95th and 99th percentile and maximum of each source of error, in kelvin and in radiance.

        Dimensions are ``budget`` (with the coordinates state, band and source), ``error`` and ``measure``; an error
        that a budget does not have is not a number.
        """
        budgets = self.numbers["budgets"]
        errors = list(dict.fromkeys(name for budget in budgets for name in budget["errors"]))

        def values(kind: str) -> np.ndarray:
            return np.array(
                [
                    [[_number(budget["errors"].get(name), kind, measure) for measure in MEASURES] for name in errors]
                    for budget in budgets
                ],
                float,
            ).reshape(len(budgets), len(errors), len(MEASURES))

        dims = ("budget", "error", "measure")
        described = {
            name: (("budget",), "1", np.array([budget[name] for budget in budgets])) for name in ("state", "source")
        }
        return dataset(
            {
                "budget": ("1", np.arange(len(budgets))),
                "error": ("1", np.array(errors, str)),
                "measure": ("1", np.array(MEASURES)),
            },
            {
                "temperature": (dims, "K", values("temperature")),
                "radiance": (dims, "W m^-2 sr^-1", values("radiance")),
                **described,
            },
            {"job": self.numbers["job"], "seed": self.numbers["seed"]},
        )

    def write_html(self, path: str | os.PathLike[str]) -> None:
        """Write the page with its pictures, and its numbers beside it as JSON.

        Raises
        ------
        InputError
            The files cannot be written.
        """
        page = Path(path)
        text = json.dumps(self.numbers, indent=2, allow_nan=False)
        try:
            page.parent.mkdir(parents=True, exist_ok=True)
            page.write_text(render(self.numbers, self.budgets), encoding="utf-8")
            page.with_suffix(".json").write_text(text + "\n", encoding="utf-8")
        except OSError as error:
            raise InputError(f"cannot be written: {error.strerror}; name another place", file=page) from None

    def __repr__(self) -> str:
        return f"<Report of '{self.numbers['job']}': {len(self.budgets)} budgets, {len(self.notes)} notes>"


def report(
    job: str | os.PathLike[str] | Mapping[str, Any],
    *,
    built: str | os.PathLike[str] | None = None,
    scenes: int = 40,
    seed: int = 1,
    band: str | None = None,
    advance: Callable[[int], object] = lambda _: None,
) -> Report:
    """Measure the error budget of the databases of a job.

    Random views go through the runtime's equations with the tables, and through the spectral integrals; each source of
    error is switched on alone, then all together.

    Parameters
    ----------
    job : path or mapping
        A YAML job, or its content.
    built : path, optional
        Folder of the databases; by default the one that the job names.
    scenes, seed : int
        Random views of each set of tables, and what they are drawn with.
    band : str, optional
        Name of one band, b01 where the job gives no name; by default all.
    advance : callable, optional
        Called with 1 when one of `step_count` steps is finished.

    Returns
    -------
    Report

    Raises
    ------
    InputError
        A database is missing or does not belong to the job, or the job does not build the band.
    """
    loaded = load_job(job)
    library = job_library(loaded.trimmed)
    folder = Path(built) if built is not None else loaded.output_folder
    budgets: list[Budget] = []
    notes: list[str] = []
    for state, number in _sets(loaded, band):
        _log.info("state %d, band %d: spectra of the truth", state, number)
        prepared = Prepared.of(loaded, state, number)
        for source in loaded.trimmed.sources:
            budget = error_budget(prepared, folder, library, source=source, scenes=scenes, seed=seed, advance=advance)
            if budget is None:
                notes.append(
                    f"State {state}, band {number}: the tables' axes leave no room for a view with the {source}."
                )
            else:
                budgets.append(budget)
                notes += [note for note in budget.notes if note not in notes]
    return Report(tuple(budgets), describe_all(budgets, notes, job=loaded.trimmed.name, seed=seed))


def step_count(job: str | os.PathLike[str] | Mapping[str, Any], band: str | None = None) -> int:
    """Number of steps of `report`: some for each state, band and source."""
    loaded = load_job(job)
    return STEPS * len(_sets(loaded, band)) * len(loaded.trimmed.sources)


def _sets(loaded: LoadedJob, band: str | None) -> Sequence[tuple[int, int]]:
    loaded.refuse_without_bands()
    bands = {loaded.trimmed.band_name(number): number for number in loaded.trimmed.needed_bands}
    if band is not None and band not in bands:
        raise InputError(f"found the band '{band}'; {nearest(band, bands)}, the bands that the job builds")
    return list(product(range(1, len(loaded.trimmed.states) + 1), bands.values() if band is None else [bands[band]]))


def _number(error: Mapping[str, Any] | None, kind: str, measure: str) -> float:
    value = None if error is None else error[kind][measure]["value"]
    return float("nan") if value is None else float(value)
