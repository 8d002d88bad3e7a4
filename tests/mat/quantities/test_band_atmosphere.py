"""The four table quantities: limits at both ends of range and transmittance, night, ground, reciprocity with the direct
sums.
"""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.formulas import BETA_CAP_KM
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance
from skyshine.schemas.errors import InputError

RESPONSE = SpectralResponse.rectangular(3.99, 4.01)
GRID = PathGrid(
    range_km=[0.0, 0.001, 0.01, 0.1, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0, 20000.0],
    altitude_km=[0.0, 0.3, 1.0, 12.0, 100.0, 700.0],
    elevation_deg=[-90.0, -25.0, -8.0, -1.0, 0.0, 1.0, 30.0, 90.0],
    source_elevation_deg=[-30.0, -3.0, 0.0, 20.0, 90.0],
    source_azimuth_deg=[0.0, 60.0, 180.0],
)


@pytest.fixture(scope="module")
def band():
    return points_of_band(AbsorptionTable.open(), RESPONSE)


@pytest.fixture(scope="module")
def sun(band):
    return solar_irradiance(band.wavenumber)


@pytest.fixture(scope="module")
def state():
    return AtmosphericState.from_profile("midlatitude_summer", gas_amounts=GasAmounts(ppm={"CO2": 420}))


@pytest.fixture(scope="module")
def air(state, band):
    return BandAtmosphere.of(state, band)


@pytest.fixture(scope="module")
def table(air, sun):
    return air.table(GRID, sun)


def test_the_band_holds_the_response(band):
    assert band.weight.sum() == pytest.approx(0.02, rel=1e-3)
    black = band.radiance_weight @ (
        1.191042972e-8 * band.wavenumber**3 / np.expm1(1.438776877 * band.wavenumber / 300.0)
    )
    assert black == pytest.approx(band_radiance(RESPONSE, 300.0), rel=2e-3)


def test_everything_is_finite_and_not_negative(table):
    for name, values in vars(table).items():
        assert np.all(np.isfinite(values)), name
        assert np.all(values >= 0), name
    assert np.all(table.beta_star > 0) and np.all(table.beta_star <= BETA_CAP_KM)
    assert np.all(table.transmittance <= 1)


def test_beta_gives_back_the_transmittance(table):
    ranges = GRID.range_km[:, None, None]
    tau = np.exp(-5.5 * ranges / table.beta_star)
    assert tau[table.valid] == pytest.approx(table.transmittance[table.valid], abs=1e-6)
    assert np.log(tau[table.valid & (tau > 1e-300)]) == pytest.approx(
        np.log(table.transmittance[table.valid & (tau > 1e-300)]), rel=1e-6, abs=1e-5
    )


def test_beta_at_range_zero_is_the_limit(table):
    inside = table.valid[1, :4]  # below the top of the atmosphere
    assert table.beta_star[1, :4][inside] == pytest.approx(table.beta_star[0, :4][inside], rel=0.02)


def test_path_radiance_ratio_has_its_limit_at_range_zero(table):
    inside = table.valid[1]
    assert table.path_radiance_ratio[1][inside] == pytest.approx(table.path_radiance_ratio[0][inside], rel=2e-3)


def test_path_radiance_ratio_runs_continuously_to_space(air, sun):
    grid = replace(
        GRID,
        range_km=np.geomspace(0.001, 2000.0, 160),
        altitude_km=[0.0, 2.0],
        elevation_deg=[-1.0, 0.0, 10.0, 90.0],
        source_elevation_deg=[30.0],
        source_azimuth_deg=[90.0],
    )
    ratio = air.table(grid, sun).path_radiance_ratio
    step = np.abs(np.diff(np.log(ratio), axis=0))
    assert step.max() < 0.06  # ranges grow by 10 % from one to the next


