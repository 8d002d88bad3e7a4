"""Terminal output of a build of a month of days: the lines of its log, and its progress bar at some moments.

`pictures` draws them with all others. It builds 30 states in a folder of its own, in some minutes, and writes
``month_build.log`` and ``month_build.svg``.
"""

from __future__ import annotations

import io
import logging
import tempfile
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from rich.console import Console

from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job
from skyshine.schemas.commands import LINES, progress_on
from skyshine.schemas.whole_files import write_whole

NAME = "month_build"
FILES = (f"{NAME}.log", f"{NAME}.svg")
WIDTH = 110  # columns of the terminal
SHOWN = (1, 20, 40, 60)  # tables that are done when the bar is shown
JOB = """\
skyshine: 1
name: month
site: {latitude_deg: 50, longitude_deg: 10, date: 2026-06-01, utc_offset_h: 1}
states:
  - name: june
    profile: midlatitude_summer
    weather: {air_temperature_c: [12, 24], relative_humidity_percent: 60}
    series: {first: 2026-06-01, last: 2026-06-30}
bands:
  - {name: lwir, wavelength_um: [8, 12]}
sources: [sun]
materials: [asphalt_road, grass_green, concrete]
atmosphere_grid:
  range_km: [0.01, 1, 5]
  altitude_km: [0.01, 1]
  elevation_deg: [-90, -10, 0, 90]
  source_elevation_deg: [-20, 0, 30, 65]
  source_azimuth_deg: [0, 90, 180]
surface_grid: {altitude_km: [0], azimuth_deg: [0, 90, 180, 270], slope_deg: [0, 90]}
output: {folder: built, pictures: false}
"""

Progress = Callable[[float, str], AbstractContextManager[Callable[[float], None]]]


def draw(folder: Path, job: str = JOB, steps: Collection[int] = SHOWN) -> tuple[Path, Path]:
    """Build a job and write the lines of its log, and its bar after the numbers of tables in `steps`.

    Returns
    -------
    tuple of Path
        The text, and the picture.
    """
    lines, terminal = io.StringIO(), Console(record=True, force_terminal=True, width=WIDTH, file=io.StringIO())
    handler = logging.StreamHandler(lines)
    handler.setFormatter(LINES)
    log = logging.getLogger("skyshine")
    log.addHandler(handler)
    try:
        with tempfile.TemporaryDirectory() as name:
            file = Path(name) / "job.yaml"
            file.write_text(job, encoding="utf-8")
            terminal.print("[bold]$ mat build job.yaml[/bold]", highlight=False)
            record = build(load_job(file), progress=_shown_on(terminal, steps))
    finally:
        log.removeHandler(handler)
    end = f"built: {len(record['files'])} files in {record['seconds']:.1f} s"
    terminal.print(end, highlight=False)
    text, picture = (folder / file for file in FILES)
    write_whole(text, f"$ mat build job.yaml --verbose\n{lines.getvalue()}{end}\n")
    write_whole(picture, terminal.export_svg(title="mat build: thirty days"))
    return text, picture


def _shown_on(terminal: Console, steps: Collection[int]) -> Progress:
    """A progress that prints its bar to a terminal after some numbers of tables."""

    @contextmanager
    def progress(total: float, description: str) -> Iterator[Callable[[float], None]]:
        unseen = Console(force_terminal=True, width=WIDTH, file=io.StringIO())
        with progress_on(unseen, total, description) as (bar, advance):
            finished = 0.0

            def count(amount: float = 1) -> None:
                nonlocal finished
                advance(amount)
                finished += amount
                if finished in steps:
                    terminal.print(bar.get_renderable())

            yield count

    return progress
