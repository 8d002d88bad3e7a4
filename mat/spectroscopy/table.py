"""Building the absorption table: intervals one by one, kept as parts, then the file."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.absorption import FILETYPE, NEGLIGIBLE, NO_DATA, OFFSET, STEP
from skyshine.mat.spectroscopy import nodes
from skyshine.mat.spectroscopy.continua import Continua, ContinuumModel
from skyshine.mat.spectroscopy.cross_sections import CrossSectionSource, overlay, read_cross_sections
from skyshine.mat.spectroscopy.gases import MIXING, GeneratedLibrary, LineLibrary
from skyshine.mat.spectroscopy.intervals import (
    CANDIDATES,
    EXCHANGES,
    FLOOR,
    REFERENCE_CELL,
    IntervalPoints,
    build_interval,
)
from skyshine.mat.spectroscopy.lookups import LookupSource
from skyshine.mat.spectroscopy.lowtran_continua import LowtranContinua
from skyshine.mat.spectroscopy.sources import GasSources, LineSource, MixedLineSource, Source, SpectralSource
from skyshine.mat.spectroscopy.training import PERTURBED, held_out_states, reference_states, training_states
from skyshine.mat.spectroscopy.widths import interval_edges, max_points
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file

DATA_VERSION = "2.2.0"
# Names of the data by the name of the water vapour continuum.
DATA_NAMES = {"mt_ckd_4.3": "hitran2012-mtckd4.3", "lowtran7": "hitran2012-lowtran7"}
PART_VERSION = 2  # raised when the way from lines to points changes, so that finished parts are made again
# Steps of the packed logarithms: an error of half a step, 3.2e-4 of the cross section, is 1.2e-4 in transmittance at
# most.
LOG_STEP, LOG_OFFSET = 6.4e-4, -64.5
RATIO_STEP = 1.0e-4  # ratio step of the logarithm of a ratio, which is clipped to 3 and fits int16 up to 3.28
REFERENCE_STEP = 1.0e-4  # transmittances, and radiances over those of a black body; cells are averaged over bands
# m2/molecule, the largest that fits: only centres of rotational lines of H2O above 50 km exceed it, where the air is
# opaque (optical depth above 100) either way.
CEILING = 1.2e-19
LOOKUP_GASES = ("O3", "N2O")
CITATION = (
    "Lines: L. S. Rothman et al., The HITRAN2012 molecular spectroscopic database, JQSRT 130 (2013) 4-50. "
    "Partition sums: R. R. Gamache et al., JQSRT 271 (2021) 107713. "
    "{continua} "
    "The attribute `sources` of each gas names what else its cross sections come from."
)


PathLike = str | os.PathLike[str]
Part = dict[str, Any]  # arrays of one interval, as `write_part` names them


@dataclass(frozen=True)
class Settings:
    """How points are chosen: scaled rms error at which to stop, at most how many points an interval gets, and the width
    [cm^-1] of all intervals in place of those of `widths`. With a width the table has reference spectra too.
    """

    tolerance: float = 4e-4
    max_points: int = 16
    width: float | None = None


class Builder:
    """Builds intervals.

    Parameters
    ----------
    lines : folder
        HITRAN records.
    continua : folder or "lowtran7"
        The netCDF files of MT_CKD, or the packaged continua of LOWTRAN7.
    lookups, lowtran : folder and file, optional
        REPTRAN lookups and the Fortran source of LOWTRAN7, for O3 and N2O where there are no lines.
    generated : folder, optional
        Records of `python -m mat.maintain.lines generate`, for O3 and N2O where `lines` has none.
    cross_sections : folder, optional
        Measured cross sections, see `skyshine.mat.spectroscopy.cross_sections`; used where a gas has no other source,
        at the points that were chosen for the others.
    """

    def __init__(
        self,
        lines: PathLike,
        continua: PathLike,
        lookups: PathLike | None = None,
        lowtran: PathLike | None = None,
        cross_sections: PathLike | None = None,
        settings: Settings = Settings(),
        generated: PathLike | None = None,
    ) -> None:
        self.library, self.settings = LineLibrary(lines), settings
        self.continua: ContinuumModel = LowtranContinua() if continua == LowtranContinua.name else Continua(continua)
        sources: dict[str, list[SpectralSource]] = {
            gas.name: [LineSource(gas.name, self.library, self.continua)] for gas in self.library.gases
        }
        sources[MIXING].insert(0, MixedLineSource(MIXING, self.library, self.continua))
        if generated is not None:
            stand_in = GeneratedLibrary(generated)
            for gas in stand_in.gases:
                sources.setdefault(gas.name, []).append(LineSource(gas.name, stand_in, self.continua))
        if lookups is not None:
            if lowtran is None:
                raise InputError("--lookups needs --lowtran too, the Fortran source of LOWTRAN7 (lowtran7.f)")
            for name in LOOKUP_GASES:
                sources.setdefault(name, []).append(LookupSource(name, lookups, lowtran))
        self.sources = [GasSources(name, members) for name, members in sources.items()]
        self._measured = [] if cross_sections is None else read_cross_sections(cross_sections)
        self._training, self._held_out = training_states(), held_out_states()
        self._reference = [] if settings.width is None else [state for part in reference_states() for state in part]

    @property
    def gases(self) -> list[GasSources[Source]]:
        """All gases with all their sources, the measured cross sections last."""
        sources: dict[str, list[Source]] = {gas.name: list(gas.sources) for gas in self.sources}
        for source in self._measured:
            sources.setdefault(source.name, []).append(source)
        return [GasSources(name, members) for name, members in sources.items()]

    def with_measured(self, part: Part) -> Part:
        """A part of an interval with the gases that have measured cross sections there and no other source."""
        low, high = float(part["low"]), float(part["high"])
        chosen = {gas.name for gas in self.sources if gas.source(low, high) is not None}
        for source in self._measured:
            if source.name in chosen or not source.covers(low, high):
                continue
            section, error = overlay(source, low, high, part["wavenumber"], part["weight"], self._held_out)
            if section is not None:
                part[f"dry_{source.name}"] = pack(np.log(np.clip(section, FLOOR, CEILING)), LOG_STEP, LOG_OFFSET)
                part["gases"] = np.append(part["gases"], source.name)
                part["gas_error"] = np.append(part["gas_error"], error)
        return part

    def key(self, low: float, high: float) -> str:
        """Identifies parts of an interval that were built alike: edges, settings, nodes and the sources of this
        interval.
        """
        parts: list[Any] = [
            PART_VERSION,
            self.continua.name,
            low,
            high,
            CANDIDATES,
            EXCHANGES,
            PERTURBED,
            self.settings.tolerance,
            self._max_points(low),
        ]
        parts += [a.tolist() for a in (nodes.PRESSURE, nodes.TEMPERATURE, nodes.H2O_FRACTION)]
        here = [(gas.name, gas.source(low, high)) for gas in self.sources]
        parts += [[name, source.provenance] for name, source in here if source is not None]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]

    def _max_points(self, low: float) -> int:
        return min(self.settings.max_points, max_points(low))

    def interval(self, low: float, high: float) -> IntervalPoints:
        """The points of one interval."""
        return build_interval(
            self.sources,
            self.continua,
            low,
            high,
            self._training,
            self._held_out,
            tolerance=self.settings.tolerance,
            max_points=self._max_points(low),
            reference=self._reference,
        )


def part_path(folder: Path, low: float) -> Path:
    """File of the part of one interval."""
    return Path(folder) / f"{low:08.1f}.npz"


def part_is_done(folder: Path, low: float, key: str) -> bool:
    """Whether an interval's part is there, whole and built alike."""
    try:
        with np.load(part_path(folder, low)) as part:
            return str(part["key"]) == key
    except (OSError, KeyError, ValueError, zipfile.BadZipFile):
        return False


