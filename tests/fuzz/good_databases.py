"""Small good databases of every type that a runtime reads, from which hostile files are made; and a scene of them.

The surface temperatures and the atmosphere are smooth functions of their axes, so that no build is needed; the layouts
are those of the writers.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parent))
from good_channels import channels

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS, RESPONSE_HOURS
from skyshine.mat.tables.band import band_group
from skyshine.mat.tables.files import ATMQ, BAND, HTT, FileType
from skyshine.mat.tables.gridded import QUANTITIES
from skyshine.mat.tables.htt import htt_group, shade_fields
from skyshine.mat.tables.stated_error import accuracy_group, measure
from skyshine.mat.tables.tracks import track_fields, track_hours
from skyshine.materials.library import load_library
from skyshine.schemas.hdf5 import Group, Header, Variable, read_file, write_file
from skyshine.tmm import map_texture, write_texture
from skyshine.tmm.job.model import TextureJob

FILES = {"surface": "s01.htt.h5", "band": "b01.band.h5", "atmosphere": "s01b01.atmq.h5", "texture": "road.tmm.h5"}
READ_BY_RUNTIMES = ("surface", "band", "atmosphere")  # whole; of a texture they read what pixels ask for
NAMES = ("asphalt_road", "grass_green")
NO_ERRORS = np.zeros(1)
GROUND = {
    "state": "none",
    "source": "sun",
    "wavelength_um": [8.0, 12.0],
    "band": "b01",
    "date": "2026-06-28",
    "ground_emissivity": 0.9,
    "ground_temperature": 290.0,
    "ground_radiance": 7.5,
}


def write_all(folder: Path) -> dict[str, Path]:
    """Write the four databases of `FILES` into a folder."""
    paths = {kind: folder / name for kind, name in FILES.items()}
    _write(paths["surface"], _temperatures(), HTT)
    _write(paths["band"], _band(), BAND)
    _write(paths["atmosphere"], channels(_atmosphere_accuracy(), GROUND), ATMQ)
    with_shade(write_texture_of_two(folder))
    return paths


def scene(paths: dict[str, Path]) -> dict:
    """Pixels over all axes, round the periodic ones and at nodes, lit and unlit, one material by its code."""
    pixels = []
    for number in range(8):
        share = number / 7
        pixels.append(
            {
                "source_heading": 300 * share,
                "material": NAMES[number % 2] if number else _materials()[0].code,
                "surface_altitude": share,
                "surface_azimuth": 500 * share - 90,
                "surface_slope": 90 * (1 - share),
                "time": 30 * share,
                "range": 0.2 + 3 * share,
                "centre_range": 0.1 + 19 * share,
                "altitude": 0.01 + 0.9 * (1 - share),
                "centre_elevation": 170 * share - 85,
                "source_elevation": {0: -22.0, 2: -40.0}.get(number, 80 * share - 30),
                "source_azimuth": 400 * share - 20,
                "normal": [0.0, 0.3 * share, 1.0],
                "to_source": [0.5 - share, 0.2, 0.8 if number != 3 else -0.8],
                "to_observer": [0.1, share, 0.7],
            }
        )
    placed = ("source_heading", "source_elevation", "source_azimuth", "to_source")
    pixels[1] = {name: value for name, value in pixels[1].items() if name not in placed} | {"line_heading": 75.0}
    pixels[2]["surroundings"] = {"shade": [[9, 16]], "sky_view": 0.7, "facing": 290.0}
    pixels[4]["absorbed_change"] = [50.0, -30.0, 80.0]
    for number, texel in ((6, {"texel": [10.5, 7.5]}), (7, {"texel": [30, 10], "level": 1})):
        pixels[number] = {name: value for name, value in pixels[number].items() if name != "material"} | texel
    camera = {"bits": 12, "gain": 60.0, "buffer_gain": 1.02, "offset": 0.05}
    return {kind: str(paths[kind]) for kind in FILES} | camera | {"pixels": pixels}


def _write(path: Path, root: Group, kind: FileType) -> None:
    write_file(path, root, Header(kind.name, "none", "name: small", kind.title))


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
    return htt_group(
        table,
        codes,
        names,
        axes,
        _accuracy(["temperature"]),
        {"state": "none"},
        shade=_shade(materials),
        tracks=track_fields(_tracks()),
    )


def _shade(materials) -> tuple:
    """Response and light of a day: kernels that fade with the lag, a loss that grows with temperature."""
    altitudes, slopes, count = np.array([0.0, 800.0]), np.array([0.0, 90.0]), len(materials)
    shape = (count, altitudes.size, slopes.size, RESPONSE_HOURS.size)
    column = _waves([range(size) for size in shape], 1.0, 0.1)
    response = SimpleNamespace(
        altitudes_m=altitudes,
        slopes_deg=slopes,
        kernel=(0.004 * column[..., None] * np.exp(-LAG_STARTS / 5)).astype(np.float32),
        temperature=280 * column**0.1,
        loss_slope=12 * column,
        loss_excess=(0.02 * column[..., None] * OFFSETS * np.abs(OFFSETS)).astype(np.float32),
        solar_absorptance=np.array([0.9, 0.6], np.float32),
        thermal_emissivity=np.array([0.95, 0.97], np.float32),
        melt=5 * column,
        highest=np.full(count, 350.0, np.float32),
        film=_film(column),
    )
    hours = np.arange(288) / 12
    up = np.maximum(np.sin((hours - 6) / 12 * np.pi), 0.0)
    light = [np.stack([factor * up, 1.1 * factor * up]) for factor in (700.0, 90.0)]
    air = [np.stack([base + 5 * up, base - 4 + 5 * up]) for base in (320.0, 285.0)]
    turn = np.repeat(hours * 15, 2)
    sun = SimpleNamespace(solar_elevation=60 * np.cos(np.radians(turn - 180)), solar_azimuth=turn)
    scene = SimpleNamespace(open_air=lambda steps: (*light, *air, 0.3 * up * np.ones((2, 1))), sun=sun)
    return shade_fields(response, scene)


def _film(column) -> SimpleNamespace:
    """A shower at noon, after which the first material dries in the afternoon; none stays on the second."""
    rain = np.where(np.abs(np.arange(288) / 12 - 12) < 0.5, 4e-4, 0.0)
    return SimpleNamespace(
        heat_loss=(column[..., None] * (40 + 8 * OFFSETS + 0.02 * OFFSETS * np.abs(OFFSETS))).astype(np.float32),
        evaporation=(1e-5 * column[..., None] * (1 + OFFSETS / 4)).astype(np.float32),
        sunlight=30 * column,
        dry_sunlight=200 * column,
        before=None,
        capacity=np.array([0.5, 0.0], np.float32),
        rain=rain.astype(np.float32),
    )


def _tracks() -> dict:
    turn = 15 * track_hours()
    return {
        "sun_elevation": 50 * np.cos(np.radians(turn - 180)),
        "sun_azimuth": turn,
        "sun_distance": 1.01 + 1e-4 * np.sin(np.radians(turn)),
        "moon_elevation": 40 * np.cos(np.radians(turn)),
        "moon_azimuth": turn - 175.0,
        "moon_distance": 3.8e5 + 10 * turn,
        "moon_phase_angle": 30 - turn / 40,
    }


def _band() -> Group:
    wavelength = np.linspace(0.4, 14.0, 60)
    sun = (wavelength, np.ones(wavelength.size))
    group = band_group(SpectralResponse.rectangular(8.0, 12.0), _materials(), sun)
    return Group(group.axes, group.variables, {"accuracy": _accuracy(["blackbody_radiance"])})


def _atmosphere_accuracy() -> Group:
    accuracy = _accuracy(QUANTITIES)
    spectral = {
        f"spectral_{name}": Variable(("spectral_quantity",), np.zeros(2, np.float32), "1", "none")
        for name in ("max", "p95", "rms")
    }
    axis = type(accuracy.axes["quantity"])(np.array(["beta_star", "direct"], object), "1", "in-band quantity")
    return Group(accuracy.axes | {"spectral_quantity": axis}, accuracy.variables | spectral, {}, accuracy.attributes)


def with_shade(path: Path) -> Path:
    """Give a texture a layer of shade, of shares drawn for each level, so that no level follows from another."""
    root, attributes = read_file(path)
    header = Header("tmm", *(str(attributes[name]) for name in ("data_version", "job", "title")))
    draw, levels = np.random.default_rng(3), root.groups["levels"]
    shaded = {}
    for name, level in levels.groups.items():
        code = level.variables["code"]
        drawn = draw.choice([0, 60, 128, 200, 255], code.data.shape).astype(np.uint8)
        layer = Variable(code.dims, drawn, "1", "share of the texel in cast shade", {"total": 255})
        shaded[name] = replace(level, variables=level.variables | {"shade": layer})
    groups = root.groups | {"levels": replace(levels, groups=shaded)}
    write_file(path, replace(root, groups=groups), header)
    return path


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
