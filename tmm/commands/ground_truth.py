"""What `tmm check DATABASE --truth LABELS` prints: a texture database against ground truth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import echo_table, emit_json
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.tmm.report.score import Checked


def compare_with_truth(file: str, labels: str, as_json: bool) -> None:
    """Print accuracy and confusion of a database, by a label image or by a list of answers."""
    from skyshine.materials.library import load_library
    from skyshine.tmm.report.score import check_answers, is_list_of_answers, score

    if is_list_of_answers(labels):
        _show_checked(file, check_answers(file, labels, load_library()), as_json)
        return
    result = score(file, labels, load_library())
    quality = result.quality
    report: dict[str, Any] = {
        "file": file,
        "texels": quality.tested,
        "overall_accuracy": quantity(quality.overall_accuracy, "1"),
        "mean_iou": quantity(quality.mean_iou, "1"),
        "calibration_error": quantity(quality.calibration_error, "1"),
        "materials": [
            {"name": name, "intersection_over_union": quantity(iou, "1"), "found_unknown_then_each": row.tolist()}
            for name, iou, row in zip(result.names, quality.intersection_over_union, quality.confusion, strict=True)
        ],
    }
    if as_json:
        emit_json(report)
        return
    _print(report)


def _show_checked(file: str, checked: Checked, as_json: bool) -> None:
    if as_json:
        emit_json(
            {
                "file": file,
                "answered": checked.answered,
                "skipped": checked.skipped,
                "overall_accuracy": quantity(checked.accuracy, "1"),
                "interval_95": [quantity(checked.low, "1"), quantity(checked.high, "1")],
                "stated_confidence": quantity(checked.stated, "1"),
                "wrong": [
                    {"seen": true, "found": assigned, "places": n} for (true, assigned), n in checked.wrong.items()
                ],
            }
        )
        return
    click.echo(
        f"{checked.right} of {checked.answered} places are right: accuracy {checked.accuracy:.3f}, with 95 % "
        f"confidence {checked.low:.3f} to {checked.high:.3f}; the database states {checked.stated:.3f}"
    )
    if checked.skipped:
        click.echo(f"{checked.skipped} places are not answered; where they are harder than others, this says too much")
    if checked.wrong:
        echo_table(("seen", "found", "places"), [[*pair, str(n)] for pair, n in checked.wrong.items()])


def _print(report: dict[str, Any]) -> None:
    figures = [f"{report[key]['value']:.3f}" for key in ("overall_accuracy", "mean_iou", "calibration_error")]
    echo_table(("texels", "accuracy", "mean IoU", "calibration error"), [[str(report["texels"]), *figures]])
    rows = [
        [entry["name"], f"{entry['intersection_over_union']['value']:.3f}", *map(str, entry["found_unknown_then_each"])]
        for entry in report["materials"]
    ]
    names = [entry["name"] for entry in report["materials"]]
    echo_table(("labelled", "IoU", "unknown", *names), rows)
