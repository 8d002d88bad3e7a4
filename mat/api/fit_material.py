"""Parameters of a material from a measured temperature record."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.api.own_material import OwnMaterial, default_folder, new_material, refuse_taken
from skyshine.mat.api.temperature import surface_material
from skyshine.mat.surface.fit import Fit, fit_record
from skyshine.mat.surface.fit_uncertainty import CONFIDENCE
from skyshine.mat.surface.free_parameters import changed_numbers, with_numbers
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.measured_skin import read_measured
from skyshine.mat.surface.skin_errors import SkinError
from skyshine.mat.tables.dataset import dataset
from skyshine.mat.tables.result import Panel, Result
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class FittedParameter:
    """A number of a material that a record gave.

    Attributes
    ----------
    name, units : str
    start : float
        Start of the search: the value of the material, or of a moist one if it is dry.
    value : float
    standard_error : float
        Standard error in units of the value; for a parameter searched by its logarithm, multiplied by the slope of the
        value there.
    low, high : float
        Interval: all intervals of a fit contain the truth at once with a probability of 99 %.
    bounds : tuple of float
        Bounds of the search.
    """

    name: str
    units: str
    start: float
    value: float
    standard_error: float
    low: float
    high: float
    bounds: tuple[float, float]


@dataclass(frozen=True, eq=False, repr=False)
class MaterialFit(Result):
    """A material fitted to a record; arrays are (N,) over time.

    Attributes
    ----------
    material : str
        Name of the material that gives the start values and all fixed parameters.
    parameters : tuple of FittedParameter
    correlation : (p, p) ndarray
        Correlation of the parameters' errors.
    effective_readings : float
        Number of independent readings with as much information as those of the fit.
    notes : tuple of str
        Defaults used for missing columns, and what the record cannot determine.
    errors : tuple of SkinError
        Errors of the fit, of the unchanged material, of the air temperature and of the day before, in fitted and
        held-out days.
    time : ndarray of datetime64
        UTC.
    measured, predicted : ndarray
        Skin temperature [K]; NaN where it was not measured.
    fitted, held_out : ndarray of bool
        Readings that count.
    written : OwnMaterial or None
    """

    material: str
    parameters: tuple[FittedParameter, ...]
    correlation: Floats
    effective_readings: float
    notes: tuple[str, ...]
    errors: tuple[SkinError, ...]
    time: npt.NDArray[np.datetime64]
    measured: Floats
    predicted: Floats
    fitted: npt.NDArray[np.bool_]
    held_out: npt.NDArray[np.bool_]
    written: OwnMaterial | None = None

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters, by name."""
        return {parameter.name: parameter.value for parameter in self.parameters}

    def error(self, part: str = "held out", prediction: str = "fit", hours: str = "all") -> SkinError:
        """One of `errors`; KeyError where there is no such reading."""
        for entry in self.errors:
            if (entry.part, entry.prediction, entry.hours) == (part, prediction, hours):
                return entry
        raise KeyError(f"no error of '{prediction}' in {part} days, {hours}")

    def to_xarray(self) -> xarray.Dataset:
        """Measured and predicted skin temperature as an `xarray.Dataset` over time, the parameters as attributes."""
        kelvin = {"measured": self.measured, "predicted": self.predicted}
        counted = {"fitted": self.fitted, "held_out": self.held_out}
        over_time = dataset(
            {"time": ("UTC", self.time.astype("datetime64[ns]"))},
            {
                **{name: (("time",), "K", values) for name, values in kelvin.items()},
                **{name: (("time",), "1", values) for name, values in counted.items()},
            },
            {"material": self.material, "effective_readings": self.effective_readings, **self.values},
        )
        del over_time["time"].attrs["units"]  # a date needs none, and xarray writes its own
        return over_time

    def _panels(self) -> list[Panel]:
        kelvin = {"measured": self.measured, "predicted": self.predicted}
        return [Panel(self.time.astype("datetime64[s]"), "UTC", "skin temperature, K", kelvin)]

    def to_dict(self) -> dict[str, Any]:
        """Plain values with their units, as ``mat materials fit --json`` prints them."""
        return {
            "material": self.material,
            "confidence": CONFIDENCE,
            "parameters": {
                entry.name: {
                    "value": quantity(entry.value, entry.units),
                    "standard_error": quantity(entry.standard_error, entry.units),
                    "interval": quantity([entry.low, entry.high], entry.units),
                    "start": quantity(entry.start, entry.units),
                    "bounds": quantity(entry.bounds, entry.units),
                }
                for entry in self.parameters
            },
            "correlation": quantity(self.correlation, "1"),
            "readings": int(self.fitted.sum()),
            "effective_readings": self.effective_readings,
            "notes": list(self.notes),
            "errors": [
                vars(entry) | {"bias": quantity(entry.bias, "K"), "rms": quantity(entry.rms, "K")}
                for entry in self.errors
            ],
            "time": {"units": "ISO 8601", "values": [f"{t}Z" for t in np.datetime_as_string(self.time, unit="s")]},
            "measured": quantity(self.measured, "K"),
            "predicted": quantity(self.predicted, "K"),
            "fitted": self.fitted.tolist(),
            "held_out": self.held_out.tolist(),
            "files": [str(file) for file in self.written.files] if self.written else [],
        }

    def __repr__(self) -> str:
        estimates = ", ".join(
            f"{parameter.name} {parameter.value:.3g} ({parameter.low:.3g} to {parameter.high:.3g})"
            for parameter in self.parameters
        )
        return f"<MaterialFit of {self.material} to {int(self.fitted.sum())} readings: {estimates}>"


