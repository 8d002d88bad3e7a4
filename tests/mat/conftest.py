"""Fixtures of synthetic air."""

import numpy as np
import pytest


class SyntheticPoints:
    """Spectral points with cross sections that do not depend on pressure or temperature."""

    def __init__(self, edges, sections, weight=None, interval=None):
        self.interval_edges = np.stack([edges[:-1], edges[1:]], axis=1).astype(float)
        count = len(next(iter(sections.values())))
        self.interval = np.arange(count) * (len(edges) - 1) // count if interval is None else interval
        width = np.diff(self.interval_edges, axis=1)[:, 0]
        share = np.bincount(self.interval, minlength=len(width))
        self.weight = (width / np.maximum(share, 1))[self.interval] if weight is None else weight
        self.wavenumber = self.interval_edges.mean(axis=1)[self.interval]
        self.sections = {gas: np.asarray(values, float) for gas, values in sections.items()}
        self.gases = self.absorbing = list(sections)
        self.edges = edges

    def subset(self, index, weight=None):
        sections = {gas: values[index] for gas, values in self.sections.items()}
        weight = self.weight[index] if weight is None else weight
        return SyntheticPoints(self.edges, sections, weight, self.interval[index])

    def cross_sections(self, pressure, temperature, h2o_mole_fraction, gases=None):
        wanted = self.gases if gases is None else gases
        return {gas: np.broadcast_to(self.sections[gas], (len(pressure), self.interval.size)) for gas in wanted}


@pytest.fixture(scope="session")
def synthetic_points():
    """Factory of spectral points: ``synthetic_points(edges, {"CO2": (P,) m2 per molecule})``."""
    return SyntheticPoints


@pytest.fixture(scope="session")
def isothermal():
    """Factory of an isothermal state without water: ``isothermal(temperature, aerosol=Aerosol("none"))``."""
    from dataclasses import replace

    from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
    from skyshine.mat.atmosphere.state.state import AtmosphericState

    def make(temperature=280.0, **settings):
        state = AtmosphericState.from_profile("us_standard", **{"aerosol": Aerosol("none"), **settings})
        return replace(state, temperature=np.full_like(state.temperature, temperature))

    return make
