"""Ambient light on tilted faces: harmonics against the integral over each face's own hemisphere.

python -m pytest -m validation -s tests/validation/test_tilted_faces.py

Kelvin: change of a black body at 300 K, at the face, which reflects 0.3. The exact integral takes 32 zenith angles of a
hemisphere and 24 azimuths of half a turn from the solver of path radiance, without harmonics.
"""

import numpy as np
import pytest
from face_light import facet_irradiance

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.job.load import load_job
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities import facet_light
from skyshine.mat.quantities.ambient_harmonics import GROUND_TEMPERATURES, ambient_harmonics
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.spherical_harmonics import COUNTS, ambient_of_faces
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import compiled_band
from skyshine.mat.scene.sources import source_irradiance

pytestmark = pytest.mark.validation
JOB = """\
skyshine: 1
name: faces
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - {profile: midlatitude_summer, visibility_km: 23, weather: {air_temperature_c: [22, 33]}}
  - {profile: tropical, aerosol: desert, surface_albedo: 0.3, weather: {air_temperature_c: 35, wind_speed_m_s: 8}}
  - {profile: us_standard, visibility_km: 8, weather: {air_temperature_c: 15}}
bands:
  - wavelength_um: [3, 5]
  - wavelength_um: [8, 12]
sources: [sun]
materials: [asphalt_road]
"""
FACES, SUNS, GROUND_K = 200, np.array([10.0, 30.0, 60.0]), 330.0
LIMITS = dict(zip(COUNTS, (0.15, 0.05), strict=True))


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    file = tmp_path_factory.mktemp("faces") / "job.yaml"
    file.write_text(JOB, encoding="utf-8")
    return load_job(file)


@pytest.mark.parametrize("band", [1, 2])
@pytest.mark.parametrize("state", [1, 2, 3])
def test_harmonics_hold_their_kelvin(loaded, state, band, monkeypatch):
    monkeypatch.setattr(facet_light, "ZENITHS", 32)
    monkeypatch.setattr(facet_light, "AZIMUTHS", 24)
    job = loaded.trimmed
    air, response = atmospheric_state(job.site, job.states[state - 1]), response_of(job.bands[band - 1])
    everything = points_of_band(absorption_table(), response)
    atmosphere = BandAtmosphere.of(air, compiled_band(loaded, job.states[state - 1], response, air, everything)[0].band)
    points = atmosphere.band
    sunlight = source_irradiance(job, "sun", points.wavenumber, points.width)
    grid = PathGrid([0.0], [0.0], [0.0], SUNS, [0.0])
    level = atmosphere.table(grid, sunlight, quantities=("ambient",)).ambient[0, 0, 0]
    normal = np.random.default_rng(state).normal(size=(FACES, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normals, ground = np.broadcast_to(normal, (SUNS.size, FACES, 3)), np.full(SUNS.size, GROUND_K)
    light = facet_irradiance(atmosphere.air, np.zeros(SUNS.size), np.radians(SUNS), normals, sunlight, ground)
    exact = light @ points.radiance_weight / np.pi
    emitted = (1 - air.surface_albedo) * planck_wavenumber(points.wavenumber, GROUND_K) @ points.radiance_weight
    scale = Scale.kelvin(response)

    def kelvin(radiance):
        return np.abs(scale.error("ambient_radiance", radiance, exact, np.ones(1), np.zeros(1)))

    text = (
        f"\n{air.name} {response.lower:g}-{response.upper:g} um: level sky for all {kelvin(level[:, None]).max():.1f} K"
    )
    errors = {}
    for count in COUNTS:
        tables = ambient_harmonics(atmosphere, grid, sunlight, count)
        place = [np.interp(GROUND_K, GROUND_TEMPERATURES, part) for part in tables.ground[0, 0, 0].T]
        radiance = tables.radiance[0, 0, 0][:, None]
        errors[count] = kelvin(ambient_of_faces(level[:, None], radiance, np.array(place), np.float64(emitted), normal))
        worst, rms = errors[count].max(axis=1), np.sqrt(np.mean(errors[count] ** 2))
        text += f"; {count} numbers: rms {rms:.3f}, largest by Sun {' '.join(f'{k:.3f}' for k in worst)}"
    print(text)
    for count, error in errors.items():
        assert error.max() <= LIMITS[count]