def test_ground_marks_and_holds(table):
    ground = GRID.altitude_km[:, None] > 0
    down = np.array(GRID.elevation_deg) == -90
    lengths = GRID.range_km[:, None]
    assert np.array_equal(table.valid[:, :, down][..., 0], lengths <= GRID.altitude_km)
    assert ground.shape == (6, 1)
    for altitude in (2, 3):  # sky light is held at the value on the ground: the longest ranges are all alike
        assert np.ptp(table.ambient[-3:, altitude, 0], axis=0) == pytest.approx(0.0, abs=1e-12)
        # beta* goes on through the air above the ground: transmittance falls on from what it is there.
        beyond = ~table.valid[:, altitude, 0]
        length, beta = lengths[beyond, 0], table.beta_star[beyond, altitude, 0]
        assert np.all(np.diff(5.5 * length / beta) > 0) and np.all(
            np.exp(-5.5 * length / beta) < table.transmittance[beyond, altitude, 0]
        )


def test_path_radiance_ratio_passes_smoothly_through_the_ground(air, sun):
    """Its step from one range to the next goes on there; a value held at the ground would end it."""
    grid = replace(GRID, range_km=np.linspace(1.0, 4.0, 61), altitude_km=[1.0], elevation_deg=[-30.0])
    table = air.table(grid, sun)
    ground = np.count_nonzero(table.valid)
    assert 10 < ground < 50
    step = np.diff(table.path_radiance_ratio[:, 0, 0], axis=0)
    change = np.abs(np.diff(step, axis=0))
    assert np.all(change[ground - 3 : ground + 2] < 0.25 * np.abs(step[ground - 3]))


def test_no_direct_light_at_night(table):
    below_the_stratosphere = table.direct[:9, :4, :, 0]  # ranges to 100 km; a target in space may see the Sun
    assert np.all(below_the_stratosphere == 0)
    day = table.direct[..., 4]
    assert np.all(day > 0)


def test_space_is_clear(table):
    outward = table.beta_star[:, 5, 4:]
    assert np.all(outward == BETA_CAP_KM)
    assert np.all(table.transmittance[:, 5, 4:] == 1.0)


def test_night_has_only_thermal_path_radiance(air, band):
    dark = air.table(replace(GRID, range_km=[0.0, 1.0, 1000.0]), np.zeros(band.weight.size))
    spread = np.ptp(dark.path_radiance_ratio, axis=(3, 4))
    assert np.all(spread <= 1e-12 * dark.path_radiance_ratio.max()) and dark.path_radiance_ratio.max() > 0
    assert np.all(dark.direct == 0)


def test_isothermal_opaque_band_shows_the_black_body():
    response = SpectralResponse.rectangular(4.29, 4.30)
    band = points_of_band(AbsorptionTable.open(), response)
    state = AtmosphericState.from_profile("us_standard")
    state = replace(state, temperature=np.full_like(state.temperature, 285.0))
    grid = replace(GRID, altitude_km=[0.0, 1.0], source_azimuth_deg=[0.0])
    found = BandAtmosphere.of(state, band).table(grid, np.zeros(band.weight.size))
    opaque = found.transmittance < 1e-6
    assert opaque.sum() > 20
    expected = np.full(found.path_radiance_ratio[opaque].shape, band_radiance(response, 285.0))
    assert found.path_radiance_ratio[opaque] == pytest.approx(expected, rel=5e-3)


def test_direct_light_of_a_clear_band_is_the_irradiance_over_pi(state, band, sun):
    clear = replace(state, mole_fraction={gas: x * 1e-9 for gas, x in state.mole_fraction.items()}, aerosols=())
    point = BandAtmosphere.of(clear, band).at_points(LinesOfSight(0.01, 0.5, -30.0, 50.0, 0.0), sun)
    assert point.direct[0] == pytest.approx(band.radiance_weight @ sun / np.pi, rel=1e-3)
    assert point.transmittance[0] == pytest.approx(1.0, abs=1e-6)


