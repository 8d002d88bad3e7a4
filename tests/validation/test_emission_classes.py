"""What temperature and classes of materials are worth in a table of weighted transmittance: error of emitted light on
random lines of sight.
"""

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.measure.sampling import lines_in_cells
from skyshine.mat.quantities.emission import EmissionClasses, emission_weights, lines_of_sight
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.mat.radiometry.equivalent_temperature import kelvin_per_radiance
from skyshine.mat.scene.bands import absorption_table
from skyshine.materials.library import load_library

GRID = PathGrid([0.001, 0.2, 1, 3, 10, 30, 100], [0.01, 0.5, 2, 5, 10], [-90, -40, -10, -4, -1, 0, 2, 10, 90], [0], [0])
TOLERANCE, REFERENCE, LINES = 2e-3, 300.0, 120


@pytest.mark.validation
@pytest.mark.parametrize(("edges", "worth"), [((3.0, 5.0), 20.0), ((8.0, 12.0), 2.0)])
def test_temperature_and_classes_earn_their_axes(edges, worth):
    """Of all materials of the library at 270 to 330 K: without either axis the error is larger by the factor at
    least.
    """
    response, library = SpectralResponse.rectangular(*edges), load_library()
    band = band_points(absorption_table().points(*response.wavenumber_range), response)
    air = SpectralAir.of(
        AtmosphericState.from_profile("midlatitude_summer", gas_amounts=GasAmounts(ppm={"CO2": 420})),
        band.points,
        band.gases,
        band.weight,
    )
    rho = np.array(
        [
            np.interp(1e4 / band.wavenumber, library[name].wavelength, library[name].reflectance)
            for name in library.names
        ]
    )
    generator = np.random.default_rng(11)
    altitude, elevation, ranges = lines_in_cells(GRID, LINES, generator)
    kelvins = generator.uniform(270.0, 330.0, LINES)
    paths = [np.exp(-line.depth[line.valid]) for line in lines_of_sight(air, ranges, altitude, elevation)]
    fixed = emission_weights(band, rho, REFERENCE)
    through = np.concatenate(
        [path @ emission_weights(band, rho, kelvin).T for path, kelvin in zip(paths, kelvins, strict=True)]
    )
    classes = EmissionClasses.of(through, TOLERANCE)
    errors = {name: [] for name in ("classic", "one table", "by class", "by temperature", "both")}
    for path, kelvin in zip(paths, kelvins, strict=True):
        own = emission_weights(band, rho, kelvin)
        emitted = (1 - rho) @ (band.radiance_weight * planck_wavenumber(band.wavenumber, kelvin))
        exact = path @ own.T
        for name, weights in (
            ("classic", band.weight[None] / band.weight.sum()),
            ("one table", fixed.mean(axis=0)[None]),
            ("by class", classes.means(fixed)[classes.number - 1]),
            ("by temperature", own.mean(axis=0)[None]),
            ("both", classes.means(own)[classes.number - 1]),
        ):
            errors[name].append(((path @ weights.T - exact) * emitted).ravel())
    factor = kelvin_per_radiance(response)
    found = {name: float(np.sqrt(np.mean(np.concatenate(values) ** 2))) * factor for name, values in errors.items()}
    print(
        f"\n{edges[0]:g} to {edges[1]:g} um, {classes.count} classes, K at 300 K:",
        {name: f"{value:.4f}" for name, value in found.items()},
    )
    assert found["one table"] < found["classic"] and found["both"] <= min(found["by class"], found["by temperature"])
    assert found["both"] * worth < found["classic"]
    assert found["both"] < 0.5 * min(found["by class"], found["by temperature"])