def write_part(folder: Path, points: IntervalPoints, key: str) -> None:
    """Keep an interval; the logarithms are packed as the table packs them."""
    arrays: dict[str, Any] = {
        "key": key,
        "low": points.low,
        "high": points.high,
        "wavenumber": points.wavenumber,
        "weight": points.weight,
        "continuum": points.continuum,
        "error": points.error,
        "gases": np.array(list(points.cross_section)),
        "gas_error": np.array([points.gas_error.get(gas, 0.0) for gas in points.cross_section]),
    }
    for gas, values in points.cross_section.items():
        arrays[f"dry_{gas}"] = pack(np.log(np.clip(values, FLOOR, CEILING)), LOG_STEP, LOG_OFFSET)
    for gas, ratio in points.humid.items():
        arrays[f"humid_{gas}"] = pack(np.clip(ratio, -3.0, 3.0), RATIO_STEP, 0.0)
    if points.reference is not None:
        arrays["reference"] = pack(np.asarray(points.reference, float), REFERENCE_STEP, 0.0)
    path = part_path(folder, points.low)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(f".{os.getpid()}.tmp")
    with open(temporary, "wb") as file:
        np.savez(file, **arrays)
    os.replace(temporary, path)


def pack(values: Floats, step: float, offset: float) -> npt.NDArray[np.int16]:
    """Values as 16-bit steps from an offset."""
    steps = np.rint((values - offset) / step)
    if np.abs(steps).max(initial=0) > 32767:
        raise ValueError(f"values from {values.min():g} to {values.max():g} do not fit 16-bit steps of {step:g}")
    return steps.astype(np.int16)


