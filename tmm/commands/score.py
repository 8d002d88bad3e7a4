"""``tmm score``: a texture database against a label image."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.tmm.report.score import Checked


RADIANCE_UNITS = "W m^-2 sr^-1"
SHOWN_PAIRS = 10
SHOWN_HOURS = 12


@click.command(epilog="Example: tmm score build/yellowstone_road.tmm.h5 truth.yaml")
@click.argument("file", type=click.Path())
@click.argument("labels", type=click.Path())
@click.option("--htt", type=click.Path(), help="Temperatures: show what wrong texels cost in radiance; needs --band.")
@click.option(
    "--band",
    "bands",
    type=click.Path(),
    multiple=True,
    help="Band properties of the same job; may be given several times.",
)
@click.option(
    "--atmq",
    "airs",
    type=click.Path(),
    multiple=True,
    help="Atmosphere of each --band, for the sky's light that surfaces reflect.",
)
@click.option("--altitude", type=float, help="Of the surface, km; by default the lowest of the temperatures.")
@click.option("--azimuth", type=float, default=0.0, help="Of the surface, degrees from north eastward.")
@click.option("--slope", type=float, default=0.0, help="Of the surface, degrees; 0 is level.")
@json_option
def command(
    file: str,
    labels: str,
    htt: str | None,
    bands: tuple[str, ...],
    airs: tuple[str, ...],
    altitude: float | None,
    azimuth: float,
    slope: float,
    as_json: bool,
) -> None:
    """Compare FILE with the label image that the YAML file LABELS names, or with the answers that it holds.

    A list of answers at places drawn at random ('tmm suggest --random') gives the share of right texels, with its
    interval of 95 % confidence.

    LABELS has the keys `image` and `palette`, as `labels` has in a job. With --htt and --band the wrong texels are
    turned into errors of band radiance and equivalent temperature by time of day.
    """
    from skyshine.materials.library import load_library
    from skyshine.tmm.report import radiance_cost
    from skyshine.tmm.report.score import check_answers, is_list_of_answers, score

    if is_list_of_answers(labels):
        if htt or bands or airs:
            raise click.UsageError("a list of answers has no label image; leave --htt, --band and --atmq out")
        _show_checked(file, check_answers(file, labels, load_library()), as_json)
        return
    surface = {"altitude": altitude, "azimuth": azimuth, "slope": slope}
    tables = radiance_cost.open_tables(htt, bands, airs)
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
    if tables:
        report["radiance_cost"] = [radiance_cost.report(result, htt, band, air, surface) for htt, band, air in tables]
    if as_json:
        emit_json(report)
        return
    _print(report)
    for cost in report.get("radiance_cost", []):
        _show_cost(cost)


def _show_checked(file: str, found: Checked, as_json: bool) -> None:
    if as_json:
        emit_json(
            {
                "file": file,
                "answered": found.answered,
                "skipped": found.skipped,
                "overall_accuracy": quantity(found.accuracy, "1"),
                "interval_95": [quantity(found.low, "1"), quantity(found.high, "1")],
                "stated_confidence": quantity(found.stated, "1"),
                "wrong": [{"seen": seen, "found": other, "places": n} for (seen, other), n in found.wrong.items()],
            }
        )
        return
    click.echo(
        f"{found.right} of {found.answered} places are right: accuracy {found.accuracy:.3f}, with 95 % confidence "
        f"{found.low:.3f} to {found.high:.3f}; the database states {found.stated:.3f}"
    )
    if found.skipped:
        click.echo(f"{found.skipped} places are not answered; where they are harder than others, this says too much")
    if found.wrong:
        echo_table(("seen", "found", "places"), [[*pair, str(n)] for pair, n in found.wrong.items()])


def _print(report: dict[str, Any]) -> None:
    figures = [f"{report[key]['value']:.3f}" for key in ("overall_accuracy", "mean_iou", "calibration_error")]
    echo_table(("texels", "accuracy", "mean IoU", "calibration error"), [[str(report["texels"]), *figures]])
    rows = [
        [entry["name"], f"{entry['intersection_over_union']['value']:.3f}", *map(str, entry["found_unknown_then_each"])]
        for entry in report["materials"]
    ]
    names = [entry["name"] for entry in report["materials"]]
    echo_table(("labelled", "IoU", "unknown", *names), rows)


def _show_cost(cost: dict[str, Any]) -> None:
    """Print a report as tables."""
    sky = "with" if cost["reflected_sky"] else "without"
    click.echo(f"cost of wrong texels in {cost['band']}, {sky} reflected light of the sky ({cost['texels']} texels)")
    rows = []
    for label, where in [("day", None), *_hours(cost)]:
        row = [label]
        for key in ("radiance", "equivalent_temperature"):
            errors = cost[key]["day"] if where is None else cost[key]["by_time"]
            row += [
                f"{errors[name]['value'] if where is None else errors[name]['values'][where]:.3g}"
                for name in ("rms", "p95", "maximum")
            ]
        rows.append(row)
    units = f"{RADIANCE_UNITS}: rms", "p95", "max", "K: rms", "p95", "max"
    echo_table(("time", *units), rows)
    rows = [
        [
            pair["true"],
            pair["found"],
            str(pair["texels"]),
            f"{pair['temperature_rms']['value']:.2f}",
            f"{pair['temperature_maximum']['value']:+.2f}",
            f"{pair['time_of_maximum']['value']:.1f}",
            f"{100 * pair['contribution']['value']:.1f}",
        ]
        for pair in cost["pairs"][:SHOWN_PAIRS]
    ]
    echo_table(("true", "found", "texels", "K rms", "K worst", "at h", "% of squared error"), rows)


def _hours(cost: dict[str, Any]) -> list[tuple[str, int]]:
    times = cost["time"]["values"]
    return [(f"{times[k]:g} h", k) for k in range(0, len(times), max(len(times) // SHOWN_HOURS, 1))]
