"""A batch on a cluster, simulated: where more cores do not help, of seconds and bytes measured on one machine.

The client reads sites and sends tasks, the scheduler passes them on, workers compute, a file system takes what they
write: one queue each but the workers. Every task is followed; no machine is.
"""

from __future__ import annotations

import heapq
import json
import random
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import click

WINDOW = 4_000  # tasks on their way, as `builder.build`
CORES = (100, 300, 1000, 3000)
SPREAD = 0.2  # spread of the seconds of equal tasks, standard deviation of the logarithm


@dataclass(frozen=True)
class Costs:
    """What a batch costs.

    Attributes
    ----------
    atmosphere_seconds, temperature_seconds : float
        Processor seconds of a further state of one band, and of its temperatures.
    cell_seconds : float
        Seconds of the first state of a cell of similar airs beyond a further one's, of one band.
    atmosphere_bytes, temperature_bytes : int
        Bytes of a file.
    site_seconds : float
        Seconds in which the client reads and checks a site of a year.
    submit_seconds : float
        Seconds of client and scheduler for a task.
    creates_per_second, bytes_per_second : float
        Files that the file system makes, and bytes that it takes, in a second. Assumed, not measured.
    cells, altitudes : int
        Cells of similar airs that a year of a site meets, and altitudes of sites, which share cells where they are
        equal. Assumed.
    """

    atmosphere_seconds: float
    temperature_seconds: float
    cell_seconds: float
    atmosphere_bytes: int
    temperature_bytes: int
    site_seconds: float
    submit_seconds: float
    creates_per_second: float = 2_000.0
    bytes_per_second: float = 1e9
    cells: int = 4
    altitudes: int = 20


@dataclass(frozen=True)
class Batch:
    """Sites, days and bands."""

    sites: int = 1000
    days: int = 365
    bands: int = 4


@dataclass(frozen=True)
class Outcome:
    """What became of a batch.

    Attributes
    ----------
    way : str
    cores : int
    hours : float
    efficiency : float
        Seconds of further states alone, over all cores' seconds.
    cell_share, idle_share : float
        Shares of the cores' seconds in which cells were computed, and nothing.
    """

    way: str
    cores: int
    hours: float
    efficiency: float
    cell_share: float
    idle_share: float


def of_dask(batch: Batch, costs: Costs, cores: int, *, shared: bool) -> Outcome:
    """One client and scheduler; cells are kept in a folder that all workers share, or by each process for itself."""
    draw, server_free, files_free = random.Random(cores), 0.0, 0.0
    workers = [(0.0, number) for number in range(cores)]
    ends: list[float] = []
    known: dict[tuple[int, ...], float] = {}
    cells = useful = end_seconds = 0.0
    for site, day, band in _tasks(batch):
        if day == 0 and band == 1:
            server_free += costs.site_seconds
        if len(ends) == WINDOW:  # the next task leaves when one has come back
            server_free = max(server_free, heapq.heappop(ends))
        server_free += costs.submit_seconds
        free, worker = heapq.heappop(workers)
        start = max(free, server_free)
        seconds = _seconds(costs, band) * draw.lognormvariate(0.0, SPREAD)
        useful += seconds
        if band:
            cell = band, site % costs.altitudes, _cell(batch, costs, day)
            key = cell if shared else (worker, *cell)
            # Workers that meet a cell before it is kept compute it too.
            if start < known.get(key, float("inf")):
                known[key] = min(known.get(key, float("inf")), start + costs.cell_seconds)
                seconds += costs.cell_seconds
                cells += costs.cell_seconds
        size = costs.atmosphere_bytes if band else costs.temperature_bytes
        files_free = max(files_free, start) + 1 / costs.creates_per_second + size / costs.bytes_per_second
        end = max(start + seconds, files_free)
        heapq.heappush(workers, (end, worker))
        heapq.heappush(ends, end)
        end_seconds = max(end_seconds, end)
    total = cores * end_seconds
    way = "Dask, cells in one folder" if shared else "Dask, cells of each process"
    return Outcome(way, cores, end_seconds / 3600, useful / total, cells / total, 1 - (useful + cells) / total)


