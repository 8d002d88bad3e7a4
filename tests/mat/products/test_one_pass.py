"""How often the light of an air is solved and lines are traced for its tables: nothing twice, whatever the sources."""

from collections import Counter

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer import geometry
from skyshine.mat.atmosphere.transfer.ordinate_light import OrdinateLight
from skyshine.mat.atmosphere.transfer.thermal_source import ThermalField
from skyshine.mat.measure.scale import Scale
from skyshine.mat.products.channel_tables import ChannelTables
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.nodes import NodeCounts
from skyshine.mat.quantities.channels.wavelength_shares import PartedLight
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.band_wavelengths import band_wavelengths
from skyshine.mat.radiometry.blackbody import SpectralResponse

RESPONSE = SpectralResponse.rectangular(3.995, 4.005)
BASE = PathGrid([0.01, 1.0, 100.0], [0.002, 1.0, 5.0], [-90.0, -2.0, 0.0, 90.0], [0.0, 20.0, 70.0], [0.0, 180.0])
_FAINT = 1e-6  # of sunlight, about a moon


@pytest.fixture
def counted(monkeypatch):
    """Solves of fields by kind, and rays traced."""
    counts: Counter[str] = Counter()

    def counting(owner, name, key, size):
        whole = getattr(owner, name)

        def function(*arguments, **settings):
            counts[key] += size(arguments)
            return whole(*arguments, **settings)

        monkeypatch.setattr(owner, name, function)

    counting(OrdinateLight, "of", "scattered", lambda arguments: 1)
    counting(ThermalField, "of", "thermal", lambda arguments: 1)
    counting(geometry, "_portions", "rays", lambda arguments: np.size(arguments[1]))
    return counts


def taken(counts):
    """What has been counted since the last call."""
    result = dict(counts)
    counts.clear()
    return result


def test_fields_are_solved_once_and_a_second_source_traces_few_lines(counted):
    band = points_of_band(AbsorptionTable.open(), RESPONSE)
    air, scale = BandAtmosphere.of(AtmosphericState.from_profile("midlatitude_summer"), band), Scale.kelvin(RESPONSE)
    sunlight = solar_irradiance(band.wavenumber)

    def every(light):
        return air.air, PartedLight.of(band.wavenumber, band.radiance_weight, light)

    sun = ChannelTables(air, BASE, sunlight, scale, 0.5, 6, 1, every(sunlight), band_wavelengths(RESPONSE))
    nodes = sun.nodes(NodeCounts(6, 6, 4, 4, 4))
    lines = nodes.height_root.size * nodes.direction.size
    table = sun.table(nodes)
    first = taken(counted)
    assert first["scattered"] == 1 and first["thermal"] == 1
    moon = sun.under(air, _FAINT * sunlight, scale, every(_FAINT * sunlight))
    dark = moon.table(nodes)
    second = taken(counted)
    assert "scattered" not in second and "thermal" not in second
    assert second["rays"] < first["rays"] - lines  # and none of those that only the first source needs
    assert sun.table(nodes).root.variables.keys() == table.root.variables.keys()
    again = taken(counted)
    assert again == {"rays": lines}
    same = ("log_mean_extinction", "thermal_ratio", "end_rise")
    for name in same:
        if name in table.root.variables:
            assert np.array_equal(table.root.variables[name].data, dark.root.variables[name].data)
