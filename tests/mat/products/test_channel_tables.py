"""Tables in channels, read as a runtime reads them, against direct computation and against what must hold."""

from dataclasses import replace

import numpy as np
import pytest
from numpy_air import ChannelReader

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.measure.faces import FaceProbes
from skyshine.mat.measure.scale import Scale
from skyshine.mat.products.channel_tables import ChannelTables
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.nodes import NodeCounts
from skyshine.mat.quantities.channels.path_fields import BandLight
from skyshine.mat.quantities.channels.wavelength_shares import PartedLight
from skyshine.mat.quantities.grid import PathGrid, lines_of_sight
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.radiometry.band_wavelengths import band_wavelengths, emission_shares
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.mat.tables.channel_fields import THERMAL_SHARE
from skyshine.schemas.errors import CheckFailed, InputError

RESPONSE = SpectralResponse.rectangular(3.995, 4.005)
SCALE = Scale.kelvin(RESPONSE)
BASE = PathGrid(
    range_km=[0.001, 0.01, 0.1, 1.0, 5.0, 20.0, 100.0],
    altitude_km=[0.002, 0.1, 1.0, 5.0],
    elevation_deg=[-90.0, -10.0, -2.0, 0.0, 2.0, 20.0, 90.0],
    source_elevation_deg=[-8.0, 0.0, 20.0, 70.0],
    source_azimuth_deg=[0.0, 30.0, 180.0],
)
WHERE = {"range": 3.0, "altitude": 0.5, "elevation": 5.0}
LIT = {"source_elevation": 30.0, "source_azimuth": 40.0}


@pytest.fixture(scope="module")
def air():
    band = points_of_band(AbsorptionTable.open(), RESPONSE)
    return BandAtmosphere.of(AtmosphericState.from_profile("midlatitude_summer"), band)


@pytest.fixture(scope="module")
def sun(air):
    return solar_irradiance(air.band.wavenumber)


def tables_of(air, light, *, harmonics=0):
    """Tables in channels of all points of a band, which stand for themselves."""
    every = air.air, PartedLight.of(air.band.wavenumber, air.band.radiance_weight, light)
    return ChannelTables(air, BASE, light, SCALE, 0.5, harmonics, 1, every, band_wavelengths(RESPONSE))


@pytest.fixture(scope="module")
def channels(air, sun):
    return tables_of(air, sun, harmonics=6)


def with_parts_of(channels, **changes):
    """The tables, some of whose settings are others, with the light, absorbers and directions of the source of these:
    they take most of the time, and a table is made of any.
    """
    changed = replace(channels, **changes)
    for part in ("_sample", "_light", "_chosen", "_shares", "absorbers", "surface"):
        vars(changed)[part] = getattr(channels, part)
    return changed


@pytest.fixture(scope="module")
def table(channels):
    return channels.table(channels.nodes(NodeCounts(12, 12, 6, 8, 6)))


@pytest.fixture(scope="module")
def points(air, sun):
    """Random paths with the quantities computed directly."""
    generator = np.random.default_rng(7)
    count = 60
    place = {
        "range": 10 ** generator.uniform(-2.9, 1.9, count),
        "altitude": generator.uniform(0.13, 1.7, count) ** 3,
        "elevation": generator.choice([-1, 1], count) * 90 * generator.random(count) ** 3,
        "source_elevation": generator.uniform(-8, 70, count),
        "source_azimuth": generator.uniform(0, 180, count),
    }
    return place, air.at_points(LinesOfSight(*place.values()), sun)


QUANTITIES = {
    "beta_star": "beta_star",
    "path_radiance_ratio": "path_radiance_ratio",
    "ambient_radiance": "ambient",
    "direct_radiance": "direct",
}


@pytest.mark.parametrize("name", list(QUANTITIES))
def test_reads_agree_with_direct_computation(table, points, name):
    place, exact = points
    axes = {rule.name for rule in table.rules(name)}
    read = table.value(name, **{axis: values for axis, values in place.items() if axis in axes})
    error = SCALE.error(name, read, getattr(exact, QUANTITIES[name]), exact.transmittance, place["range"])
    above = np.abs(error[exact.valid])
    assert above.size > 30
    assert np.sqrt(np.mean(above**2)) < 0.15
    assert above.max() < 1.0


