"""Pixels, temperatures and quantities of the library in C against the same in numpy; bytes; what is not a number."""

import hashlib
import os
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import numpy_pixels
import pytest
from numpy_air import NumpyAir
from numpy_response import NumpySurface

from skyshine.mat.kernel.library import VARIABLE, lanes
from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction
from skyshine.mat.runtime.pixel import Faces, PixelRadiance, View, pixel_radiance
from skyshine.mat.tables.loader import open_table
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Variable

COUNT, MATERIALS = 150, 3  # more than four blocks, and a part of one
AGREEMENT = 1e-9  # relative to the largest of the term
FRAME = LinesOfSight(np.array([2.0]), np.array([0.7]), np.array([-20.0]), np.array([30.0]), np.array([40.0]))


@pytest.fixture(scope="module")
def tables(built):
    return tuple(open_table(built / f"{name}.h5") for name in ("s01.htt", "b01.band", "s01b01.atmq"))


def pixels(count=COUNT, seed=3):
    """Faces of every direction, from at once to far away, by day and night, of two materials in any order."""
    draw, one = np.random.default_rng(seed), np.ones(count)
    codes = draw.choice([0, 1], (count, MATERIALS))
    shares = draw.dirichlet(np.ones(MATERIALS), count)
    shares[::2] = [1.0, 0.0, 0.0]
    slope, azimuth = draw.uniform(0, 45, count), draw.uniform(-400, 800, count)
    slope[::5] = 0.0
    elevation = -np.degrees(np.arcsin(draw.uniform(0.02, 1.0, count)))
    elevation[::7] = draw.uniform(-3.0, 30.0, elevation[::7].size)
    reach = np.exp(draw.uniform(np.log(0.001), np.log(20.0), count))
    heading, sun = draw.uniform(0, 360, count), draw.uniform(0, 360, count)
    lines = LinesOfSight(reach, draw.uniform(0.01, 1, count), elevation, draw.uniform(-25, 60, count), sun - heading)
    faces = Faces(codes, shares, draw.uniform(0, 1, count), azimuth, slope, draw.uniform(0, 24, count) * one)
    return faces, View.of(lines, heading, direction(90 - slope, azimuth))


def of_materials(tables, faces):
    """Faces whose numbers of materials are codes of the table."""
    codes = np.array(list(tables[1].materials.values()))
    return replace(faces, codes=codes[faces.codes])


DRAWN = np.random.default_rng(8)
SKY, WALL, RANGES = DRAWN.uniform(0, 1, COUNT), DRAWN.uniform(270, 320, COUNT), DRAWN.uniform(0.3, 2.0, COUNT)
CASES = {
    "own lines": lambda f, v: (f, v),
    "partly lit": lambda f, v: (replace(f, lit_share=SKY), v),
    "stated temperatures": lambda f, v: (replace(f, temperature=WALL[:, None] + np.arange(MATERIALS)), v),
    "beside walls": lambda f, v: (replace(f, sky_view=SKY, wall_temperature=WALL), v),
    "walls as warm as the air": lambda f, v: (replace(f, sky_view=SKY), v),
    "level sky": lambda f, v: (f, replace(v, source_heading=None)),
    "other ranges": lambda f, v: (replace(f, sky_view=SKY, wall_temperature=WALL), replace(v, range=v.range * RANGES)),
    "ground of a temperature": lambda f, v: (replace(f, ground_temperature=WALL), v),
    "ground of a material": lambda f, v: (replace(f, ground_material=f.codes[:, 1]), v),
    "a frame": lambda f, v: (f, replace(v, lines=FRAME, source_heading=np.array([150.0]))),
    "a frame beside walls": lambda f, v: (
        replace(f, sky_view=SKY, wall_temperature=WALL, lit_share=SKY),
        replace(v, lines=FRAME, source_heading=np.array([150.0])),
    ),
    "in the shade": lambda f, v: (replace(f, shade=SKY, shaded_sky=np.full(COUNT, 0.3)), v),
}


def agree(found, expected, *, tolerance=AGREEMENT):
    for field in fields(PixelRadiance):
        values, wanted = getattr(found, field.name), getattr(expected, field.name)
        np.testing.assert_allclose(
            values, wanted, rtol=tolerance, atol=1e-13 * np.abs(wanted).max(), err_msg=field.name
        )


