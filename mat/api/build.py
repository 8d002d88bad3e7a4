"""Building the databases of a job."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.builder.build import build as build_files
from skyshine.mat.job.load import JobSites, LoadedJob, job_sites
from skyshine.mat.scene.agreement import air_warnings, twilight_warnings
from skyshine.mat.tables.dataset import dataset
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.result import Result
from skyshine.mat.tables.table import Table
from skyshine.schemas.progress import Progress, silent

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, repr=False)
class Build(Result):
    """Files and times of a build.

    Attributes
    ----------
    folder : Path
    seconds : float
        Wall clock until all files were ready; pictures are drawn after that.
    files : dict of str to dict
        Record of each file by name: ``kept``, ``seconds``, ``processor_seconds``, ``stages``, ``processor_stages``,
        ``peak_memory_bytes``, ``notes``.
    not_of_this_job : list of str
        Databases in the folder that this job does not build, left as they are.
    warnings : list of str
        Contradictions between weather, profile, sounding and the site of a weather file, with numbers; of a job of
        several sites `check` says them.
    """

    folder: Path
    seconds: float
    files: dict[str, dict[str, Any]]
    not_of_this_job: list[str]
    warnings: list[str]

    def open(self, name: str) -> Table:
        """Open one of the files, such as ``'s01.htt'``, with or without ``.h5``."""
        return open_table(self.folder / (name if name.endswith(".h5") else f"{name}.h5"))

    def to_xarray(self) -> xarray.Dataset:
        """What each file cost, as an `xarray.Dataset` over files.

        Wall and processor seconds and peak memory of the task that wrote it, and the error that it states (99 % of the
        values within, and the largest) in kelvin; not a number where a file states none.
        """
        files = list(self.files.values())

        def values(key: str) -> npt.NDArray[np.float64]:
            return np.array([entry[key] for entry in files], float)

        def errors(key: str) -> npt.NDArray[np.float64]:
            return np.array([(entry.get("error_kelvin") or {}).get(key, np.nan) for entry in files], float)

        return dataset(
            {"file": ("1", np.array(list(self.files), str))},
            {
                "kept": (("file",), "1", np.array([bool(entry["kept"]) for entry in files])),
                "time": (("file",), "s", values("seconds")),
                "processor_time": (("file",), "s", values("processor_seconds")),
                "peak_memory": (("file",), "byte", values("peak_memory_bytes")),
                "error_p99": (("file",), "K", errors("p99")),
                "error_maximum": (("file",), "K", errors("maximum")),
            },
            {"folder": str(self.folder), "seconds": self.seconds},
        )

    def __repr__(self) -> str:
        unchanged = sum(bool(entry["kept"]) for entry in self.files.values())
        return f"<Build {self.folder}: {len(self.files)} files, {unchanged} kept, {self.seconds:.1f} s>"


def build(
    job: str | os.PathLike[str] | Mapping[str, Any],
    *,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    executor: str | None = None,
    part: str | None = None,
    pictures: bool | None = None,
    progress: Progress = silent,
) -> Build:
    """Build all databases of a job as `mat build` does.

    The logger ``skyshine.mat.build`` says each file that is finished, at level INFO.

    Parameters
    ----------
    job : path or mapping
        A YAML job, or its content; paths in a mapping are relative to the working directory.
    out : path, optional
        Output folder; by default the one that the job names.
    jobs : int, optional
        Processes; by default one a core.
    fresh : bool
        Build files again that the same job has built before.
    executor : str, optional
        ``dask:ADDRESS`` of a scheduler; files come back from workers that do not see the output folder.
    part : str, optional
        ``I/N``, such as ``"3/12"``: one of N disjoint parts of the states, for job arrays.
    pictures : bool, optional
        Whether the files are drawn once all are ready; by default as the job's output.pictures says.
    progress : callable, optional
        ``progress(total, text)`` is a context manager that gives a callable to count finished tasks with.

    Returns
    -------
    Build

    Raises
    ------
    InputError
        The job does not fit, a file cannot be written, or another build writes into the folder.
    CheckFailed
        A process of the build died, or a table failed for another reason than its input; the others are built.

    Examples
    --------
    >>> import skyshine.mat
    >>> job = {
    ...     "skyshine": 1,
    ...     "name": "one wall",
    ...     "site": {"latitude_deg": 35, "longitude_deg": 139, "date": "2026-06-21", "utc_offset_h": 9},
    ...     "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [18, 29]}}],
    ...     "bands": [{"wavelength_um": [8, 12]}],
    ...     "sources": ["sun"],
    ...     "materials": ["concrete"],
    ...     "atmosphere_grid": {
    ...         "range_km": [0.01, 1],
    ...         "altitude_km": [0.1],
    ...         "elevation_deg": [0, 90],
    ...         "source_elevation_deg": [45],
    ...         "source_azimuth_deg": [0],
    ...     },
    ...     "surface_grid": {"altitude_km": [0], "azimuth_deg": [180], "slope_deg": [90]},
    ...     "output": {"pictures": False},
    ... }
    >>> built = skyshine.mat.build(job, out="wall", jobs=1)
    >>> sorted(built.files)
    ['b01.band.h5', 's01.htt.h5', 's01b01.atmq.h5']
    >>> wall = built.open("s01.htt").temperature(material="concrete", azimuth=180, slope=90, time=15)
    >>> bool(290 < wall < 330)
    True
    """
    sites = job_sites(job)
    if sites.names == ("",):
        sites = JobSites.of(sites.load(0))
    record = build_files(
        sites, out=out, jobs=jobs, fresh=fresh, executor=executor, part=part, pictures=pictures, progress=progress
    )
    warnings = [] if len(sites.names) > 1 else _warnings(sites.load(0))
    return Build(Path(record["folder"]), record["seconds"], record["files"], record["not_of_this_job"], warnings)


def _warnings(loaded: LoadedJob) -> list[str]:
    return [*loaded.warnings, *air_warnings(loaded.trimmed), *twilight_warnings(loaded.trimmed)]
