"""``tmm suggest``: select patches to label (active learning)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import allow_outside_option, emit_json, json_option
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity
from skyshine.tmm.commands.problems import raise_all

if TYPE_CHECKING:
    from pathlib import Path

    from skyshine.tmm.mapping.suggest import Suggestion

SMALL = 0.01  # expected gain of a whole sheet of questions below which they bring little


@click.command(epilog="Example: tmm suggest demo/job.tmm.yaml --count 12")
@click.argument("job", type=click.Path())
@click.option("--out", type=click.Path(), help="Folder of the pictures; by default the output folder of the job.")
@click.option("--count", type=click.IntRange(1, 200), default=12, show_default=True, help="Number of patches to label.")
@click.option("--random", "at_random", is_flag=True, help="Draw a random validation sample.")
@allow_outside_option
@json_option
def command(job: str, out: str | None, count: int, at_random: bool, as_json: bool) -> None:
    """Select patches to label (active learning): for each texture of JOB a picture of numbered patches,
    NAME.suggest.png, the same as a page to fill in, NAME.suggest.html, and the list of answers.

    The list is the one that the job names as `suggested` in `seeds`, else NAME.answers.yaml beside the job. Fill in
    material names, name the list in the job, and run again until the expected gain is small. Answers that are there
    are kept. The job needs seeds, a model, or nothing but `seeds: {suggested: LIST}`.

    With --random the list is NAME.check.yaml, its answers are no seeds, and 'tmm check DATABASE --truth
    NAME.check.yaml' says how many texels of the map are right: seeds lie where things are clear, and what is held out
    of them says too much.
    """
    from pathlib import Path

    from skyshine.materials.library import load_library
    from skyshine.tmm.job.load import load_job
    from skyshine.tmm.mapping.run import output_folder
    from skyshine.tmm.mapping.suggest import draw_at_random, suggest
    from skyshine.tmm.report.questions import write_questions

    library = load_library()
    loaded, folder = load_job(job, library)
    target = output_folder(loaded, folder, out)
    reports, problems = [], []
    for entry in loaded.textures:
        try:
            suggestion = (draw_at_random if at_random else suggest)(entry, folder, library, count)
            files = write_questions(suggestion, Path(target), library.names)
        except InputError as problem:
            problems.append((entry.name, problem))
            continue
        reports.append(_report(suggestion, files))
        if not as_json:
            _print(reports[-1])
    if as_json:
        failed = [{"name": name, "error": str(problem)} for name, problem in problems]
        emit_json({"job": job, "textures": reports, "failed": failed})
    raise_all(problems, len(loaded.textures))


def _report(suggestion: Suggestion, files: tuple[Path, Path]) -> dict[str, Any]:
    return {
        "name": suggestion.job.name,
        "list": str(suggestion.path),
        "named_in_job": suggestion.named,
        "picture": str(files[0]),
        "page": str(files[1]),
        "answered": len(suggestion.answers),
        "expected_wrong": None if suggestion.doubt is None else quantity(suggestion.doubt, "1"),
        "expected_gain": quantity(suggestion.gain, "1"),
        "small": not suggestion.measures and suggestion.gain < SMALL,
        "measures": suggestion.measures,
        "questions": [
            {
                "number": question.answer.number,
                "x": question.answer.x,
                "y": question.answer.y,
                "radius": question.answer.radius,
                "expected_gain": None if question.gain is None else quantity(question.gain, "1"),
                "now": question.now or None,
            }
            for question in suggestion.questions
        ],
    }


def _print(report: dict[str, Any]) -> None:
    if report["measures"]:
        numbers = [question["number"] for question in report["questions"]]
        click.echo(f"{report['name']}: {report['answered']} answers so far; asked at random: {len(numbers)} places")
        click.echo(f"  look at {report['page']} or {report['picture']}")
        click.echo(f"  fill in {report['list']}, then: tmm check DATABASE --truth {report['list']}")
        return
    wrong, gain = report["expected_wrong"], 100 * report["expected_gain"]["value"]
    state = "nothing is known yet" if wrong is None else f"{100 * wrong['value']:.1f} % of the texels expected wrong"
    click.echo(f"{report['name']}: {report['answered']} answers so far, {state}")
    if report["questions"]:
        numbers = [question["number"] for question in report["questions"]]
        click.echo(f"  label patches {numbers[0]} to {numbers[-1]}: expected accuracy gain {gain:.1f} %")
    if report["small"]:
        click.echo("  the expected gain is small: more answers will hardly change the map")
    click.echo(f"  look at {report['page']} or {report['picture']}")
    use = (
        ""
        if report["named_in_job"]
        else f", and add it to the texture's seeds in the job: suggested: {report['name']}.answers.yaml"
    )
    click.echo(f"  fill in {report['list']}{use}")
