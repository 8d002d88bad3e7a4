"""Parameters of a material from a measured record: least squares with exact derivatives, and days held out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.fit_uncertainty import Uncertainty, not_identified, uncertainty
from skyshine.mat.surface.free_parameters import FreeParameter, free_parameters, parameter_values
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.measured_skin import MeasuredRecord
from skyshine.mat.surface.skin_errors import SkinError, skin_errors
from skyshine.mat.surface.skin_model import SkinModel, start_shares
from skyshine.mat.surface.solver import DAY
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import CheckFailed, InputError

LEAST_DAYS = 2.0  # [d]
LEAST_READINGS = 10  # a free parameter: chosen
ALTERNATE = "alternate"  # every second day is held out
# K by which a parameter must move some temperature between its bounds, by its slope at the start: chosen, what good
# radiometers just tell.
_LEAST_EFFECT = 0.1
SEARCHES = 60  # searches of the parameters at most: chosen, three times what takes longest in the tests


@dataclass(frozen=True, eq=False)
class Fit:
    """A fit of p parameters to a record of N steps.

    Attributes
    ----------
    shares : (p,) ndarray
        Positions of the parameters between their bounds, 0 to 1.
    notes : tuple of str
        What the record cannot tell.
    measured, predicted : (N,) ndarray
        Skin temperature [K]; NaN where it was not measured.
    fitted, held_out : (N,) ndarray of bool
        Readings that count.
    errors : tuple of SkinError
        Errors of the fit, of the material before it, of air temperature and of the day before.
    """

    parameters: tuple[FreeParameter, ...]
    shares: Floats
    uncertainty: Uncertainty
    notes: tuple[str, ...]
    measured: Floats
    predicted: Floats
    fitted: npt.NDArray[np.bool_]
    held_out: npt.NDArray[np.bool_]
    errors: tuple[SkinError, ...]

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters, by name."""
        return parameter_values(self.parameters, self.shares)


def fit_record(
    material: SurfaceMaterial,
    measured: MeasuredRecord,
    parameter_names: Sequence[str],
    *,
    held_out: float | str = 0.25,
    spin_up: float = 1.0,
    advance: Callable[[int], object] | None = None,
) -> Fit:
    """Fit parameters of a material to a measured record.

    Parameters
    ----------
    material : SurfaceMaterial
        Gives the start, and all that is not free.
    parameter_names : sequence of str
        Names out of `free_parameters.PARAMETERS`.
    held_out : float or str
        Share of the days, the last ones, that the fit does not see, or "alternate" for every second day.
    spin_up : float
        Days at the beginning that do not count, because the record repeats and they follow its end.
    advance : callable, optional
        Called with 1 after each search of at most `SEARCHES`.

    Raises
    ------
    InputError
        A parameter that is unknown or has no effect, a material that melts, or too few days or readings.
    CheckFailed
        The heat balance of the material as it was has no solution that Newton finds.
    """
    from scipy.optimize import least_squares

    measured = measured.averaged()
    record = measured.record
    fitted, aside = _parts(measured, held_out, spin_up)
    parameters = free_parameters(material, parameter_names, float(record.values["air_temperature"].mean()))
    _refuse_few(measured, fitted, aside, len(parameters), held_out)
    search = _Search(SkinModel(material, record, parameters), measured, fitted, advance or (lambda _: None))
    before = _Search(SkinModel(material, record, ()), measured, fitted).temperatures(np.zeros(0))
    start = start_shares(parameters)
    _refuse_without_effect(material, parameters, search.slopes(start))
    result = least_squares(
        search.residuals,
        np.clip(start, 1e-3, 1 - 1e-3),
        search.jacobian,
        bounds=(0.0, 1.0),
        xtol=1e-6,
        ftol=1e-7,
        gtol=1e-8,
        max_nfev=SEARCHES,
    )
    shares: Floats = result.x
    predicted, truth = search.temperatures(shares), search.truth(shares)[0]
    certainty = uncertainty(np.where(fitted, predicted - truth, np.nan), search.slopes(shares), record.step)
    day = round(DAY / record.step)
    predictions = {
        "fit": predicted,
        "material as it was": before,
        "air temperature": record.values["air_temperature"],
        "day before": np.append(np.full(day, np.nan), truth)[: record.steps],
    }
    errors = skin_errors(truth, predictions, record.values["sw_down"], {"fitted": fitted, "held out": aside})
    notes = not_identified(parameters, shares, certainty)
    return Fit(parameters, shares, certainty, notes, truth, predicted, fitted, aside, errors)


