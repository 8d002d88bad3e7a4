"""The places that `tmm suggest` asks about: a contact sheet, a page to fill in without other files, and the list."""

from __future__ import annotations

import base64
import io
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.schemas.whole_files import write_whole
from skyshine.tmm.inputs.answers import Answer, to_text
from skyshine.tmm.mapping.suggest import Question, Suggestion
from skyshine.tmm.report.preview import on_screen, thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_SIDE = 1200  # texels of the whole texture that are drawn a side
PATCH = 40  # texels of the survey's grid on each side of a place that its patch shows
ACROSS = 6  # patches beside each other
_TEMPLATE = "questions.html.j2"
_MARK = "#ff2a2a"


def write_questions(suggestion: Suggestion, folder: Path, materials: tuple[str, ...]) -> tuple[Path, Path]:
    """Write picture, page and list; the list last, so that it has no number that no picture shows.

    Raises InputError: a file cannot be written.
    Returns the picture and the page.

    folder : Path; of the pictures; made where it is missing.
    materials : tuple of str; names that the page offers.
    """
    picture, page = (folder / f"{suggestion.job.name}.{suggestion.kind}.{ending}" for ending in ("png", "html"))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror}; check the path", file=folder) from None
    texture = suggestion.texture
    overview = on_screen(*thinned(texture, -(-max(texture.height, texture.width) // MAX_SIDE)))
    write_whole(picture, _sheet(suggestion, overview))
    write_whole(page, _page(suggestion, overview, materials))
    write_whole(suggestion.path, _text(suggestion))
    return picture, page


def _text(suggestion: Suggestion) -> str:
    questions = [question.answer for question in suggestion.questions]
    gains = {question.answer.number: question.gain for question in suggestion.questions if question.gain is not None}
    return to_text([*suggestion.answers, *questions], gains, suggestion.job.name)


def _sheet(suggestion: Suggestion, overview: npt.NDArray[Any]) -> bytes:
    """The whole texture, thinned to colours (h, w, 3), with the numbers of the places, and a patch around each."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    texture, questions = suggestion.texture, suggestion.questions
    rows = -(-max(len(questions), 1) // ACROSS)
    width = 13.0
    tall = float(np.clip((width - 0.5) * texture.height / texture.width, 1.5, 13.0))
    side = width / ACROSS + 0.45
    figure = Figure(figsize=(width, tall + rows * side + 0.8), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=(tall + 0.8, rows * side))
    _draw_whole(suggestion, overview, parts[0].subplots())
    axes = np.atleast_1d(parts[1].subplots(rows, ACROSS, squeeze=False)).ravel()
    for axis in axes:
        axis.set_axis_off()
    for axis, question in zip(axes, questions, strict=False):
        patch, corner = _patch(suggestion, question.answer)
        high, wide = patch.shape[:2]
        left, top = corner
        axis.imshow(patch, extent=(left, left + wide, top + high, top), interpolation="nearest")
        _circle(axis, question.answer, 1.5)
        now = f"\nnow {question.now}" if question.now else ""
        gain = "" if question.gain is None else f":  gain {100 * question.gain:.1f} %"
        axis.set_title(f"{question.answer.number}{gain}{now}", fontsize=9)
    buffer = io.BytesIO()
    FigureCanvasAgg(figure).print_png(buffer, metadata={"Software": "skyshine"})  # type: ignore[no-untyped-call]
    return buffer.getvalue()


def _draw_whole(suggestion: Suggestion, overview: npt.NDArray[Any], axis: Axes) -> None:
    texture = suggestion.texture
    axis.imshow(overview, extent=(0, texture.width, texture.height, 0))
    small = max(texture.height, texture.width) / 60
    for question in suggestion.questions:
        answer = question.answer
        _circle(axis, answer, 1.0)
        left = answer.x > texture.width - 3 * small
        axis.annotate(
            str(answer.number),
            (answer.x + 0.5, answer.y + 0.5),
            xytext=(-6 if left else 6, 0),
            textcoords="offset points",
            ha="right" if left else "left",
            va="center",
            fontsize=9,
            bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": _MARK, "lw": 0.8},
        )
    axis.set_axis_off()
    answered = f"; {len(suggestion.answers)} answered" if suggestion.answers else ""
    title = f"{suggestion.job.name}, {texture.width} x {texture.height}: what is inside each circle?{answered}"
    axis.set_title(title, fontsize=11, pad=8)


def _circle(axis: Axes, answer: Answer, line: float) -> None:
    from matplotlib.patches import Circle

    middle = (answer.x + 0.5, answer.y + 0.5)
    axis.add_patch(Circle(middle, answer.radius + 0.5, fill=False, edgecolor="white", linewidth=line + 1.2))
    axis.add_patch(Circle(middle, answer.radius + 0.5, fill=False, edgecolor=_MARK, linewidth=line))


def _patch(suggestion: Suggestion, answer: Answer) -> tuple[npt.NDArray[Any], tuple[int, int]]:
    """Colours (h, w, 3) around a place, and the column and row where they begin; as large wherever that is possible."""
    texture, half = suggestion.texture, PATCH * suggestion.step
    left, top = (
        max(min(at - half, size - 2 * half - 1), 0)
        for at, size in ((answer.x, texture.width), (answer.y, texture.height))
    )
    rows = slice(top, min(top + 2 * half + 1, texture.height))
    columns = slice(left, min(left + 2 * half + 1, texture.width))
    return on_screen(*texture.window(rows, columns)), (left, top)


def _page(suggestion: Suggestion, overview: npt.NDArray[Any], materials: tuple[str, ...]) -> str:
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    text = resources.files(__package__).joinpath(_TEMPLATE).read_text(encoding="utf-8")
    return environment.from_string(text).render(
        suggestion=suggestion,
        materials=materials,
        whole=_inline(overview),
        questions=[_shown(suggestion, question) for question in suggestion.questions],
        kept=to_text(list(suggestion.answers), {}, suggestion.job.name),
        file=suggestion.path.name,
    )


def _shown(suggestion: Suggestion, question: Question) -> dict[str, Any]:
    """What the page shows of a question; the circle in shares of the patch."""
    answer = question.answer
    colours, (left, top) = _patch(suggestion, answer)
    high, wide = colours.shape[:2]
    return {
        "answer": answer,
        "gain": question.gain,
        "now": question.now,
        "image": _inline(colours),
        "wide": wide,
        "high": high,
        "x": answer.x + 0.5 - left,
        "y": answer.y + 0.5 - top,
        "radius": answer.radius + 0.5,
    }


def _inline(colours: npt.NDArray[Any]) -> str:
    """A picture as a data URI."""
    from matplotlib.image import imsave

    buffer = io.BytesIO()
    imsave(buffer, np.rint(255 * colours).astype(np.uint8), format="png", metadata={"Software": "skyshine"})
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()
