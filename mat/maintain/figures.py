"""Figures that pages quote, in one file, so that two pages cannot disagree.

Run ``python -m mat.maintain.figures FOLDER`` after a fresh build of the starter job in FOLDER. It writes
``examples/manual/figures.json`` from ``build.json`` of that folder and from the results of the validations, and every
figure of every page again: a page quotes one as ``0.80<!-- figure texture.asked_6.mean_iou -->``, and tables of the
starter's files and of ways to classify textures are between marks. Without FOLDER the starter's figures stay. A test
compares pages with the file.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import skyshine.mat

CHECKOUT = Path(__file__).parents[2]
FIGURES = CHECKOUT / "examples" / "manual" / "figures.json"
VALIDATION = CHECKOUT / "tests" / "validation"
QUOTE = re.compile(r"(-?[\d.,]*\d)(<!-- figure ([\w.]+) -->)")
BLOCK = re.compile(r"(<!-- figures.json: (\w+) begin -->\n).*?(<!-- figures.json: end -->)", re.DOTALL)
# Files of the starter job in the README: what they contain, and of the errors which.
FILES = {
    "s01.htt.h5": (
        "surface temperature by material, altitude, azimuth, slope, time; response to shade",
        "K",
    ),
    "s01b01.atmq.h5": ("transmittance, path radiance, light of sky and Sun on any face; 3 to 5 µm", "K"),
    "s01b02.atmq.h5": ("the same in 8 to 12 µm; the Moon's files are made with the Sun's", "K"),
    "b02.band.h5": ("black-body radiance, reflectance, emissivity, specular lobe of each material", ""),
    "yellowstone_road.tmm.h5": ("material, mixture, confidence and cast shade of each texel", ""),
}
WAYS = {  # ways of classifying textures: words of the table, way in the file of results
    "random": ("seeds alone, at random", "default, random"),
    "fast": ("the same, `speed: fast`", "speed fast, random"),
    "qda": ("scikit-learn's QDA on the colours of the same clicks", "scikit-learn QDA, random"),
    "forest": ("scikit-learn's forest", "scikit-learn forest, random"),
    "model": ("with a model, at random", "default with model, random"),
    "from_nothing": ("seeds alone, asked from nothing", "default, asked from nothing"),
    "fast_from_nothing": ("the same, `speed: fast`", "speed fast, asked from nothing"),
    "qda_from_nothing": ("QDA on the same answers", "scikit-learn QDA, asked from nothing"),
    "asked": ("with a model, asked by it", "default with model, asked by a model"),
}
SHADOWS = {"hour": (13.0, 14.0), "day": (0.0, 24.0)}  # local clock, of asphalt at 14:00
CLICKS = (1, 2, 6)  # a class; with one or two that are asked from nothing most sheets have answers of one class alone
Figures = dict[str, dict[str, str]]


def of_validations() -> Figures:
    """Figures of the files that validations wrote, by name."""
    figures: Figures = {}
    for run in json.loads((VALIDATION / "report_results.json").read_text(encoding="utf-8")):
        name = f"pixel.{run['example']}_{run['band']}_{run['source']}"
        for row, short in (("all", "runtime"), ("pixel", "exact")):
            for measure in ("rms", "maximum"):
                value = run["errors"][row][measure]
                source = "tests/validation/report_results.py"
                figures[f"{name}.{short}_{measure}"] = {"value": f"{value:.2g}", "unit": "K", "source": source}
    textures = json.loads((VALIDATION / "texture_results.json").read_text(encoding="utf-8"))
    for short, (_, way) in WAYS.items():
        for clicks in CLICKS[2:] if short.endswith("from_nothing") else CLICKS:
            for measure in ("mean_iou", "accuracy"):
                source = "tests/validation/test_texture_suggest.py"
                value = f"{textures[f'{way}, {clicks}'][measure]:.2f}"
                figures[f"texture.{short}_{clicks}.{measure}"] = {"value": value, "unit": "1", "source": source}
    quoted: Figures = json.loads((VALIDATION / "quoted_results.json").read_text(encoding="utf-8"))
    return figures | quoted


def of_build(folder: Path) -> Figures:
    """Stated error, seconds and size of each file of a build of the starter job.

    Parameters
    ----------
    folder : Path
        Folder of the databases with their ``build.json``.
    """
    record = json.loads((folder / "build.json").read_text(encoding="utf-8"))
    figures: Figures = {}
    for name in FILES:
        entry: dict[str, Any] = record["files"][name]
        if entry["kept"]:
            raise SystemExit(f"{folder}: {name} was kept from an earlier build; build it with --fresh")
        values = {"processor_s": (f"{entry['processor_seconds']:.1f}", "s")}
        values["megabytes"] = (f"{(folder / name).stat().st_size / 1e6:.1f}", "MB")
        if FILES[name][1]:
            values["p99"] = (f"{entry['error_kelvin']['p99']:.2g}", "K")
        for measure, (value, unit) in values.items():
            source = "mat build of examples/starter"
            figures[f"starter.{name.removesuffix('.h5')}.{measure}"] = {"value": value, "unit": unit, "source": source}
    return figures | of_shadows(folder)


def of_shadows(folder: Path) -> Figures:
    """By how much a shadow that has lain for an hour, and one that lies all day, cool the starter's road at 14:00."""
    surface = skyshine.mat.open(folder / "s01.htt.h5")
    assert isinstance(surface, skyshine.mat.TemperatureTable)
    road: dict[str, Any] = {"material": "asphalt_road", "altitude": 2.1, "azimuth": 0, "slope": 0}
    figures: Figures = {}
    for name, hours in SHADOWS.items():
        heat = surface.absorbed_change(**road, shade=[hours])
        change = surface.temperature(**road, time=14.0, absorbed_change=heat) - surface.temperature(**road, time=14.0)
        source = "temperatures of examples/starter"
        figures[f"starter.shadow.{name}"] = {"value": f"{-float(change):.0f}", "unit": "K", "source": source}
    return figures