def test_faces_agree_with_the_integral_over_their_hemispheres(table, air, sun):
    """Beside walls, the part of the sky that they hide counts as bright as all of it: that is the larger error."""
    faces = FaceProbes.drawn(air, BASE, sun, np.random.default_rng(3))
    error, regions = np.abs(faces.errors(faces.read(table), SCALE)), faces.regions()
    assert error[regions["open"]].max() < 0.1 and error[regions["wall"]].max() < 0.6
    assert np.all(regions["open"] ^ regions["wall"]) and 0.3 < regions["wall"].mean() < 0.7


def test_the_beam_is_read_within_its_share_of_the_tolerance_between_its_nodes(air, channels):
    """Half way between elevations above the rise, at the nodes of heights, where no path weakens it."""
    coarse, fine = (replace(channels, tolerance=kelvin, harmonics=0).surface for kelvin in (5.0, 0.05))
    assert fine.above_rise.size > coarse.above_rise.size
    assert fine.target_height_km.size >= coarse.target_height_km.size
    light = air.band.radiance_weight / np.pi * channels.irradiance * SCALE.factor * SCALE.reflectance
    middle = (fine.above_rise[1:] + fine.above_rise[:-1]) / 2
    parts = fine.direct.factor.sum(axis=0) * SCALE.factor * SCALE.reflectance
    at_nodes = np.einsum("kbd,k->bd", fine.direct.value, parts)
    for row in range(0, fine.rise.size, 12):
        target = air.air.state.surface_altitude + fine.target_height_km[row : row + 1] * 1e3
        up = np.minimum(np.radians(fine.rise[row] + middle), np.pi / 2)
        exact = direct_transmittance(air.air.source_paths, target, up)[0] @ light
        assert np.abs((at_nodes[row, 1:] + at_nodes[row, :-1]) / 2 - exact).max() < 0.05


@pytest.mark.parametrize("ends", [(3.599, 3.601), (0.002, 0.003)])
def test_the_altitudes_that_are_shown_are_those_of_the_file(channels, ends):
    """Nodes hold cube roots of heights, whose cubes round."""
    grid = replace(BASE, altitude_km=np.linspace(*ends, 3))
    table = with_parts_of(channels, base=grid)
    table = table.table(table.nodes(NodeCounts(4, 7, 4, 4, 4)))
    altitudes = table.nodes_of("altitude")
    assert altitudes.min() >= ends[0] and altitudes.max() <= ends[1]
    assert np.all(table.value("beta_star", range=1.0, altitude=altitudes, elevation=0.0) > 0)


def test_transmittance_starts_at_one_and_falls(table):
    ranges = np.geomspace(1e-3, 100.0, 60)
    for elevation in (0.0, -0.2, 3.0, 90.0):
        beta = table.value("beta_star", range=ranges, altitude=0.5, elevation=elevation)
        tau = table.transmittance(range=ranges, beta_star=beta)
        assert tau[0] > 0.999
        assert np.all(np.diff(tau) <= 1e-4), elevation  # the last digits of stored extinction


def test_isothermal_air_without_particles_shows_its_black_body(air, sun):
    clear = AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol("none"))
    even = replace(clear, temperature=np.full_like(clear.temperature, 288.0), surface_temperature=288.0)
    warm = BandAtmosphere.of(even, air.band)
    night = tables_of(warm, np.zeros_like(sun))
    dark = night.table(night.nodes(NodeCounts(6, 4, 4, 4, 4)))
    assert np.asarray(dark.root.variables["thermal_ratio"].data) == pytest.approx(
        1.0, abs=2e-3
    )  # air scatters a little
    read = dark.value("path_radiance_ratio", **{**WHERE, "range": [0.001, 100.0]}, **LIT)
    black = dark.root.variables["thermal_reference"].data.sum()
    tau = np.exp(-5.5 * np.array([0.001, 100.0]) / dark.value("beta_star", **{**WHERE, "range": [0.001, 100.0]}))
    depth = ChannelReader.of(dark.root, dark.attributes).paths([0.001, 100.0], 0.5, 5.0).depth
    seen = -np.expm1(-depth) @ np.asarray(dark.root.variables["thermal_reference"].data) / (1 - tau)
    assert read == pytest.approx(seen, rel=2e-3)
    assert read[1] == pytest.approx(black, rel=0.02)


