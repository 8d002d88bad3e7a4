"""What `mat spectrum --compare-continua` prints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from skyshine.schemas.commands import emit_json
from skyshine.schemas.quantity import quantity


def print_comparison(arguments: Mapping[str, Any], *, as_json: bool) -> None:
    """Print a line of sight with every water vapour continuum: CSV, or JSON.

    Parameters
    ----------
    arguments : mapping
        Arguments of `skyshine.mat.spectrum`; its `water_continuum` is ignored.
    """
    from skyshine.mat.api.continua import compare_continua

    effects = compare_continua(**{name: value for name, value in arguments.items() if name != "water_continuum"})
    if as_json:
        emit_json(
            {
                effect.name: {
                    "transmittance": quantity(effect.transmittance, "1"),
                    "temperature": quantity(effect.temperature, "K"),
                    "difference": quantity(effect.difference, "K"),
                }
                for effect in effects
            }
        )
        return
    click.echo("water_continuum,transmittance[1],apparent_temperature[K],difference[K]")
    for effect in effects:
        click.echo(f"{effect.name},{effect.transmittance:.4f},{effect.temperature:.3f},{effect.difference:+.3f}")