def along_pressure(steps: npt.NDArray[np.int16]) -> npt.NDArray[np.int16]:
    """Differences along the last axis but one, the first number before them, modulo 2^16: they pack better by two
    fifths.
    """
    differences = steps.copy()
    differences[..., 1:, :] -= steps[..., :-1, :]
    return differences


def assemble(
    parts: Sequence[Part],
    out: Path,
    *,
    sources: Sequence[GasSources[Source]],
    continua: ContinuumModel,
    settings: Settings,
) -> str:
    """Write the table from the parts of its intervals, in order; returns its hash."""
    interval = Axis([0.5 * (p["low"] + p["high"]) for p in parts], "cm-1", "centre of the interval")
    groups = {
        "intervals": _intervals_group(parts, interval),
        "points": _points_group(parts, continua.notice),
        "gases": Group(groups={gas.name: _gas_group(gas, parts, interval) for gas in sources}),
    }
    about = {
        "citation": CITATION.format(continua=continua.citation),
        "notice": continua.notice,
        "data_name": DATA_NAMES[continua.name],
        "water_continuum": continua.name,
        "description": "Spectral points of the band model; cross sections of gases over pressure and temperature.",
    }
    if settings.width is not None:
        groups["reference"] = _reference_group(parts, sources)
    job = f"mat lines build; tolerance {settings.tolerance:g}, max_points {settings.max_points}"
    header = Header(FILETYPE, DATA_VERSION, job, title="skyshine absorption table")
    return write_file(out, Group(groups=groups, attributes=about), header)


def _intervals_group(parts: Sequence[Part], interval: Axis) -> Group:
    statistic = Axis(
        np.array(["mixture rms", "mixture largest", "single gas rms", "single gas largest"]), "1", "statistic"
    )
    counts = np.array([part["wavenumber"].size for part in parts], dtype=np.int32)
    return Group(
        axes={"interval": interval, "statistic": statistic},
        variables={
            "low": Variable(("interval",), np.array([p["low"] for p in parts]), "cm-1", "lower edge"),
            "high": Variable(("interval",), np.array([p["high"] for p in parts]), "cm-1", "upper edge"),
            "count": Variable(("interval",), counts, "1", "number of points"),
            "error": Variable(
                ("interval", "statistic"),
                np.array([p["error"] for p in parts]),
                "1",
                "error of the interval's transmittance against line by line on unseen profiles and paths",
            ),
        },
    )