def test_lines_on_both_sides_of_the_horizon_agree_up_to_the_ground(table):
    dip = float(table.rays.line(1.0, 1.0, np.ones(1))[0])
    sides = np.array([dip - 1e-6, dip + 1e-6])
    beta = table.value("beta_star", range=80.0, altitude=1.0, elevation=sides)
    assert beta[0] == pytest.approx(beta[1], rel=0.03)


def test_direct_light_begins_where_the_source_rises(table):
    rise = np.asarray(table.root.variables["source_rise"].data)
    up = rise[0] + np.array([-0.5, -0.02, 0.02, 0.5])
    low = table.value("direct_radiance", range=0.001, altitude=0.002, elevation=0.0, source_elevation=up)
    assert np.all(low[:2] == 0) and np.all(low[2:] > 0)
    assert rise[0] == pytest.approx(-0.5, abs=0.15)  # refraction at the horizon


def test_below_the_lowest_elevation_the_light_fades_to_what_the_air_emits(table):
    dark = float(table.root.axes["source_elevation"].attributes["dark_below"])
    for name in ("path_radiance_ratio", "ambient_radiance"):
        more = {"source_azimuth": 40.0} if name == "path_radiance_ratio" else {}
        read = table.value(name, **WHERE, **more, source_elevation=[-8.0, 0.5 * (dark - 8.0), dark, -90.0])
        assert read[0] >= read[1] >= read[2] == read[3] > 0
        assert read[1] - read[2] == pytest.approx(0.5 * (read[0] - read[2]), rel=1e-3, abs=1e-8)


def test_scattering_angle_stands_for_azimuth(table):
    from skyshine.mat.radiometry.scattering_angle import scattering_angle

    angle = scattering_angle(WHERE["elevation"], LIT["source_elevation"], LIT["source_azimuth"])
    by_azimuth = table.value("path_radiance_ratio", **WHERE, **LIT)
    by_angle = table.value("path_radiance_ratio", **WHERE, source_elevation=30.0, scattering_angle=angle)
    assert by_azimuth == pytest.approx(by_angle)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"range": 101.0}, "range: found 101"),
        ({"altitude": 6.0}, "altitude: found 6"),
        ({"elevation": 91.0}, "elevation: found 91"),
        ({"source_elevation": np.nan}, "not finite"),
        ({"source_azimut": 1.0}, "source_azimuth"),
    ],
)
def test_what_the_file_is_not_for_is_refused(table, changed, words):
    with pytest.raises(InputError, match=words):
        table.value("path_radiance_ratio", **({**WHERE, **LIT} | changed))


def test_a_missing_axis_and_an_unknown_quantity_are_named(table):
    with pytest.raises(InputError, match="source_azimuth"):
        table.value("path_radiance_ratio", **WHERE, source_elevation=30.0)
    with pytest.raises(InputError, match="beta_sta"):
        table.value("beta_sta", **WHERE)


def test_ends_of_long_paths_stand_where_traced_rays_end(air, channels):
    """On the sphere that has the real horizon they stand kilometres too low, which a low Sun shows."""
    ranges, altitude, elevation = (
        np.array([[20.0, 150.0, 600.0]] * 3),
        np.array([0.5, 4.0, 5.0]),
        np.array([3, 6, -1.5]),
    )
    long = with_parts_of(channels, base=replace(BASE, range_km=np.append(BASE.range_km, 700.0)))
    place = {"range": ranges, "altitude": altitude[:, None], "elevation": elevation[:, None]}
    traced = [path.surface_altitude / 1e3 for path in lines_of_sight(air.air, ranges, altitude, elevation)]

    def end_height(tables):
        table = tables.table(tables.nodes(NodeCounts(16, 10, 4, 8, 10)))
        reader = ChannelReader.of(table.root, table.attributes)
        return reader.paths(*place.values()).coordinates.end_height

    assert np.abs(end_height(long) - traced).max() < 0.25
    assert np.abs(end_height(with_parts_of(long, tolerance=1e3)) - traced).max() > 2


