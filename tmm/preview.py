"""Pictures of a mapped texture: the photograph, its materials with a legend, and the confidence, side by side."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.tmm.database import TmmFile, open_tmm
from skyshine.tmm.texture import file_sha256, read_texture

MAX_SIDE = 1600  # texels drawn a side; larger textures are thinned
UNKNOWN = (0.0, 0.0, 0.0)


def find_image(file: TmmFile, path: Path, image: str | os.PathLike | None) -> Path:
    """The texture's own image: the one given, or one of its name beside the database, in the folder above, or here.

    Raises
    ------
    InputError
        It is not found, or its bytes are not those that were classified.
    """
    wanted, digest = Path(str(file.attributes["texture"])), file.attributes["texture_sha256"]
    places = [Path(image)] if image else [path.parent / wanted.name, path.parent.parent / wanted, wanted]
    for place in places:
        if place.is_file():
            if file_sha256(place) == digest:
                return place
            raise InputError(
                "is not the image that was classified (its SHA-256 differs); name it with --image", file=place
            )
    tried = ", ".join(str(place) for place in places)
    raise InputError(f"the image of this texture is not at {tried}; name it with --image", file=path)


def draw(path: str | os.PathLike, out: str | os.PathLike, image: str | os.PathLike | None = None) -> None:
    """Draw a texture database into a PNG file.

    Parameters
    ----------
    path : path
        The database.
    out : path
    image : path, optional
        The texture; by default it is looked for by its name (see `find_image`).

    Raises
    ------
    InputError
        The database or the image cannot be read, or the picture cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with open_tmm(path) as file:
        step = -(-max(file.height, file.width) // MAX_SIDE)
        photograph = _photograph(find_image(file, Path(path), image))[::step, ::step]
        wide = file.width >= 1.3 * file.height
        rows, columns = (3, 1) if wide and file.width > 2 * file.height else (2, 2)
        figure = Figure(figsize=(12, 12 * rows / columns * file.height / file.width + 0.9), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        axes[0].imshow(photograph)
        axes[0].set_title(f"{file.attributes['texture']}, {file.width} x {file.height}")
        legend = _draw_codes(file, axes[1], step)
        shown = axes[2].imshow(file.array("levels/0/confidence")[::step, ::step], vmin=0, vmax=1, cmap="viridis")
        axes[2].set_title("confidence")
        figure.colorbar(shown, ax=axes[2], shrink=0.8)
        for axis in axes:
            axis.set_axis_off()
        if len(axes) > 3:
            axes[3].legend(handles=legend, loc="center", frameon=False, fontsize="large")
        else:
            axes[1].legend(handles=legend, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    try:
        FigureCanvasAgg(figure).print_png(str(out), metadata={"Software": "skyshine"})
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; check the folder", file=out) from None


def _photograph(path: Path) -> np.ndarray:
    """Colours (H, W, 3) float32 for the screen; high dynamic range is cut at its 99th percentile."""
    texture = read_texture(path, alpha="ignore")
    pixels = texture.pixels
    if pixels.dtype.kind == "u":
        return pixels / np.float32(np.iinfo(pixels.dtype).max)
    finite = np.where(texture.valid[..., np.newaxis], pixels, 0)
    white = np.percentile(finite[texture.valid], 99) if texture.valid.any() else 1.0
    return np.clip(finite / max(white, np.finfo(np.float32).tiny), 0, 1) ** np.float32(1 / 2.2)


def _draw_codes(file: TmmFile, axis, step: int) -> list:
    """Draw level 0 and return the legend's handles, each with the material's share."""
    from matplotlib import colormaps
    from matplotlib.patches import Patch

    code = file.array("levels/0/code")[::step, ::step]
    palette = colormaps["tab20"].colors
    canvas = np.empty((*code.shape, 3), np.float32)
    canvas[:] = UNKNOWN
    handles = []
    for number, (material, (name, share)) in enumerate(zip(file.materials, file.usage.items())):
        colour = palette[(2 * number) % 20 + number // 10 % 2]
        canvas[code == material] = colour
        handles.append(Patch(facecolor=colour, label=f"{name} ({material}), {100 * share:.1f} %"))
    unknown = max(1 - sum(file.usage.values()), 0.0)
    handles.append(Patch(facecolor=UNKNOWN, label=f"unknown or no data (0), {100 * unknown:.1f} %"))
    axis.imshow(canvas, interpolation="nearest")
    axis.set_title("material codes")
    return handles