def fit_material(
    record: str | os.PathLike[str],
    material: str | os.PathLike[str],
    free: Sequence[str],
    *,
    held_out: float | str = 0.25,
    spin_up: float = 1.0,
    absorptance: float | None = None,
    emissivity: float | None = None,
    name: str | None = None,
    out: str | os.PathLike[str] | None = None,
    advance: Callable[[int], object] | None = None,
) -> MaterialFit:
    """Find parameters of a material from a measured record of its skin temperature, by least squares.

    Parameters
    ----------
    record : path
        CSV as ``mat temperature --forcing`` takes it, of a level surface, with a column surface_temperature, or lw_up
        from which it follows with the emissivity; empty cells there do not count.
    material : str or path
        Material of the library, or a YAML file of the layout of ``materials/ht``; it gives the start values and all
        fixed parameters.
    free : sequence of str
        Parameters to fit, among "albedo", "emissivity", "conductivity", "heat_capacity", "thickness",
        "roughness_length", "wetness", "surface_resistance" and "back_temperature". Thickness, conductivity and heat
        capacity (at the material's density) are those of the first layer; skin and second layer follow in the latter
        two if they are of the same substance.
    held_out : float or str
        Share of the days, the last ones, that the fit does not see, or "alternate" for every second day.
    spin_up : float
        First days that do not count, because the record repeats and they follow its end.
    absorptance, emissivity : float, optional
        Optical values that replace the library's; required with a material file.
    name : str, optional
        Name of an own material to write, like `material` but for the fitted values.
    out : path, optional
        Folder of the user's material library to write into; by default MATERIALS_DATABASE.
    advance : callable, optional
        Called with 1 after each search, of which there are at most 60.

    Returns
    -------
    MaterialFit

    Raises
    ------
    InputError
        With `file:line:column` of what does not fit in the record; a parameter that is unknown or has no effect on the
        material, a material that melts, too few days or readings, a name that is taken.
    CheckFailed
        The heat balance has no solution that Newton finds.

    Examples
    --------
    A black roof from a day and a half of readings, here those of the solver itself:

    >>> import numpy as np, tempfile, skyshine.mat
    >>> hours = np.arange(0, 60, 0.5)
    >>> sun = np.maximum(np.sin((hours - 6) / 12 * np.pi), 0) * 800
    >>> air = 288 + 5 * np.sin((hours - 9) / 12 * np.pi)
    >>> head = "time,sw_down,lw_down,air_temperature,relative_humidity,wind_speed,pressure"
    >>> times = np.datetime64("2026-07-01T00:00") + (hours * 60).astype("timedelta64[m]")
    >>> rows = [f"{t}Z,{s:.1f},330,{a:.2f},50,2,100000" for t, s, a in zip(times, sun, air)]
    >>> file = tempfile.mkdtemp() + "/roof.csv"
    >>> _ = open(file, "w").write("\\n".join([head, *rows]))
    >>> skin = skyshine.mat.temperature("roof_membrane_black", forcing=file, absorptance=0.8).temperature
    >>> lines = [f"{row},{kelvin:.2f}" for row, kelvin in zip(rows, skin)]
    >>> _ = open(file, "w").write("\\n".join([head + ",surface_temperature", *lines]))
    >>> found = skyshine.mat.fit_material(file, "roof_membrane_black", ["albedo"], held_out=0.5)
    >>> f"{found.values['albedo']:.2f}"
    '0.20'
    >>> found.error("held out").rms < 0.1
    True
    """
    optical = {"solar_absorptance": absorptance, "thermal_emissivity": emissivity}
    surface = surface_material(material, {}, optical)
    target = default_folder() if out is None else Path(out)
    if name is not None:
        if os.fspath(material) != surface.name or Path(material).is_file():
            raise InputError(
                "found a material file and a name for a new one; allowed: a material of the library, for its spectrum"
            )
        refuse_taken(name, os.fspath(material), target)
    measured = read_measured(record)
    fit = fit_record(surface, measured, free, held_out=held_out, spin_up=spin_up, advance=advance)
    times = measured.averaged().record.times
    created = None if name is None else _written(name, surface, fit, record, times, optical, target)
    return MaterialFit(
        material=os.fspath(material),
        parameters=_parameters(fit),
        correlation=fit.uncertainty.correlation,
        effective_readings=fit.uncertainty.effective,
        notes=(*measured.record.notes, *fit.notes),
        errors=fit.errors,
        time=times,
        measured=fit.measured,
        predicted=fit.predicted,
        fitted=fit.fitted,
        held_out=fit.held_out,
        written=created,
    )