def _parts(
    measured: MeasuredRecord, held_out: float | str, spin_up: float
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Readings of the fitted and of the held-out days; days are counted from the beginning of the record."""
    record = measured.record
    if record.period < LEAST_DAYS * DAY:
        raise InputError(
            f"found a record of {record.period / DAY:.2g} days; allowed: at least {LEAST_DAYS:g}; the first counts as"
            " spin-up",
            file=measured.file,
        )
    if spin_up < 0 or spin_up * DAY >= record.period:
        raise InputError(f"found a spin-up of {spin_up:g} days; allowed: 0 to less than the record", file=measured.file)
    elapsed = np.arange(record.steps) * record.step
    day = np.floor(elapsed / DAY + 1e-6).astype(int)
    usable = np.isfinite(measured.skin) & (elapsed >= spin_up * DAY - 1.0)
    days = np.unique(day[elapsed >= spin_up * DAY - 1.0])
    if held_out == ALTERNATE:
        aside = days[1::2]
    elif isinstance(held_out, str) or not 0 <= held_out < 1:
        raise InputError(f"found held_out {held_out}; allowed: 0 to less than 1, or '{ALTERNATE}'")
    else:
        many = min(max(round(held_out * len(days)), int(held_out > 0)), len(days) - 1)
        aside = days[len(days) - many :]
    chosen = np.isin(day, aside)
    return usable & ~chosen, usable & chosen


def _refuse_few(
    measured: MeasuredRecord,
    fitted: npt.NDArray[np.bool_],
    aside: npt.NDArray[np.bool_],
    parameter_count: int,
    held_out: float | str,
) -> None:
    if fitted.sum() < LEAST_READINGS * parameter_count:
        raise InputError(
            f"found {fitted.sum()} measured skin temperatures in the days of the fit; allowed: at least"
            f" {LEAST_READINGS * parameter_count}, {LEAST_READINGS} a parameter; use a longer record or free fewer",
            file=measured.file,
        )
    if held_out and not aside.any():
        raise InputError(
            "found no measured skin temperature in the days that are held out; use a longer record, or hold out 0",
            file=measured.file,
        )


def _refuse_without_effect(material: SurfaceMaterial, parameters: tuple[FreeParameter, ...], slopes: Floats) -> None:
    for index, parameter in enumerate(parameters):
        if np.abs(slopes[:, index]).max() < _LEAST_EFFECT:
            raise InputError(
                f"{parameter.name} has no effect on material '{material.name}' under this record; leave it out"
            )


class _Search:
    """The residuals of a fit, which keep the last solution as the guess of the next."""

    def __init__(
        self,
        model: SkinModel,
        measured: MeasuredRecord,
        fitted: npt.NDArray[np.bool_],
        advance: Callable[[int], object] = lambda _: None,
    ) -> None:
        self.model, self.measured, self.fitted, self.advance = model, measured, fitted, advance
        self.last: tuple[bytes, Floats, Floats] | None = None

    def temperatures(self, shares: Floats) -> Floats:
        """Skin temperatures (N,) [K]."""
        return self._solved(shares)[0]

    def truth(self, shares: Floats) -> tuple[Floats, Floats]:
        """Measured skin temperatures [K] and their derivatives by emissivity, each (N,)."""
        values = parameter_values(self.model.parameters, shares)
        return self.measured.temperature(values.get("emissivity", self.model.material.thermal_emissivity))

    def slopes(self, shares: Floats) -> Floats:
        """Slopes of predicted less measured temperatures by the shares, (N, free)."""
        slopes = self.model.derivatives(shares, self._solved(shares)[1])
        for index, parameter in enumerate(self.model.parameters):
            if parameter.name == "emissivity":
                slopes[:, index] -= self.truth(shares)[1] * parameter.slope(float(shares[index]))
        return slopes

    def residuals(self, shares: Floats) -> Floats:
        """Predicted less measured temperatures of the fitted readings."""
        error: Floats = (self.temperatures(shares) - self.truth(shares)[0])[self.fitted]
        self.advance(1)
        return error

    def jacobian(self, shares: Floats) -> Floats:
        """Jacobian of the residuals."""
        return self.slopes(shares)[self.fitted]

    def _solved(self, shares: Floats) -> tuple[Floats, Floats]:
        if self.last is None or self.last[0] != shares.tobytes():
            guess = None if self.last is None else self.last[2]
            try:
                self.last = shares.tobytes(), *self.model.temperatures(shares, guess)
            except RuntimeError as error:
                values = parameter_values(self.model.parameters, shares)
                listed = ", ".join(f"{name} {value:.4g}" for name, value in values.items()) or "its own values"
                raise CheckFailed(
                    f"material '{self.model.material.name}': {error} at {listed}; check the weather, or free fewer"
                    " parameters"
                ) from None
        return self.last[1], self.last[2]
