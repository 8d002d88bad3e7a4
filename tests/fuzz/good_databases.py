"""Small good databases of every type that a runtime reads, from which hostile files are made; and a scene of them.

The surface temperatures and the atmosphere are smooth functions of their axes, so that no build is needed; the layouts
are those of the writers.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
from PIL import Image

from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.tables.atmq import atmq_group
from skyshine.mat.tables.band import band_group
from skyshine.mat.tables.files import ATMQ, BAND, HTT, FileType
from skyshine.mat.tables.gridded import QUANTITIES, Gridded
from skyshine.mat.tables.htt import htt_group
from skyshine.mat.tables.stated_error import accuracy_group, measure
from skyshine.materials.library import load_library
from skyshine.schemas.hdf5 import Group, Header, Variable, write_file
from skyshine.tmm import map_texture, write_texture
from skyshine.tmm.job.model import TextureJob

FILES = {"surface": "s01.htt.h5", "band": "b01.band.h5", "atmosphere": "s01b01.atmq.h5", "texture": "road.tmm.h5"}
READ_BY_RUNTIMES = ("surface", "band", "atmosphere")
NAMES = ("asphalt_road", "grass_green")
NO_ERRORS = np.zeros(1)


def write_all(folder: Path) -> dict[str, Path]:
    """Write the four databases of `FILES` into a folder."""
    paths = {kind: folder / name for kind, name in FILES.items()}
    _write(paths["surface"], _temperatures(), HTT)
    _write(paths["band"], _band(), BAND)
    _write(paths["atmosphere"], _atmosphere(), ATMQ)
    write_texture_of_two(folder)
    return paths


def scene(paths: dict[str, Path]) -> dict:
    """Pixels over all axes, round the periodic ones and at nodes, lit and unlit, one material by its code."""
    pixels = []
    for number in range(8):
        share = number / 7
        pixels.append(
            {
                "material": NAMES[number % 2] if number else _materials()[0].code,
                "surface_altitude": share,
                "surface_azimuth": 500 * share - 90,
                "surface_slope": 90 * (1 - share),
                "time": 30 * share,
                "range": 0.2 + 3 * share,
                "centre_range": 0.1 + 19 * share,
                "altitude": 0.01 + 0.9 * (1 - share),
                "centre_elevation": 170 * share - 85,
                "source_elevation": 80 * share - 20,
                "source_azimuth": 400 * share - 20,
                "normal": [0.0, 0.3 * share, 1.0],
                "to_source": [0.5 - share, 0.2, 0.8 if number != 3 else -0.8],
                "to_observer": [0.1, share, 0.7],
            }
        )
    camera = {"bits": 12, "gain": 60.0, "buffer_gain": 1.02, "offset": 0.05}
    return {kind: str(paths[kind]) for kind in READ_BY_RUNTIMES} | camera | {"pixels": pixels}


def _write(path: Path, root: Group, kind: FileType) -> None:
    write_file(path, root, Header(kind.name, kind.format_version, "none", "name: small", kind.title))


def _materials():
    library = load_library()
    return sorted((library[name] for name in NAMES), key=lambda material: material.code)


def _accuracy(names) -> Group:
    notes = {"seed": 1, "method": "none: the values are drawn"}
    return accuracy_group([measure(name, NO_ERRORS, NO_ERRORS) for name in names], {}, {}, notes)


def _waves(nodes, offset: float, height: float) -> np.ndarray:
    """A smooth positive function on a grid, unlike at any two nodes."""
    phases = [np.linspace(0.3, 1.1 + 0.2 * k, len(each)) for k, each in enumerate(nodes)]
    return (offset + height * sum(np.sin(phase) for phase in np.meshgrid(*phases, indexing="ij"))).astype(np.float32)


def _temperatures() -> Group:
    axes = {
        "altitude_km": np.array([0.0, 1.0]),
        "azimuth_deg": np.array([0.0, 90.0, 180.0, 270.0]),
        "slope_deg": np.array([0.0, 90.0]),
        "time_h": np.array([0.0, 6.0, 12.0, 18.0]),
    }
    materials = _materials()
    temperature = _waves([materials, *axes.values()], 280.0, 10.0)
    zeros, shape = np.zeros(temperature.shape[:-1], np.float32), temperature.shape[:-1]
    table = SimpleNamespace(
        temperature=temperature,
        residual=zeros,
        energy_closure=zeros,
        bound_excess=zeros,
        method=np.zeros(shape, np.uint8),
        iterations=np.ones(shape, np.int32),
        method_names="none",
    )
    codes, names = zip(*((material.code, material.name) for material in materials), strict=True)
    return htt_group(table, codes, names, axes, _accuracy(["temperature"]), {"state": "none"})


def _band() -> Group:
    wavelength = np.linspace(0.4, 14.0, 60)
    sun = (wavelength, np.ones(wavelength.size))
    group = band_group(SpectralResponse.rectangular(8.0, 12.0), _materials(), sun)
    return Group(group.axes, group.variables, {"accuracy": _accuracy(["blackbody_radiance"])})


def _atmosphere() -> Group:
    grid = PathGrid(
        np.array([0.001, 5.0, 20.0]),
        np.array([0.01, 0.5, 1.0]),
        np.array([-90.0, 0.0, 90.0]),
        np.array([-20.0, 20.0, 60.0]),
        np.array([0.0, 90.0, 180.0]),
    )
    tables = {}
    for number, (name, (_, count)) in enumerate(QUANTITIES.items()):
        nodes = [
            grid.range_km,
            grid.altitude_km,
            grid.elevation_deg,
            grid.source_elevation_deg,
            grid.source_azimuth_deg,
        ]
        tables[name] = Gridded(grid, _waves(nodes[:count], 5.0 + number, 1.0), np.ones((3, 3, 3), bool))
    accuracy = _accuracy(QUANTITIES)
    spectral = {
        f"spectral_{name}": Variable(("spectral_quantity",), np.zeros(2, np.float32), "1", "none")
        for name in ("max", "p95", "rms")
    }
    axis = type(accuracy.axes["quantity"])(np.array(["beta_star", "direct"], object), "1", "in-band quantity")
    accuracy = Group(
        accuracy.axes | {"spectral_quantity": axis}, accuracy.variables | spectral, {}, accuracy.attributes
    )
    return atmq_group(tables, accuracy, {"state": "none", "source": "sun", "wavelength_um": [8.0, 12.0]})


def write_texture_of_two(folder: Path) -> Path:
    """Write the texture of `FILES` into a folder: green on the left and grey on the right; returns its path."""
    path = folder / FILES["texture"]
    draw = np.random.default_rng(1)
    pixels = np.empty((20, 40, 3))
    pixels[:, :20], pixels[:, 20:] = (60, 140, 50), (120, 120, 125)
    noise = draw.normal(0, 6, pixels.shape)
    Image.fromarray(np.clip(pixels + noise, 0, 255).astype(np.uint8)).save(folder / "road.png")
    polygons = {NAMES[1]: [[[2, 2], [12, 2], [12, 15], [2, 15]]], NAMES[0]: [[[25, 3], [38, 3], [38, 12], [25, 12]]]}
    job = TextureJob.model_validate({"image": "road.png", "seeds": {"polygons": polygons}})
    write_texture(map_texture(job, folder, load_library()), path)
    return path
