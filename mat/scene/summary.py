"""A summary of a job's atmospheric states, in figures."""

from __future__ import annotations

from typing import Any

import numpy as np

from skyshine.mat.atmosphere.state.climate import blended_profile
from skyshine.mat.atmosphere.state.sea_air import bending_near_water
from skyshine.mat.job.aerosols import AerosolLayer
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.clouds import Cloud
from skyshine.mat.job.model import Job
from skyshine.mat.job.site import Site
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.scene.atmosphere import air_key, air_text, atmospheric_state
from skyshine.schemas.quantity import quantity


def state_summaries(job: Job) -> list[dict[str, Any]]:
    """One dict a state: what it is made of, and its columns above the site's ground with their units."""
    by_air = {air_key(state): state for state in reversed(job.states)}
    summaries = {air: _summary(job.site, state) for air, state in by_air.items()}
    return [summaries[air_key(state)] for state in job.states]


def _summary(site: Site, state: State) -> dict[str, Any]:
    air = atmospheric_state(site, state)
    ground = air.surface_altitude
    at_ground = sum(component.extinction_550[0] for component in air.particles)
    summary: dict[str, Any] = {
        "profile": blended_profile(state.profile_weights).name,
        "sounding": None if state.sounding is None else state.sounding.name,
        "air": air_text(state),
        "air_temperature_at_ground": quantity(float(air.temperature[0]), "K"),
        "relative_humidity_at_ground": quantity(float(air.relative_humidity[0]), "%"),
        "preset": state.preset,
        "aerosol": state.aerosol,
        "aerosol_table": None if state.aerosol_table is None else state.aerosol_table.name,
        "angstrom_exponent": None if state.angstrom_exponent is None else quantity(state.angstrom_exponent, "1"),
        "aerosol_layers": [_aerosol_layer(layer) for layer in state.aerosol_layers],
        "stratosphere": state.stratosphere,
        "water_vapour": quantity(float(air.precipitable_water(ground)), "mm"),
        "ozone": quantity(float(air.ozone_column(ground)), "DU"),
        "aerosol_optical_depth_550": quantity(float(air.aerosol_optical_depth(550.0, ground)), "1"),
        "aerosol_origin": state.aerosol_origin,
        "particle_extinction_at_ground_550": quantity(1e3 * float(at_ground), "km^-1"),
        "clouds": [_cloud(cloud) for cloud in state.clouds],
        "rain": None,
        "sea": None,
    }
    if state.rain is not None:
        rate, top = state.rain.rate_mm_h, state.rain.top_km
        summary["rain"] = {"rate": quantity(rate, "mm/h"), "top": quantity(top, "km")}
    if state.sea_temperature_c is not None:
        bending = bending_near_water(air.altitude, air.pressure, air.temperature)
        summary["sea"] = {
            "temperature": quantity(state.sea_temperature_c, "degC"),
            "curvature_of_rays": quantity(bending.curvature, "1"),
            "curvature_of_lowest_rays": quantity(bending.lowest_curvature, "1"),
            "duct_height": quantity(bending.duct, "m"),
            "horizon_from_10_m": quantity(bending.horizon / 1e3, "km") if np.isfinite(bending.horizon) else None,
        }
    return summary


def _sea_text(sea: dict[str, Any]) -> str:
    """How rays bend over a sea, in words."""
    text = (
        f"sea of {sea['temperature']['value']:g} C: level rays between 0.5 and 10 m have"
        f" {sea['curvature_of_rays']['value']:.2g} of the Earth's curvature"
    )
    if sea["horizon_from_10_m"] is None:
        return f"{text}, duct and superior mirage below {sea['duct_height']['value']:g} m"
    mirage = ", inferior mirage" if sea["curvature_of_lowest_rays"]["value"] < 0 else ""
    return f"{text}, horizon from 10 m at {sea['horizon_from_10_m']['value']:.1f} km{mirage}"


def _aerosol_layer(layer: AerosolLayer) -> dict[str, Any]:
    depth = layer.optical_depth
    return {
        "particles": layer.particles,
        "place": layer.place,
        "optical_depth_550": None if depth is None else quantity(depth, "1"),
    }


def _layer_text(particles: str, location: str, depth: float | None) -> str:
    return f"{particles} {location}" + ("" if depth is None else f", optical depth {depth:.3g}")


def _cloud(cloud: Cloud) -> dict[str, Any]:
    layer = cloud.layer()
    return {
        "phase": layer.phase,
        "height": quantity(np.array([layer.base, layer.top]) / 1e3, "km"),
        "optical_depth_550": quantity(layer.optical_depth, "1"),
        "water_path": quantity(1e3 * layer.water_path, "g m^-2"),
        "effective_radius": quantity(layer.effective_radius, "um"),
    }