def test_points_agree_with_the_table(air, sun, table):
    rng = np.random.default_rng(3)
    where = [rng.integers(n, size=40) for n in GRID.shape]
    axes = [getattr(GRID, name)[i] for name, i in zip(GRID.__dataclass_fields__, where, strict=True)]
    points = air.at_points(LinesOfSight(*axes), sun)
    for name, values in vars(points).items():
        grid = getattr(table, name)[tuple(where[: getattr(table, name).ndim])]
        if name == "ambient":  # the table's sky irradiance is interpolated between altitudes
            assert values == pytest.approx(grid, rel=0.02, abs=1e-3 * table.ambient.max())
        else:
            assert values == pytest.approx(grid, rel=6e-3, abs=1e-12), name


def test_scattered_sunlight_shows_in_path_radiance(table):
    towards, away = table.path_radiance_ratio[5, 2, 4, 3, [0, 2]]
    night = table.path_radiance_ratio[5, 2, 4, 0, 0]
    assert towards > away > night


def test_progress_counts_lines_of_sight(air, sun):
    seen = []
    grid = replace(GRID, range_km=[1.0], source_elevation_deg=[10.0], source_azimuth_deg=[0.0])
    air.table(grid, sun, progress=seen.append)
    assert sum(seen) == grid.shape[1] * grid.shape[2]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"range_km": [1.0, 1.0]}, "range_km"),
        ({"altitude_km": []}, "altitude_km"),
        ({"elevation_deg": [0.0, np.nan]}, "elevation_deg"),
    ],
)
def test_bad_axes_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        replace(GRID, **change)


def test_bad_irradiance_and_altitude_are_refused(air, sun):
    with pytest.raises(InputError, match="irradiance"):
        air.table(GRID, sun[:-1])
    with pytest.raises(InputError, match="irradiance"):
        air.table(GRID, -sun)
    with pytest.raises(InputError, match="below the ground"):
        air.table(replace(GRID, altitude_km=[-0.2]), sun)


def test_lines_give_what_their_points_give(air, sun):
    """Two lines, three ranges of which one lies behind the ground, two sources; sky light on the first."""
    ranges, altitude, elevation = (
        np.array([[0.5, 2.0, 40.0], [0.0, 5.0, 400.0]]),
        np.array([1.0, 3.0]),
        np.array([-20.0, 5.0]),
    )
    source, azimuth = np.array([[30.0, -2.0], [10.0, 80.0]]), np.array([[20.0, 170.0], [0.0, 90.0]])
    lines = air.along_lines(ranges, altitude, elevation, source, azimuth, [1], sun)
    row, step, light = (index.ravel() for index in np.indices((2, 3, 2)))
    points = air.at_points(
        LinesOfSight(ranges[row, step], altitude[row], elevation[row], source[row, light], azimuth[row, light]), sun
    )
    for name in ("path_radiance_ratio", "direct"):
        np.testing.assert_allclose(
            getattr(lines, name).ravel(), getattr(points, name), rtol=3e-4, atol=1e-9
        )  # paths are cut at other ranges
    for name in ("beta_star", "transmittance", "valid"):
        np.testing.assert_allclose(np.repeat(getattr(lines, name).ravel(), 2), getattr(points, name), rtol=1e-4)
    assert lines.ambient == pytest.approx(points.ambient[(row == 0) & (step == 1) & (light == 0)], rel=1e-4)


def test_direct_light_at_points_is_what_the_air_leaves_of_the_source(air, sun):
    line = LinesOfSight(*(np.array([each]) for each in (1.0, 1.0, -30.0, 60.0, 0.0)))
    one, two = (air.spectral_at_points(line, light) for light in (sun, 2 * sun))
    assert two.direct_irradiance == pytest.approx(2 * one.direct_irradiance)
    share = one.direct_irradiance[0] / sun
    assert np.all((share >= 0) & (share <= 1)) and share.max() > 0.5
