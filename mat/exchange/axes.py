"""Tables on five axes of a finished atmospheric file, with nodes placed by tolerance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skyshine.mat.measure.grid_nodes import placed_grid
from skyshine.mat.measure.scale import PERCENT_PER_KELVIN, REFLECTANCE, Scale
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.equivalent_temperature import REFERENCE as SCENE_K
from skyshine.mat.radiometry.equivalent_temperature import SHORTEST
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import GRID, grid_group
from skyshine.mat.tables.loader import open_as
from skyshine.mat.tables.stated_error import accuracy_group, measure
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Header, read_file, write_file

CHANNEL_K = 288.0  # K, of the black body in `thermal_reference`
DIRECT_PLACES = 90.0, 60.0  # elevations, degree: of a line of sight, and of a source that lights a surface there
SEED = 1  # seed of random numbers, so that the same call gives the same file


@dataclass(frozen=True)
class ExportedAxes:
    """A file with tables on placed axes.

    Attributes
    ----------
    shape : tuple of int
        Nodes of the five axes.
    p99 : float
        Error of interpolation between the nodes of 99 % of the reads, of the worst quantity, K.
    """

    path: Path
    shape: tuple[int, ...]
    p99: float


def export_axes(path: Path, folder: Path, kelvin: float, most_nodes: int) -> ExportedAxes:
    """Write an atmospheric file with tables on five axes into a folder, under its name.

    Parameters
    ----------
    path : Path
        An ``.atmq`` or ``.lunar_atmq`` file.
    kelvin : float
        Error that 99 % of the reads between the nodes are to keep.
    most_nodes : int
        Nodes of the table of path radiance.

    Raises
    ------
    InputError
        The file is of another type or damaged, or lies in the folder, or the folder cannot be written.
    """
    target = folder / path.name
    if target.exists() and target.samefile(path):
        raise InputError("would be written over itself; name another folder with --out", file=path)
    air = open_as(AtmosphereTable, path, "name one of these")
    sampled = placed_grid(air, scene_scale(air), kelvin, most_nodes=most_nodes, seed=SEED)
    measures = [measure(name, sampled.quantity_errors[name], error) for name, error in sampled.errors.items()]
    notes = {
        "seed": SEED,
        "tolerance": f"{kelvin:g} K",
        "method": "interpolation between the nodes against the channels at random places, a third on the ground",
    }
    root, attributes = read_file(path, verify=True)
    root = replace(
        root, groups=root.groups | {GRID: grid_group(sampled.tables, accuracy_group(measures, {}, {}, notes))}
    )
    header = Header(*(str(attributes[name]) for name in ("filetype", "data_version", "job", "title")))
    write_file(target, root, header)
    return ExportedAxes(target, sampled.tables["path_radiance_ratio"].grid.shape, sampled.p99)


def scene_scale(air: AtmosphereTable) -> Scale:
    """Kelvin of a black body at 300 K in the band of a file; in bands that end before 2.5 um, parts of the light of the
    source that a surface reflects (`measure.scale`).
    """
    wavenumber, reference = (
        np.asarray(air.root.variables[name].data, float) for name in ("channel_wavenumber", "thermal_reference")
    )
    weight = reference / planck_wavenumber(wavenumber, CHANNEL_K)
    if float(np.asarray(air.attributes["wavelength_um"], float)[1]) >= SHORTEST:
        low, scene, high = (float(weight @ planck_wavenumber(wavenumber, SCENE_K + step)) for step in (-0.5, 0.0, 0.5))
        return Scale(scene, 1 / (high - low), REFLECTANCE)
    high_km = float(np.asarray(air.attributes["altitude_km"], float)[1])
    up, source = DIRECT_PLACES
    beam = float(air.value("direct_radiance", range=0.0, altitude=high_km, elevation=up, source_elevation=source))
    light = REFLECTANCE * beam
    return Scale(light, 100 / light / PERCENT_PER_KELVIN if light > 0 else float("nan"), REFLECTANCE, relative=True)