def _points_group(parts: Sequence[Part], notice: str) -> Group:
    wavenumber = np.concatenate([p["wavenumber"] for p in parts])
    continuum = np.concatenate([p["continuum"] for p in parts], axis=1)
    per = "m2/molecule per cm-1"
    return Group(
        axes={"point": Axis(wavenumber, "cm-1", "wavenumber of the point")},
        variables={
            "weight": Variable(("point",), np.concatenate([p["weight"] for p in parts]), "cm-1", "weight of the point"),
            "self_continuum": Variable(("point",), continuum[0], per, "water vapour self continuum, 296 K, 1013 hPa"),
            "foreign_continuum": Variable(
                ("point",), continuum[1], per, "water vapour foreign continuum, 296 K, 1013 hPa"
            ),
            "self_exponent": Variable(("point",), continuum[2], "1", "temperature exponent of the self continuum"),
        },
        attributes={"notice": notice},
    )


def _gas_group(gas: GasSources[Source], parts: Sequence[Part], interval: Axis) -> Group:
    name = gas.name
    present = [p for p in parts if f"dry_{name}" in p]
    shape = (nodes.PRESSURE.size, nodes.TEMPERATURE.size)
    dry = np.concatenate([np.zeros((0, *shape), np.int16), *(p[f"dry_{name}"] for p in present)])
    axes = {
        "interval": interval,
        "point": Axis(
            np.concatenate([np.zeros(0), *(p["wavenumber"] for p in present)]), "cm-1", "wavenumber of the point"
        ),
        "pressure": Axis(nodes.PRESSURE, "Pa", "pressure"),
        "temperature": Axis(nodes.TEMPERATURE, "K", "temperature"),
    }
    error = [p["gas_error"][list(p["gases"]).index(name)] if f"dry_{name}" in p else 0.0 for p in parts]
    variables = {
        "source": Variable(("interval",), _codes(gas, parts), "1", "0 no data, 1 negligible, 2... entry of `sources`"),
        "rms_error": Variable(
            ("interval",), np.array(error), "1", "rms error of this gas's transmittance, see /intervals/error"
        ),
        "log_cross_section": Variable(
            ("point", "pressure", "temperature"),
            along_pressure(dry),
            "1",
            "natural logarithm of the cross section in m2/molecule, dry air, as differences along pressure",
            {STEP: LOG_STEP, OFFSET: LOG_OFFSET},
            chunks=(128, *shape),
        ),
    }
    if any(f"humid_{name}" in p for p in present):
        humid = np.concatenate([p[f"humid_{name}"] for p in present])
        axes["h2o_fraction"] = Axis(nodes.H2O_FRACTION[1:], "1", "mole fraction of water vapour")
        axes["humid_pressure"] = Axis(nodes.PRESSURE[nodes.HUMID_PRESSURE :], "Pa", "pressure")
        variables["log_moist_ratio"] = Variable(
            ("point", "h2o_fraction", "humid_pressure", "temperature"),
            along_pressure(humid),
            "1",
            "natural logarithm of the ratio of the cross sections in moist and dry air, as differences along pressure",
            {STEP: RATIO_STEP, OFFSET: 0.0},
            chunks=(128, *humid.shape[1:]),
        )
    about = {
        "sources": [source.provenance for source in gas.sources],
        "terms": [source.terms for source in gas.sources],
    }
    return Group(axes=axes, variables=variables, attributes=about)


