"""Errors of the tables on default nodes, in the air for which they were chosen and in sub-arctic air: 99 % of reads are
within 1 K, below 2.5 um within 6 % of the light.
"""

import numpy as np
import pytest
import yaml

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.job.load import load_job
from skyshine.mat.measure.probes import Probes
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import compiled_band
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.ground import over_ground
from skyshine.mat.scene.sources import source_irradiance
from skyshine.mat.tables.gridded import QUANTITIES, Gridded
from skyshine.materials.library import load_library

pytestmark = pytest.mark.validation
AIRS = {
    "starter": (2.1, {"profile": "midlatitude_summer", "visibility_km": 23, "weather": {"air_temperature_c": [6, 25]}}),
    "desert": (
        0.2,
        {
            "profile": "midlatitude_summer",
            "aerosol": "desert",
            "humidity_scale": 0.4,
            "surface_albedo": 0.3,
            "weather": {"air_temperature_c": [19, 38], "relative_humidity_percent": 15},
        },
    ),
    "subarctic": (
        0.1,
        {
            "profile": "subarctic_winter",
            "visibility_km": 40,
            "surface_albedo": 0.5,
            "weather": {"air_temperature_c": [-22, -14]},
        },
    ),
    "tropical sea": (
        0.0,
        {
            "profile": "tropical",
            "aerosol": "maritime",
            "visibility_km": 15,
            "weather": {"air_temperature_c": [25, 31], "relative_humidity_percent": 80},
        },
    ),
}
# Below 2.5 um 3 % of the light count as 1 K; path radiance around the source is worse in a fiftieth of all reads.
CASES = [(air, band, 1.0) for air in AIRS for band in ((3, 5), (8, 12))]
CASES += [(air, band, 2.0) for air in AIRS for band in ((0.9, 1.7), (0.4, 0.7))]


@pytest.mark.parametrize("air, band, allowed", CASES)
def test_99_percent_of_reads_are_within_a_kelvin(air, band, allowed, tmp_path):
    height, state = AIRS[air]
    site = {"latitude_deg": 45, "longitude_deg": 0, "date": "2026-07-01", "utc_offset_h": 0, "altitude_km": height}
    job = {"skyshine": 1, "name": air, "site": site, "states": [state], "bands": [{"wavelength_um": list(band)}]}
    job |= {"materials": ["asphalt_road"], "sources": ["sun"]}
    (tmp_path / "job.yaml").write_text(yaml.safe_dump(job), encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    written, response = loaded.trimmed.states[0], response_of(loaded.trimmed.bands[0])
    whole = over_ground(atmospheric_state(loaded.trimmed.site, written), written, response, load_library())
    everything = band_points(absorption_table().points(*response.wavenumber_range), response)
    compiled, _ = compiled_band(loaded, written, response, whole, everything)
    sun = source_irradiance(loaded.trimmed, "sun", compiled.band.wavenumber, compiled.band.width)
    air_of_band = BandAtmosphere.of(whole, compiled.band)
    scale = Scale.of_unit("K", response, float(compiled.band.radiance_weight @ sun))
    probes = Probes.drawn(air_of_band, path_grid(loaded.trimmed), sun, np.random.default_rng(2026))
    tables = {}
    for name, (key, _) in QUANTITIES.items():
        grid = path_grid(loaded.trimmed, name)
        tables |= Gridded.all_of(air_of_band.table(grid, sun, wanted=(key,)), grid)
    worst = {name: float(np.percentile(np.abs(error), 99)) for name, error in probes.errors(tables, scale).items()}
    largest = {name: float(np.max(np.abs(error))) for name, error in probes.errors(tables, scale).items()}
    print(f"\n{air} {band}: " + ", ".join(f"{name} {worst[name]:.2f} / {largest[name]:.1f}" for name in worst))
    assert set(worst) == set(QUANTITIES) and max(worst.values()) <= allowed