@pytest.mark.parametrize("name", CASES)
def test_pixels_agree_with_numpy(tables, name):
    faces, view = pixels()
    faces, view = CASES[name](of_materials(tables, faces), view)
    if name == "in the shade":  # each column of them takes numpy milliseconds
        faces, view = part_of(faces, 24), replace(part_of(view, 24), lines=view.lines.take(slice(24)))
    wide = (
        view
        if view.lines.range.size > 1
        else replace(view, lines=repeated(view.lines), source_heading=np.full(COUNT, 150.0))
    )
    agree(pixel_radiance(*tables, faces, view), numpy_pixels.pixel_radiance(*tables, faces, wide))


def part_of(values, count):
    parts = {f.name: getattr(values, f.name) for f in fields(values) if f.name != "lines"}
    return replace(values, **{name: None if part is None else part[:count] for name, part in parts.items()})


def repeated(lines):
    return LinesOfSight(*(np.repeat(part, COUNT) for part in lines.place))


def test_a_frame_is_what_its_pixels_are_on_their_own(tables):
    """Of one line for all, and of the same one for each beside another."""
    faces, view = pixels()
    faces = of_materials(tables, faces)
    whole = replace(view, lines=FRAME, source_heading=np.array([150.0]))
    lines = repeated(FRAME)
    lines.source_azimuth[-1] += 1.0
    apart = pixel_radiance(*tables, faces, replace(whole, lines=lines, source_heading=np.full(COUNT, 150.0)))
    for field in fields(PixelRadiance):
        values = getattr(pixel_radiance(*tables, faces, whole), field.name)[:-1]
        np.testing.assert_allclose(values, getattr(apart, field.name)[:-1], rtol=1e-11, atol=1e-15)


QUANTITIES = {
    "beta_star": {},
    "path_radiance_ratio": {"source_elevation": (-25, 60), "source_azimuth": (-400, 400)},
    "ambient_radiance": {"source_elevation": (-25, 60)},
    "direct_radiance": {"source_elevation": (-25, 60)},
    "ambient_radiance_harmonics": {"source_elevation": (-25, 60), "harmonic": 20},
    "ground_radiance_harmonics": {"ground_temperature": (280, 300), "zonal_harmonic": 10},
    "valid": {},
    "optical_depth": {},
}


def bright(air, factor):
    """An atmosphere that scatters light of the source, by the factor of its direction."""
    for name in ("scattered_ratio", "source_reference"):
        air = with_data(air, name, np.ones_like(air.root.variables[name].data))
    return with_data(air, "source_factor", factor(air.root.variables["source_factor"].data.shape))


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("space", [False, True])
def test_quantities_agree_with_numpy(tables, quantity, space):
    draw = np.random.default_rng(11)
    air = bright(tables[2], lambda shape: draw.uniform(0, 1, shape).astype(np.float32))
    if space:
        air = replace(air, attributes=air.attributes | {"altitude_km": np.array([0.01, 100.0]), "range_km": [0.0, 1e5]})
    high = draw.uniform(150, 3e4, COUNT) if space else draw.uniform(0.01, 1, COUNT)
    where = {
        "range": high * draw.uniform(0.5, 3, COUNT) if space else draw.uniform(0.001, 20, COUNT),
        "altitude": high,
        "elevation": draw.uniform(-90, -2 if space else 90, COUNT),
    }
    for name, limits in QUANTITIES[quantity].items():
        where[name] = draw.uniform(*limits, COUNT) if isinstance(limits, tuple) else limits
    if space:  # where the line enters the air the source may be higher than the table has it
        air = air.clamped("source_elevation")
    oracle = NumpyAir.of(air)
    if quantity != "optical_depth":
        expected = oracle.value(quantity, **where)
        np.testing.assert_allclose(
            air.value(quantity, **where), expected, rtol=AGREEMENT, atol=1e-13 * np.abs(expected).max()
        )
    if quantity in ("beta_star", "path_radiance_ratio", "valid"):
        return
    expected = oracle.value_by_wavelength(quantity, **where)
    found = air.value_by_wavelength(quantity, **where)
    np.testing.assert_allclose(found, expected, rtol=AGREEMENT, atol=1e-13 * np.abs(expected).max())


def test_light_of_the_source_agrees_while_it_fades(tables):
    """Between the lowest elevation, -20 degrees, and one at which it is dark."""
    air = bright(tables[2], lambda shape: np.ones(shape, np.float32))
    axis = air.root.axes["source_elevation"]
    dusk = replace(axis, attributes=axis.attributes | {"dark_below": -40.0})
    air = replace(air, root=replace(air.root, axes=air.root.axes | {"source_elevation": dusk}))
    where = {"range": 5.0, "altitude": 0.5, "elevation": -3.0, "source_azimuth": 60.0}
    where["source_elevation"] = np.array([-20.0, -25.0, -30.0, -39.0, -45.0])
    found, expected = (table.value("path_radiance_ratio", **where) for table in (air, NumpyAir.of(air)))
    np.testing.assert_allclose(found, expected, rtol=AGREEMENT)
    assert np.all(np.diff(found) < 0)