def of_parts(batch: Batch, costs: Costs, cores: int) -> Outcome:
    """A job array of as many parts as cores, each with stretches of the sites and cells of its own folder."""
    states = batch.sites * batch.days
    share = -(-states // cores)
    sites = share / batch.days + (1 if share % batch.days else 0)
    state_seconds = batch.bands * costs.atmosphere_seconds + costs.temperature_seconds
    cells = batch.bands * costs.cell_seconds * min(costs.cells, max(1.0, share * costs.cells / batch.days))
    cells *= min(sites, costs.altitudes)
    written = states * (batch.bands + 1) / costs.creates_per_second
    written += states * (batch.bands * costs.atmosphere_bytes + costs.temperature_bytes) / costs.bytes_per_second
    end_seconds = max(share * state_seconds + cells + sites * costs.site_seconds, written)
    useful = states * state_seconds / (cores * end_seconds)
    return Outcome(
        "parts of an array",
        cores,
        end_seconds / 3600,
        useful,
        cells / end_seconds,
        max(0.0, 1 - useful - cells / end_seconds),
    )


def _tasks(batch: Batch) -> Iterator[tuple[int, int, int]]:
    """Site, day and band (0: temperatures) of each task, in the order in which a build sends them."""
    for site in range(batch.sites):
        for day in range(batch.days):
            for band in range(1, batch.bands + 1):
                yield site, day, band
        for day in range(batch.days):
            yield site, day, 0


def _cell(batch: Batch, costs: Costs, day: int) -> int:
    """Cell of a day: the seasons up and down again."""
    return int(costs.cells * min(abs(2 * day / batch.days - 1), 1 - 1e-9))


def _seconds(costs: Costs, band: int) -> float:
    return costs.atmosphere_seconds if band else costs.temperature_seconds


def measured_costs(folder: Path, client_seconds: tuple[float, float]) -> Costs:
    """Costs of a build's record: means of tasks; a state whose stage "similar airs" took seconds has placed a cell.

    Parameters
    ----------
    folder : Path
        Output folder of `mat build` of some states of several bands, by one process.
    client_seconds : pair of float
        Seconds for a site, and for a task.
    """
    files = json.loads((folder / "build.json").read_text(encoding="utf-8"))["files"]
    air = {name: entry for name, entry in files.items() if "atmq" in name}
    surface = {name: entry for name, entry in files.items() if name.endswith(".htt.h5")}
    placed = [entry["processor_seconds"] for entry in air.values() if entry["processor_stages"]["similar airs"] > 1]
    further = [entry["processor_seconds"] for entry in air.values() if entry["processor_stages"]["similar airs"] <= 1]
    if not placed or not further or not surface:
        raise click.ClickException(f"{folder}: lacks a first state, a further one or temperatures; build more states")
    later = _mean(further)
    return Costs(
        later,
        _mean([entry["processor_seconds"] for entry in surface.values()]),
        _mean(placed) - later,
        round(_mean([(folder / name).stat().st_size for name in air])),
        round(_mean([(folder / name).stat().st_size for name in surface])),
        *client_seconds,
    )


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


def table(outcomes: Sequence[Outcome]) -> str:
    """Markdown."""
    rows = ["| way | cores | hours | efficiency | in cells | idle |", "|---|---|---|---|---|---|"]
    for outcome in outcomes:
        shares = " | ".join(
            f"{100 * value:.0f} %" for value in (outcome.efficiency, outcome.cell_share, outcome.idle_share)
        )
        rows.append(f"| {outcome.way} | {outcome.cores:,} | {outcome.hours:.3g} | {shares} |")
    return "\n".join(rows) + "\n"


def simulated(batch: Batch, costs: Costs, cores: Sequence[int] = CORES) -> list[Outcome]:
    """All ways on all numbers of cores."""
    ways = [of_dask(batch, costs, number, shared=shared) for shared in (True, False) for number in cores]
    return ways + [of_parts(batch, costs, number) for number in cores]


@click.command(epilog="Example: python -m mat.maintain.bench.cluster_model built --site 0.5 --task 0.0043")
@click.argument("folder", type=click.Path(path_type=Path, exists=True, file_okay=False))
@click.option("--site", required=True, type=float, help="Seconds in which a client reads a site.")
@click.option("--task", required=True, type=float, help="Seconds of client and scheduler for a task.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Results as JSON.")
def main(folder: Path, site: float, task: float, out: Path | None) -> None:
    """Simulate 1,000 sites, 365 days and 4 bands with the costs of a build in FOLDER."""
    costs, batch = measured_costs(folder, (site, task)), Batch()
    outcomes = simulated(batch, costs)
    click.echo(table(outcomes))
    if out is not None:
        content = {
            "batch": asdict(batch),
            "costs": asdict(costs),
            "outcomes": [asdict(outcome) for outcome in outcomes],
        }
        out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
