"""``mat materials specular``: shininess and N_s of a specular lobe."""

from __future__ import annotations

import click

from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.quantity import quantity


@click.command("specular", epilog="Example: mat materials specular --fwhm 30")
@click.option("--fwhm", type=float, required=True, help="Full width of the lobe at half maximum, degree (0.1 to 180).")
@json_option
def specular(fwhm: float, as_json: bool) -> None:
    """Print shininess and normalisation N_s of a specular lobe.

    N_s is the mean over source angles of 0 to 75 degrees from the normal; the spread is that of the single angles
    about it.
    """
    import numpy as np

    from skyshine.mat.radiometry.lobe import SOURCE_ANGLES, normalisation, shininess

    by_angle = normalisation(fwhm)
    mean = by_angle.mean()
    spread = 100.0 * (np.array([by_angle.min(), by_angle.max()]) / mean - 1.0)
    exponent = float(shininess(fwhm))
    if as_json:
        emit_json(
            {
                "fwhm": quantity(fwhm, "degree"),
                "shininess": quantity(exponent, "1"),
                "n_s": quantity(mean, "1"),
                "spread_percent": quantity(spread, "percent"),
                "source_angle": quantity(SOURCE_ANGLES, "degree"),
                "n_s_by_source_angle": quantity(by_angle, "1"),
            }
        )
        return
    click.echo(f"lobe width (FWHM)  {fwhm:g} degree")
    click.echo(f"shininess          {exponent:.6g}")
    click.echo(f"N_s                {mean:.6g}  ({spread[0]:+.2f} % to {spread[1]:+.2f} %)")
    click.echo("source angle       N_s")
    for angle, value in zip(SOURCE_ANGLES, by_angle, strict=True):
        click.echo(f"{angle:6.0f} degree      {value:.6g}")
