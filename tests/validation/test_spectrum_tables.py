"""`mat spectrum` against the atmospheric tables of the same job: one state, one light.

Spectra of single lines are integrated over the response as ``equations.md`` defines the tables' quantities: in-band
transmittance, (10) path radiance, (20) ambient at the range 0, where no transmittance weighs the sky, and (36) direct
there. Both sides have all points of the band; what the compiled points and the nodes of a file err by, the file states.
"""

import numpy as np
import pytest

from skyshine.mat.api.spectrum import spectrum
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.ground import over_ground
from skyshine.mat.scene.sources import source_irradiance
from skyshine.materials.library import load_library

pytestmark = pytest.mark.validation

# cm^-1; the limits are those of intervals of the band model.
BANDS = {"8-12 um": (835.0, 1250.0), "3-5 um": (2000.0, 3335.0), ".4-.7 um": (14300.0, 25000.0)}
RANGES, ALTITUDES, ELEVATIONS = [0.0, 5.0, 50.0], [0.01, 1.0, 5.0], [-60.0, -8.0, 3.0]  # km, km, degree
SOURCES, AZIMUTHS = [8.0, 50.0], [0.0, 90.0, 180.0]  # degree
# Range, altitude, elevation of the line, elevation and azimuth of the Sun from it.
LINES = [
    (5.0, 0.01, 3.0, 50.0, 0.0),
    (50.0, 1.0, 3.0, 8.0, 180.0),
    (5.0, 5.0, -8.0, 50.0, 180.0),
    (5.0, 5.0, -60.0, 8.0, 90.0),
]
TOLERANCE = 2e-3


def job_of(band):
    return {
        "skyshine": 1,
        "name": "lines",
        "site": {"latitude_deg": 29.7, "longitude_deg": -82.0, "date": "2026-06-28", "utc_offset_h": -5},
        "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [22, 33]}}],
        "bands": [{"wavenumber_cm": list(BANDS[band])}],
        "sources": ["sun"],
        "materials": ["asphalt_road"],
        "accuracy": {"negligible_k": 0},
        "atmosphere_grid": {
            "range_km": RANGES,
            "altitude_km": ALTITUDES,
            "elevation_deg": ELEVATIONS,
            "source_elevation_deg": SOURCES,
            "source_azimuth_deg": AZIMUTHS,
        },
        "output": {"pictures": False},
    }


def of_spectra(job, line):
    """In-band quantities of `mat spectrum`, by name."""
    distance, altitude, elevation, source, azimuth = line

    def seen(reach):
        return spectrum(
            job=job,
            wavenumber=tuple(job["bands"][0]["wavenumber_cm"]),
            altitude=altitude,
            elevation=elevation,
            range=reach,
            source_elevation=source,
            source_azimuth=azimuth,
        )

    path, surface = seen(distance), seen(0.0)
    edges = np.append(path.wavenumber[:-1] + path.wavenumber[1:], 0) / 2
    edges = np.concatenate([[2 * path.wavenumber[0] - edges[0]], edges[:-1], [2 * path.wavenumber[-1] - edges[-2]]])
    width, micron = np.diff(edges), -np.diff(1e4 / edges)
    return {
        "transmittance": path.transmittance @ micron / micron.sum(),
        "path_radiance": (path.path_thermal + path.path_scattered) @ width,
        "ambient": surface.sky_irradiance @ width / np.pi,
        "direct": surface.direct_irradiance @ width / np.pi,
    }


def of_all_points(loaded, lines):
    """The same by the computation of the tables, with all points of the band; (n,) arrays."""
    job, response = loaded.trimmed, response_of(loaded.trimmed.bands[0])
    written = job.states[0]
    points = points_of_band(absorption_table(job.water_continuum), response)
    state = over_ground(atmospheric_state(job.site, written), written, response, load_library())
    sun = source_irradiance(job, "sun", points.wavenumber, points.width)
    air = BandAtmosphere.of(state, points)
    place = np.array(lines).T
    path = air.spectral_at_points(LinesOfSight(*place), sun)
    surface = air.spectral_at_points(LinesOfSight(np.zeros(len(lines)), *place[1:]), sun)
    return {
        "transmittance": path.transmittance @ points.weight / points.weight.sum(),
        "path_radiance": path.path_radiance,
        "ambient": surface.sky_irradiance @ points.radiance_weight / np.pi,
        "direct": surface.direct_irradiance @ points.radiance_weight / np.pi,
    }


@pytest.mark.parametrize("band", list(BANDS))
def test_spectra_of_lines_integrate_to_the_tables(band, quoted):
    job = job_of(band)
    spectra = [of_spectra(job, line) for line in LINES]
    print(f"\n{band}, spectrum against the tables' computation, %:")
    largest = 0.0
    for name, values in of_all_points(load_job(job), LINES).items():
        error = (np.array([line[name] for line in spectra]) - values) / (1.0 if name == "transmittance" else values)
        print(f"{name:15s}", " ".join(f"{100 * x:+8.3f}" for x in error))
        largest = max(largest, np.abs(error).max())
        assert np.abs(error).max() < TOLERANCE, name
    quoted(f"air.spectrum.{band.split()[0].replace('.', '').replace('-', '_')}", f"{100 * largest:.2f}", "%")