def state_attributes(state: State) -> dict[str, str]:
    """Root attributes that name a state in its files: its name or what it is made from (a sounding, its preset, or its
    profile); and what its air near the
    ground follows; optical depth, Angstrom exponent, table and layers of the aerosol, where the job writes them.
    """
    air = {"air": air_text(state)}
    if state.aerosol_table is not None:
        air["aerosol_table"] = state.aerosol_table.name
    if state.aerosol_layers:
        air["aerosol_layers"] = "; ".join(
            _layer_text(layer.particles, layer.place, layer.optical_depth) for layer in state.aerosol_layers
        )
    for name, value in (
        ("aerosol_optical_depth_550", state.optical_depth),
        ("angstrom_exponent", state.angstrom_exponent),
    ):
        if value is not None:
            air[name] = f"{value:g}"
    if state.sea_temperature_c is not None:
        air["sea_temperature"] = f"{state.sea_temperature_c + ZERO_CELSIUS:g}"
    if state.night_sky:
        air["night_sky"] = f"{state.night_sky:g}"
    sounding = {} if state.sounding is None else {"sounding": state.sounding.name}
    made_from = "sounding" if sounding else state.preset or blended_profile(state.profile_weights).name
    if state.name is None:
        return {"state": made_from, **sounding, **air}
    return {"state": state.name, "made_from": made_from, **sounding, **air}


def summary_line(summary: dict[str, Any]) -> str:
    """A summary in one line of text."""
    parts = [summary["profile"] if summary["sounding"] is None else f"{summary['sounding']} below {summary['profile']}"]
    kelvin, humidity = (summary[f"{name}_at_ground"]["value"] for name in ("air_temperature", "relative_humidity"))
    parts.append(f"air at the ground {kelvin:.1f} K, {humidity:.0f} % ({summary['air']})")
    parts.append(f"water vapour {summary['water_vapour']['value']:.3g} mm, ozone {summary['ozone']['value']:.3g} DU")
    parts.append(
        f"aerosol {summary['aerosol']}, optical depth {summary['aerosol_optical_depth_550']['value']:.2g} at 0.55 um"
    )
    if summary["aerosol_origin"] is not None:
        parts[-1] += f" ({summary['aerosol_origin']})"
    if summary["aerosol_table"] is not None:
        parts[-1] += f", optical properties of {summary['aerosol_table']}"
    if summary["angstrom_exponent"] is not None:
        parts[-1] += f", Angstrom exponent {summary['angstrom_exponent']['value']:g}"
    for layer in summary["aerosol_layers"]:
        depth = layer["optical_depth_550"]
        parts.append("aerosol " + _layer_text(layer["particles"], layer["place"], depth and depth["value"]))
    if summary["stratosphere"] != "background":
        parts.append(f"stratosphere {summary['stratosphere']}")
    if summary["sea"] is not None:
        parts.append(_sea_text(summary["sea"]))
    for cloud in summary["clouds"]:
        base, top = cloud["height"]["values"]
        depth, path = cloud["optical_depth_550"]["value"], cloud["water_path"]["value"]
        parts.append(
            f"{cloud['phase']} cloud {base:g} to {top:g} km above ground, optical depth {depth:.3g} ({path:.3g} g/m2)"
        )
    if summary["rain"] is not None:
        parts.append(f"rain {summary['rain']['rate']['value']:g} mm/h below {summary['rain']['top']['value']:g} km")
    return "; ".join(parts)


def summary_text(summaries: list[dict[str, Any]]) -> str:
    """Many summaries in one line: what occurs, and from which to which value."""
    profiles = [summary["sounding"] or summary["profile"] for summary in summaries]
    parts = [_names(profiles)]
    kelvin, humidity, water, ozone, depth = (
        [summary[name]["value"] for summary in summaries]
        for name in (
            "air_temperature_at_ground",
            "relative_humidity_at_ground",
            "water_vapour",
            "ozone",
            "aerosol_optical_depth_550",
        )
    )
    parts.append(f"air at the ground {_span(kelvin, '.1f')} K, {_span(humidity, '.0f')} %")
    parts.append(f"water vapour {_span(water, '.3g')} mm, ozone {_span(ozone, '.3g')} DU")
    parts.append(
        f"aerosol {_names([str(summary['aerosol']) for summary in summaries])}, optical depth"
        f" {_span(depth, '.2g')} at 0.55 um"
    )
    for name, thing in (("clouds", "clouds"), ("rain", "rain"), ("sea", "a sea")):
        if count := sum(bool(summary[name]) for summary in summaries):
            parts.append(f"{count} with {thing}")
    return "; ".join(parts)


def _names(names: list[str]) -> str:
    different = list(dict.fromkeys(names))
    more = f" and {len(different) - 3} more" if len(different) > 3 else ""
    return ", ".join(different[:3]) + more


def _span(values: list[float], form: str) -> str:
    low, high = f"{min(values):{form}}", f"{max(values):{form}}"
    return low if low == high else f"{low} to {high}"
