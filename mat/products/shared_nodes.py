"""Nodes of the tables in channels that states of similar air share: placed once for the air of their cell.

They are placed for one air of the cell, its cold and dry corner, which asks for most nodes. Directions of the source
are chosen for all its corners. Both take the points that are chosen for the cell, and the source as it is on no
particular day: they depend neither on the states that the job has there nor on which is built first. Each state tries
them in its own air. They are kept on the machine as the points of bands are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from skyshine.mat import measure, products, quantities
from skyshine.mat.atmosphere.band.cache import code_digest, content_key
from skyshine.mat.atmosphere.band.compile import SimilarAirs
from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.measure.scale import Scale
from skyshine.mat.products.channel_tables import ChannelTables, SharedNodes
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.nodes import ChannelNodes
from skyshine.mat.quantities.channels.source_parts import SourceParts
from skyshine.mat.quantities.channels.wavelength_shares import PartedLight
from skyshine.mat.radiometry.band_wavelengths import band_wavelengths
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table
from skyshine.mat.scene.compiled import band_of_airs, similar_airs
from skyshine.mat.scene.grids import path_grid, path_scope
from skyshine.mat.scene.sources import usual_irradiance
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.kept_arrays import keep_arrays, kept_arrays, kept_folder

FOLDER = "nodes"  # folder of the kept files
HEAD = b"skyshine shared nodes 1\n"
_SHARE = 0.8  # fraction of the tolerance, which the air of the cell has to reach: other airs err a little more
_by_key: dict[str, SharedNodes | None] = {}  # nodes of this process, by key


def shared_nodes(
    loaded: LoadedJob, state_of_job: State, response: SpectralResponse, source: str, everything: BandPoints
) -> SharedNodes | None:
    """The nodes that a state shares with others.

    Parameters
    ----------
    everything : BandPoints
        All points of the response.

    Returns
    -------
    SharedNodes or None
        None where the state shares none, or where no nodes meet the tolerance in the air of the cell.
    """
    job = loaded.trimmed
    airs = similar_airs(loaded.requested, state_of_job, response)
    if airs is None:
        return None
    key = content_key(
        code_digest(measure, products, quantities),
        absorption_table(job.water_continuum).content,
        airs,
        [everything.wavenumber, everything.weight, everything.gases],
        [path_grid(job), path_scope(loaded), job.atmosphere_grid.most_nodes, job.ambient_harmonics],
        [job.accuracy.seed, job.accuracy.spectral_tolerance, job.atmosphere_grid.tolerance],
        [(name, _usual(name, everything)) for name in (source, *job.sources)],
    )
    if key not in _by_key:
        folder = kept_folder(FOLDER)
        path = None if folder is None else folder / f"{key}.npz"
        arrays = None if path is None else kept_arrays(path, HEAD, key)
        if arrays is None:
            arrays = _arrays(_placed(loaded, airs, response, source, everything))
            if path is not None:
                keep_arrays(path, HEAD, key, arrays)
        _by_key[key] = _of_arrays(arrays)
    return _by_key[key]


def _placed(
    loaded: LoadedJob,
    airs: SimilarAirs,
    response: SpectralResponse,
    source: str,
    everything: BandPoints,
) -> SharedNodes | None:
    """The nodes placed for the first of some airs; None where none reach the tolerance."""
    job, scope, band = loaded.trimmed, path_scope(loaded), band_of_airs(loaded, airs, everything)
    irradiance = _usual(source, band)
    tolerance, unit = tolerance_parts(job.atmosphere_grid.tolerance)
    light = PartedLight.of(everything.wavenumber, everything.radiance_weight, _usual(source, everything))
    reference, *others = (
        ChannelTables(
            BandAtmosphere.of(air, band, scope=scope).tabulated(tolerance, unit),
            path_grid(job),
            irradiance,
            Scale.of_unit(unit, response, float(band.radiance_weight @ irradiance)),
            _SHARE * tolerance,
            job.ambient_harmonics,
            job.accuracy.seed,
            (SpectralAir.of(air, everything.points, everything.gases, everything.weight), light),
            band_wavelengths(response),
        )
        for air in airs.corners
    )
    try:
        return reference.shared(others, job.atmosphere_grid.most_nodes)
    except CheckFailed:
        return None


def _usual(source: str, band: BandPoints) -> Floats:
    return usual_irradiance(source, band.wavenumber, band.width)


def _arrays(nodes_of_cell: SharedNodes | None) -> dict[str, Floats]:
    """The fields of both parts by their names; none where there are no nodes."""
    if nodes_of_cell is None:
        return {}
    parts = (("nodes", nodes_of_cell.nodes), ("sources", nodes_of_cell.sources))
    # In the order of memory that a reader gets: sums over another one differ in their last bits.
    return {
        f"{name}.{field.name}": np.array(getattr(part, field.name), order="C")
        for name, part in parts
        for field in fields(part)
    }


def _of_arrays(arrays: Mapping[str, Floats]) -> SharedNodes | None:
    if not arrays:
        return None
    nodes, sources = (
        {field.name: arrays[f"{name}.{field.name}"] for field in fields(kind)}
        for name, kind in (("nodes", ChannelNodes), ("sources", SourceParts))
    )
    return SharedNodes(ChannelNodes(**nodes), SourceParts(**sources))