def starter_table(figures: Figures) -> str:
    """A row for each file of the starter job."""
    lines = ["| file | content | stated error, 99 % | seconds of a processor |", "|---|---|---|---|"]
    for name, (what, _) in FILES.items():
        own = {
            key.rpartition(".")[2]: entry for key, entry in figures.items() if f".{name.removesuffix('.h5')}." in key
        }
        error = f"{own['p99']['value']} K" if "p99" in own else ""
        lines.append(f"| `{name}` | {what} | {error} | {own['processor_s']['value']} |")
    return "\n".join(lines)


def texture_table(figures: Figures) -> str:
    """A row for each way to classify textures: mean IoU and accuracy with one, two and six clicks a class."""
    lines = ["| way | one click a class | two | six |", "|---|---|---|---|"]
    for short, (words, _) in WAYS.items():
        cells = []
        for name in (f"texture.{short}_{clicks}." for clicks in CLICKS):
            pair = [
                figures[name + measure]["value"] for measure in ("mean_iou", "accuracy") if name + measure in figures
            ]
            cells.append(" / ".join(pair))
        lines.append(f"| {words} | {' | '.join(cells)} |")
    return "\n".join(lines)


TABLES = {"starter": starter_table, "textures": texture_table}


def with_figures(text: str, figures: Figures) -> str:
    """A page with its quoted figures, and its tables between marks, as the file has them.

    Raises
    ------
    KeyError
        The page quotes a figure that the file lacks.
    """
    text = BLOCK.sub(lambda match: f"{match[1]}\n{TABLES[match[2]](figures)}\n\n{match[3]}", text)
    return QUOTE.sub(lambda match: figures[match[3]]["value"] + match[2], text)


def pages() -> Iterator[Path]:
    """Markdown pages of the checkout."""
    for folder in ("mat", "tmm", "materials", "atmospheres", "schemas", "examples"):
        yield from sorted((CHECKOUT / folder).rglob("*.md"))
    yield from sorted(CHECKOUT.glob("*.md"))


def main(folder: Path | None) -> None:
    """Write the file of figures and the pages that quote it."""
    kept = json.loads(FIGURES.read_text(encoding="utf-8")) if FIGURES.is_file() else {}
    starter = of_build(folder) if folder else {name: kept[name] for name in kept if name.startswith("starter.")}
    figures = dict(sorted((starter | of_validations()).items()))
    FIGURES.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    for page in pages():
        text = page.read_text(encoding="utf-8")
        if (changed := with_figures(text, figures)) != text:
            page.write_text(changed, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