def _reference_group(parts: Sequence[Part], sources: Sequence[GasSources[Source]]) -> Group:
    """Line-by-line spectra of paths over cells, and the air and the columns that make the paths."""
    fit, test = reference_states()
    states = [*fit, *test]
    means = np.concatenate([part["reference"] for part in parts], axis=1)
    cells = [part["low"] + REFERENCE_CELL * (np.arange(part["reference"].shape[1]) + 0.5) for part in parts]
    summed = [gas.name for gas in sources if not all(isinstance(source, CrossSectionSource) for source in gas.sources)]
    deepest = max(len(slabs) for state in states for slabs in state.emission)
    slabs = [[np.pad(depths, ((deepest - len(depths), 0), (0, 0))) for depths in state.emission] for state in states]
    level = ("state", "level")
    return Group(
        axes={
            "cell": Axis(np.concatenate(cells), "cm-1", "middle of the cell"),
            "gas": Axis(np.array(summed), "1", "gas"),
            **{
                name: Axis(np.arange(size, dtype=np.int32), "1", name)
                for name, size in (
                    ("row", len(means)),
                    ("state", len(states)),
                    ("level", states[0].pressure.size),
                    ("path", len(states[0].columns)),
                    ("sight", len(states[0].emission)),
                    ("slab", deepest),
                )
            },
        },
        variables={
            "value": Variable(
                ("row", "cell"),
                means,
                "1",
                "of each state in turn: transmittance of its paths; radiance of its lines of sight over that of a black"
                " body as warm as its warmest level",
                {"scale_factor": REFERENCE_STEP, "add_offset": 0.0},
                chunks=(len(means), 512),
            ),
            "fitted": Variable(
                ("state",), np.repeat([1, 0], [len(fit), len(test)]).astype(np.int8), "1", "1: for fits; 0: for tests"
            ),
            "pressure": Variable(level, np.array([state.pressure for state in states]), "Pa", "pressure"),
            "temperature": Variable(level, np.array([state.temperature for state in states]), "K", "temperature"),
            "fraction": Variable(
                ("state", "gas", "level"),
                np.array([[state.fraction[name] for name in summed] for state in states]),
                "1",
                "mole fraction",
            ),
            "columns": Variable(
                ("state", "path", "level"), np.array([state.columns for state in states]), "m-2", "air along the paths"
            ),
            "slabs": Variable(
                ("state", "sight", "slab", "level"), np.array(slabs), "m-2", "air of the slabs along lines of sight"
            ),
        },
    )


def _codes(gas: GasSources[Source], parts: Sequence[Part]) -> npt.NDArray[np.int8]:
    """Code of the source of a gas in each interval, as the table keeps it."""
    codes = []
    for part in parts:
        number = gas.number(float(part["low"]), float(part["high"]))
        if number is None:
            codes.append(NO_DATA)
        else:
            codes.append(NEGLIGIBLE + 1 + number if f"dry_{gas.name}" in part else NEGLIGIBLE)
    return np.array(codes, dtype=np.int8)


def build(
    ranges: Sequence[tuple[float, float]],
    out: PathLike,
    lines: PathLike,
    continua: PathLike,
    *,
    lookups: PathLike | None = None,
    lowtran: PathLike | None = None,
    cross_sections: PathLike | None = None,
    generated: PathLike | None = None,
    settings: Settings = Settings(),
    parts: PathLike | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> str:
    """Build the table over ranges of wavenumber; finished intervals of an earlier, interrupted build are kept.

    Parameters
    ----------
    ranges : list of (low, high), cm^-1
        Widened to whole intervals.
    out : path
    lines, continua, lookups, lowtran, cross_sections, generated
        See `Builder`.
    parts : path, optional
        Folder of the finished intervals; by default `out` with ``.parts`` added.
    progress : callable, optional
        Called with (done, total) after each interval.

    Returns
    -------
    str
        Hash of the table's content.
    """
    folder = Path(parts) if parts else Path(f"{out}.parts")
    edges = np.unique(np.concatenate([interval_edges(*pair, settings.width) for pair in ranges]), axis=0)
    builder = Builder(lines, continua, lookups, lowtran, cross_sections, settings, generated)
    for number, (low, high) in enumerate(edges.tolist()):
        key = builder.key(low, high)
        if not part_is_done(folder, low, key):
            write_part(folder, builder.interval(low, high), key)
        if progress:
            progress(number + 1, len(edges))
    finished = [builder.with_measured(dict(np.load(part_path(folder, low)))) for low in edges[:, 0]]
    return assemble(finished, Path(out), sources=builder.gases, continua=builder.continua, settings=settings)