@pytest.mark.parametrize("kelvin", [None, 293.0])
@pytest.mark.parametrize("by_wavelength", [False, True])
def test_light_on_faces_agrees_with_numpy(tables, kelvin, by_wavelength):
    _, band, air = tables
    draw = np.random.default_rng(12)
    where = {"range": draw.uniform(0.01, 20, 40), "altitude": draw.uniform(0.01, 1, 40), "elevation": -5.0}
    given = {} if kelvin is None else {"ground_temperature": kelvin, "band": band}
    of = {"slope": draw.uniform(0, 180, 40), "azimuth": draw.uniform(-360, 360, 40), "by_wavelength": by_wavelength}
    found, expected = (
        each.ambient_radiance(**of, **where, **given, source_elevation=20.0) for each in (air, NumpyAir.of(air))
    )
    np.testing.assert_allclose(found, expected, rtol=AGREEMENT, atol=1e-13)


@pytest.mark.parametrize("slope", [0.0, 33.0])
@pytest.mark.parametrize(
    "around",
    [
        {"shade": [(8.3, 14.0)]},
        {"shade": [(22.0, 5.5)], "sky_view": 0.4},
        {"shade": [(0, 24)], "sky_view": 0.2, "facing": 310.0, "facing_emissivity": 0.7},
    ],
)
def test_temperatures_in_the_shade_agree_with_numpy(tables, slope, around):
    surface, oracle = tables[0], NumpySurface.of(tables[0])
    place = {"material": list(surface.materials), "altitude": 0.3, "azimuth": 200.0, "slope": slope}
    heat, expected = (table.absorbed_change(**place, **around) for table in (surface, oracle))
    np.testing.assert_allclose(heat, expected, rtol=1e-9, atol=1e-7)
    hours = np.linspace(0, 30, 61)
    column = {name: np.reshape(values, (-1, 1)) for name, values in place.items()}
    kelvin = [table.temperature(**column, time=hours, absorbed_change=expected[:, None]) for table in (surface, oracle)]
    np.testing.assert_allclose(*kelvin, atol=1e-9)


def bytes_of(folder, name):
    tables = [open_table(Path(folder) / f"{file}.h5") for file in ("s01.htt", "b01.band", "s01b01.atmq")]
    faces, view = pixels()
    faces, view = CASES[name](of_materials(tables, faces), view)
    terms = pixel_radiance(*tables, faces, view)
    return hashlib.sha256(b"".join(getattr(terms, field.name).tobytes() for field in fields(terms))).hexdigest()


def test_with_four_and_eight_numbers_the_bytes_are_the_same(built):
    names = "other ranges", "a frame beside walls", "in the shade"
    if lanes() != 8:
        pytest.skip("this processor has vectors of four")
    program = (
        "import sys; sys.path.insert(0, sys.argv[1]); import test_pixels as t;"
        " print(*(t.bytes_of(sys.argv[2], name) for name in sys.argv[3:]), sep='\\n')"
    )
    command = [sys.executable, "-c", program, Path(__file__).parent, built, *names]
    shown = [
        subprocess.run(command, env=os.environ | {VARIABLE: number}, capture_output=True, text=True, check=True).stdout
        for number in ("4", "8")
    ]
    here = [bytes_of(built, name) for name in names]
    assert shown[0].split() == shown[1].split() == here and len(set(here)) == 3


def with_data(table, array, data):
    """A table with other values of an array."""
    of = table.root.variables[array]
    variable = Variable(of.dims, data, of.units, of.long_name, of.attributes)
    return replace(table, root=replace(table.root, variables=table.root.variables | {array: variable}))


NOT_A_NUMBER = {
    "surface": ("temperature",),
    "band": ("blackbody_radiance", "reflectance_spectrum", "emission_share", "specular_fraction", "normalisation"),
    "air": (
        "effective_radius", "log_mean_extinction", "absorber_factor", "channel_weight", "thermal_reference",
        "thermal_ratio", "source_reference", "scattered_ratio", "source_factor", "source_rise", "direct_light",
        "direct_light_factor", "thermal_sky", "thermal_sky_factor", "scattered_sky", "scattered_sky_factor",
        "thermal_wavelength_share", "source_wavelength_share", "thermal_harmonics", "scattered_harmonics",
        "ground_harmonics", "ground_emission",
    ),
}  # fmt: skip