def test_a_tolerance_that_takes_too_many_nodes_says_so(channels):
    with pytest.raises(CheckFailed, match="cannot be held in channels"):
        with_parts_of(channels, tolerance=1e-4).placed(100)


def test_no_source_gives_no_scattered_light(air, sun):
    night = tables_of(air, np.zeros_like(sun))
    dark = night.table(night.nodes(NodeCounts(5, 4, 4, 4, 4)))
    read = dark.value("path_radiance_ratio", **WHERE, source_elevation=[-8.0, 60.0], source_azimuth=0.0)
    assert read[0] == read[1] > 0
    assert np.all(dark.value("direct_radiance", **WHERE, source_elevation=[10.0, 60.0]) == 0)


def test_over_a_metre_beta_star_is_that_of_the_air_at_the_observer(table, air, sun):
    altitude = np.array([0.01, 0.7, 4.0])
    exact = air.at_points(LinesOfSight(0.001, altitude, 3.0, 30.0, 40.0), sun).beta_star
    assert table.value("beta_star", range=0.001, altitude=altitude, elevation=3.0) == pytest.approx(exact, rel=0.03)


def test_scattered_light_comes_from_the_channels_that_the_source_lights(table):
    """Twice the light of the source in all channels is twice the scattered light, whatever the channels weigh."""
    root = table.root
    reference = root.variables["source_reference"]
    assert np.sum(reference.data) == pytest.approx(1.0)

    def read(times: float) -> float:
        lit = replace(reference, data=times * np.asarray(reference.data))
        changed = replace(table, root=replace(root, variables=root.variables | {"source_reference": lit}))
        return float(changed.value("path_radiance_ratio", **WHERE, **LIT))

    shares = [read(times) for times in (0.0, 1.0, 2.0)]
    assert shares[0] > 0 and shares[1] > shares[0]
    assert shares[2] - shares[0] == pytest.approx(2 * (shares[1] - shares[0]), rel=1e-6)


def test_spectra_of_reference_are_those_of_source_and_black_body(air, sun):
    light = BandLight.of(air, sun)
    weight = air.band.radiance_weight
    assert light.source == pytest.approx(weight * sun / (weight @ sun))
    # Planck's law in wavenumber with CODATA constants, W m^-2 sr^-1 (cm^-1)^-1.
    planck = 1.191042972e-8 * air.band.wavenumber**3 / np.expm1(1.438776877 * air.band.wavenumber / 288.0)
    assert light.thermal == pytest.approx(weight * planck, rel=1e-6)


def test_light_by_wavelength_is_reflected_as_the_integral_over_the_band(table, points, air, sun):
    """A reflectance that falls across the band, against the sum over all spectral points."""
    place, exact = {axis: values[::2] for axis, values in points[0].items()}, points[1]
    through, valid = exact.transmittance[::2], exact.valid[::2]
    lines = air.spectral_at_points(LinesOfSight(*place.values()), sun)
    wavelength = np.asarray(table.root.axes["band_wavelength"].values)
    slope = (wavelength - wavelength[0]) / (wavelength[-1] - wavelength[0])
    spectral = np.interp(1e4 / air.band.wavenumber, wavelength, slope)
    weight = lines.transmittance * air.band.radiance_weight / np.pi
    lit = {axis: place[axis] for axis in ("range", "altitude", "elevation", "source_elevation")}
    for name, light in (("ambient_radiance", lines.sky_irradiance), ("direct_radiance", lines.direct_irradiance)):
        read = table.value_by_wavelength(name, **lit) @ slope * through
        truth = (weight * light) @ spectral
        error = (read - truth)[valid] * SCALE.factor
        assert np.sqrt(np.mean(error**2)) < 0.03 * np.abs(truth[valid]).max() * SCALE.factor, name
        assert np.abs(truth[valid]).max() * SCALE.factor > 1, name