def _parameters(fit: Fit) -> tuple[FittedParameter, ...]:
    estimates = []
    for index, (parameter, share) in enumerate(zip(fit.parameters, fit.shares, strict=True)):
        low, high = fit.uncertainty.interval(index, float(share))
        error = abs(parameter.slope(float(share))) * float(fit.uncertainty.standard[index])
        interval = parameter.value(low), parameter.value(high)
        estimates.append(
            FittedParameter(
                parameter.name,
                parameter.units,
                parameter.start,
                parameter.value(float(share)),
                error,
                *interval,
                (parameter.low, parameter.high),
            )
        )
    return tuple(estimates)


def _written(
    name: str,
    surface: SurfaceMaterial,
    fit: Fit,
    record: str | os.PathLike[str],
    times: npt.NDArray[np.datetime64],
    optical: Mapping[str, float | None],
    folder: Path,
) -> OwnMaterial:
    """The files of the fitted material; what was given in place of the library's optical values goes with it."""
    fitted = with_numbers(surface, fit.values)
    changes = {"albedo": "solar_absorptance", "emissivity": "thermal_emissivity"}
    stated = {key for key, value in optical.items() if value is not None}
    stated |= {changes[fitted_name] for fitted_name in fit.values if fitted_name in changes}
    days = [np.datetime_as_string(time, unit="D") for time in times[fit.fitted][[0, -1]]]
    source = f"fit to {Path(record).name} ({days[0]} to {days[1]})"
    return new_material(
        name,
        like=surface.name,
        folder=folder,
        absorptance=fitted.solar_absorptance if "solar_absorptance" in stated else None,
        thermal_emissivity=fitted.thermal_emissivity if "thermal_emissivity" in stated else None,
        values=changed_numbers(surface, fit.values),
        source=source,
        description=f"Like {surface.name}, {', '.join(fit.values)} {source}",
    )