@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize(("which", "array"), [(which, array) for which, of in NOT_A_NUMBER.items() for array in of])
def test_what_is_not_a_number_in_a_table_is_no_number_in_a_pixel_or_is_refused(tables, which, array, shared):
    faces, view = pixels()
    faces = replace(of_materials(tables, faces), slope=np.full(COUNT, 20.0))
    lit = replace(view.lines, source_elevation=np.full(COUNT, 40.0))
    view = replace(view, lines=FRAME if shared else lit, source_heading=np.full(1 if shared else COUNT, 150.0))
    view = replace(view, to_source=view.normal + 0.1, to_observer=view.normal)
    broken = dict(zip(("surface", "band", "air"), tables, strict=True))
    table = broken[which]
    variable = table.root.variables[array]
    broken[which] = with_data(table, array, np.full(variable.data.shape, np.nan, np.float32))
    try:
        radiance = pixel_radiance(*broken.values(), faces, view).radiance
    except InputError:
        return
    assert np.all(np.isnan(radiance))


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"slope": np.full(COUNT, 95.0)}, "slope: found 95; allowed: 0 to 45"),
        ({"time": np.full(COUNT, np.nan)}, "time: found a value that is not finite"),
        ({"codes": np.full((COUNT, MATERIALS), 9)}, "material: found 9"),
        ({"codes": np.zeros((COUNT, MATERIALS), int)}, "pixel without material"),
        ({"temperature": np.full((COUNT, MATERIALS), 5.0)}, "temperature: found 5; allowed: "),
        ({"temperature": np.full((COUNT, MATERIALS), np.nan)}, "temperature: found a value that is not finite"),
        ({"sky_view": np.full(COUNT, 1.5)}, "sky_view beyond 0 to 1"),
    ],
)
def test_faces_outside_the_tables_are_refused(tables, changed, words):
    faces, view = pixels()
    with pytest.raises(InputError, match=words):
        pixel_radiance(*tables, replace(of_materials(tables, faces), **changed), view)


@pytest.mark.parametrize("name", ["altitude", "lit_share", "shares", "temperature"])
def test_lists_of_another_length_are_refused(tables, name):
    faces, view = pixels()
    short = np.ones((7, MATERIALS) if name in ("shares", "temperature") else 7)
    with pytest.raises(ValueError, match="broadcast"):
        pixel_radiance(*tables, replace(of_materials(tables, faces), **{name: short}), view)


@pytest.mark.parametrize(
    ("axis", "value", "words"),
    [
        ("range", 21.0, "range: found 21; allowed: 0.001 to 20"),
        ("altitude", -0.5, "altitude: found -0.5"),
        ("elevation", np.nan, "elevation: found a value that is not finite"),
        ("source_elevation", 70.0, "source_elevation: found 70"),
        ("source_azimuth", np.inf, "source_azimuth: found a value that is not finite"),
    ],
)
def test_lines_outside_the_tables_are_refused(tables, axis, value, words):
    faces, view = pixels()
    lines = replace(view.lines, **{axis: np.full(COUNT, value)})
    for each in (lines, lines.take(slice(1))):
        heading = view.source_heading[: each.range.size]
        with pytest.raises(InputError, match=words):
            pixel_radiance(*tables, of_materials(tables, faces), replace(view, lines=each, source_heading=heading))


def test_a_range_of_0_an_opaque_path_and_the_polar_night(tables):
    """Of no path nothing is lost; of an optical depth of 1e4 only the path is seen; in the night no beam is there."""
    surface, band, air = tables
    faces, view = pixels()
    faces, one = of_materials(tables, faces), np.ones(COUNT)
    near = pixel_radiance(*tables, faces, replace(view, range=0 * one))
    assert np.all(near.transmittance == 1) and np.all(near.path == 0)
    extinction = air.root.variables["log_mean_extinction"].data
    thick = with_data(air, "log_mean_extinction", extinction + np.float32(np.log(1e6)))
    opaque = pixel_radiance(surface, band, thick, faces, view)
    far = view.range > 1.0
    assert np.all(opaque.transmittance[far] < 1e-100) and np.all(np.isfinite(opaque.radiance))
    agree(opaque, numpy_pixels.pixel_radiance(surface, band, thick, faces, view))
    dark = replace(view, lines=replace(view.lines, source_elevation=-60 * one))
    night = pixel_radiance(*tables, faces, dark)
    assert np.all(night.diffuse == 0) and np.all(night.specular == 0) and np.all(night.skyshine > 0)
