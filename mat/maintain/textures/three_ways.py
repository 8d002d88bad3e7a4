"""The picture of the three ways to label training areas, on the photograph of an example; `pictures` draws it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon
from matplotlib.patheffects import withStroke

from skyshine.materials.colours import material_colours
from skyshine.materials.library import load_library
from skyshine.tmm.images.raster import read_channels
from skyshine.tmm.inputs.load import load_texture
from skyshine.tmm.job.load import load_job
from skyshine.tmm.mapping.suggest import suggest

QUESTIONS = 8  # patches to label
UNPAINTED = 0.35  # brightness of the photograph where nothing is painted
TITLES = (  # titles of the panels, from the top
    "answer what is asked: tmm suggest, seeds: {suggested: LIST}",
    "paint a label image: seeds: {labels: {image, palette}}",
    "draw polygons, in pixels or on the map: seeds: {polygons} or {file: GeoJSON}",
)


def draw(out: Path, job: Path) -> None:
    """Draw the picture of the first texture of a job, whose seeds are polygons."""
    library = load_library()
    loaded, folder = load_job(job, library)
    entry = loaded.textures[0]
    _, _, _, seeds = load_texture(entry, folder, library)
    if seeds is None or entry.seeds is None:
        raise ValueError(f"{job} has no seeds")
    photograph = read_channels(folder / entry.image)[..., :3] / 255
    colours = dict(zip(seeds.names, material_colours(seeds.names, library) / 255, strict=True))
    painted = photograph * UNPAINTED
    painted[seeds.rows, seeds.columns] = np.array([colours[name] for name in seeds.names])[seeds.material]
    figure = Figure(figsize=(8, 15), dpi=72, layout="constrained")
    axes = figure.subplots(3, 1)
    for axis, title, picture in zip(axes, TITLES, (photograph, painted, photograph), strict=True):
        axis.imshow(picture)
        axis.set_axis_off()
        axis.set_title(title, fontsize=11)
    for question in suggest(entry, folder, library, QUESTIONS).questions:
        circle = {"boxstyle": "circle", "facecolor": "white", "edgecolor": "black"}
        answer = question.answer
        axes[0].text(answer.x, answer.y, str(answer.number), ha="center", va="center", bbox=circle)
    halo = [withStroke(linewidth=5, foreground="white")]
    for name, polygons in entry.seeds.polygons.items():
        for polygon in polygons:
            axes[2].add_patch(
                Polygon(np.array(polygon), facecolor="none", edgecolor=colours[name], linewidth=2, path_effects=halo)
            )
    legend = [Patch(facecolor=colour, label=name) for name, colour in colours.items()]
    figure.legend(handles=legend, loc="outside lower center", ncols=len(legend), frameon=False)
    FigureCanvasAgg(figure).print_png(str(out), metadata={"Software": "skyshine"})  # type: ignore[no-untyped-call]