@pytest.mark.parametrize("tilt", [{}, {"slope": 70.0, "azimuth": 40.0}])
def test_the_parts_of_wavelengths_sum_to_the_light_of_the_band(table, points, tilt):
    place, _ = points
    ground = {"ground_emissivity": 0.9, "ground_temperature": 300.0, "ground_radiance": 0.1}
    table = replace(table, attributes=dict(table.attributes) | ground)
    lit = {axis: place[axis] for axis in ("range", "altitude", "elevation", "source_elevation")}
    high = place["source_elevation"] > 1  # nothing is bounded at 0 there
    names = ["ambient_radiance", "direct_radiance"] if not tilt else ["ambient_radiance"]
    for name in names:
        whole = table.ambient_radiance(**tilt, **lit) if tilt else table.value(name, **lit)
        parts = (
            table.ambient_radiance(**tilt, by_wavelength=True, **lit)
            if tilt
            else table.value_by_wavelength(name, **lit)
        )
        assert parts.shape[-1] == table.root.axes["band_wavelength"].values.size
        assert parts.sum(axis=-1)[high] == pytest.approx(whole[high], rel=1e-4)


def test_emitted_light_by_wavelength_is_let_through_as_the_path_lets_it(table, points, air):
    """Sum over the wavelengths with a black body's shares, against Planck's law at all points."""
    place, exact = points
    path = {axis: place[axis] for axis in ("range", "altitude", "elevation")}
    through = np.exp(-table.value_by_wavelength("optical_depth", **path))
    share = emission_shares(RESPONSE, np.array([320.0]))[0]
    emitted = air.band.radiance_weight * planck_wavenumber(air.band.wavenumber, 320.0)
    lines = air.spectral_at_points(LinesOfSight(*place.values()), np.zeros(air.band.weight.size))
    error = through @ share - lines.transmittance @ emitted / emitted.sum()
    assert np.abs(error[exact.valid]).max() < 0.02
    assert np.sqrt(np.mean(error[exact.valid] ** 2)) < 5e-3


def test_an_optical_depth_is_read_by_wavelength_and_beta_star_is_not(table):
    with pytest.raises(InputError, match="call value_by_wavelength"):
        table.value("optical_depth", **WHERE)
    with pytest.raises(InputError, match="found the quantity 'beta_star'"):
        table.value_by_wavelength("beta_star", **WHERE)


def test_the_night_sky_is_in_the_ambient_light(builds_here):
    """1.6 um without a source: airglow is all there is, and a runtime reads it as it is computed directly."""
    response = SpectralResponse.rectangular(1.6, 1.605)
    band = points_of_band(AbsorptionTable.open(), response)
    state = replace(AtmosphericState.from_profile("midlatitude_summer"), night_sky=1.0)
    air, dark = BandAtmosphere.of(state, band), np.zeros(band.wavenumber.size)
    light = solar_irradiance(band.wavenumber) * 1e-6
    every = air.air, PartedLight.of(band.wavenumber, band.radiance_weight, light)
    scale = Scale.of_unit("K", response, float(light @ band.radiance_weight))
    tables = ChannelTables(air, BASE, light, scale, 0.05, 0, 1, every, band_wavelengths(response))
    read = tables.table(tables.nodes(NodeCounts(5, 4, 4, 4, 4)))
    place = {"range": 0.001, "altitude": 0.002, "elevation": 0.0}
    found = float(read.value("ambient_radiance", **place, source_elevation=-90.0))
    expected = air.at_points(LinesOfSight(0.001, 0.002, 0.0, -90.0, 0.0), dark).ambient[0]
    assert found == pytest.approx(expected, rel=0.02)
    assert expected > 1e-8


def test_depth_by_wavelength_is_that_of_the_transmitted_light(table):
    """From a range of 1 m, whose absorptance is small, to 100 km, over which it is whole."""
    reader = ChannelReader.of(table.root, table.attributes)
    paths = reader.paths(np.array([0.001, 0.01, 0.1, 1.0, 10.0, 100.0]), 0.002, 0.0)
    reference, share = (np.asarray(table.root.variables[name].data) for name in ("thermal_reference", THERMAL_SHARE))
    shares = reference[:, None] * share
    emits = shares.sum(axis=0) > 0
    transmitted = np.exp(-paths.depth) @ (shares[:, emits] / shares[:, emits].sum(axis=0))
    assert transmitted[0].min() > 0.99 and transmitted[-1].max() < 0.5
    assert np.exp(-reader.depth_by_wavelength(paths)[:, emits]) == pytest.approx(transmitted, rel=1e-6, abs=1e-12)
