"""Physical laws of databases: a file that obeys them has no line, and each planted violation has one of its own."""

from collections.abc import Callable
from dataclasses import replace

import h5py
import numpy as np
import pytest

from skyshine.mat.tables.axes import EXACT, FOLDED, PERIODIC, table_axis
from skyshine.mat.tables.laws import broken_laws, broken_texture_laws
from skyshine.mat.tables.verify import problems
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, read_file, write_file

RANGE = np.array([0.0, 1.0, 5.0, 20.0])
PATH = ("range", "altitude", "elevation")
CODES = table_axis(np.array([3, 5], np.int32), "1", "code", interpolation=EXACT)
NAMES = Variable(("material",), np.array(["soil", "rock"], object), "1", "name")


def variable(dims, values, units="1"):
    return Variable(dims, np.asarray(values), units, "what")


def path_axes():
    return {
        "range": table_axis(RANGE, "km", "range"),
        "altitude": table_axis([0.1, 1.0], "km", "altitude"),
        "elevation": table_axis([-90.0, 0.0, 90.0], "degree", "elevation"),
    }


def grid() -> Group:
    """Tables of a grey air of 5 % a kilometre, with ground under the lines that look down."""
    valid = np.ones((4, 2, 3), np.int8)
    valid[1:, :, 0] = 0
    axes = path_axes() | {"source_azimuth": table_axis([0, 90, 180], "degree", "a", interpolation=FOLDED, period=360.0)}
    light = variable(("range", "source_azimuth"), np.ones((4, 3), "f4"), "W m^-2 sr^-1")
    accuracy = Group(
        {"quantity": Axis(["a"], "1", "names")},
        {name: variable(("quantity",), [value]) for name, value in (("maximum", 2.0), ("p95", 1.0), ("rms", 0.5))},
    )
    return Group(
        axes,
        {
            "beta_star": variable(PATH, np.full((4, 2, 3), 110.0, "f4"), "km"),
            "valid": variable(PATH, valid),
            **dict.fromkeys(("path_radiance_ratio", "ambient_radiance", "direct_radiance"), light),
        },
        {"accuracy": accuracy},
    )


def atmosphere(channels) -> Group:
    """Those tables beside the channels of a built file."""
    return replace(channels, groups=channels.groups | {"grid": grid()})


@pytest.fixture(scope="module")
def file_of(channel_atmosphere):
    """A file of a type that obeys the laws, in memory."""
    root, attributes = read_file(channel_atmosphere)
    channels = replace(root, attributes=attributes)

    def made(filetype):
        if filetype.endswith("atmq"):
            return atmosphere(replace(channels, variables=dict(channels.variables), axes=dict(channels.axes)))
        return FILES[filetype]()

    return made


def temperatures() -> Group:
    time = table_axis([0.0, 12.0], "h", "clock", interpolation=PERIODIC, period=24.0)
    diagnostics = {name: variable(("material",), [0.0, 1e-3]) for name in ("residual", "bound_excess")}
    return Group(
        {"material": CODES, "time": time},
        {"temperature": variable(("material", "time"), [[280.0, 310.0], [275.0, 300.0]], "K"), "material_name": NAMES},
        {"diagnostics": Group({"material": CODES}, diagnostics)},
    )


def band() -> Group:
    half = variable(("material",), [0.25, 0.5])
    return Group(
        {
            "material": CODES,
            "wavelength": Axis([8.0, 9.0, 10.0], "um", "wavelength"),
            "temperature": table_axis([200.0, 300.0], "K", "temperature"),
            "planck_temperature": table_axis([250.0, 300.0], "K", "temperature"),
            "band_wavelength": table_axis([8.0, 9.0, 10.0], "um", "wavelength"),
        },
        {
            "response": variable(("wavelength",), [0.0, 1.0, 0.5]),
            "blackbody_radiance": variable(("temperature",), [5.0, 50.0]),
            "material_name": NAMES,
            **dict.fromkeys(("reflectance", "reflectance_planck", "reflectance_solar", "specular_fraction"), half),
            **{name: variable(("material",), [0.75, 0.5]) for name in ("emissivity", "emissivity_planck")},
            **{name: variable(("material",), [9.0, 9.0]) for name in ("shininess", "lobe_fwhm", "normalisation")},
            "normalisation_by_angle": variable(("material",), [1.0, 2.0]),
            "reflectance_spectrum": variable(("material", "band_wavelength"), [[0.0, 0.5, 1.0], [0.5, 0.5, 0.5]]),
            "emission_share": variable(("planck_temperature", "band_wavelength"), [[0.25, 0.5, 0.25], [0.3, 0.5, 0.2]]),
        },
    )


def classifier() -> Group:
    number = Axis(np.arange(2, dtype=np.int32), "1", "number")
    colour = {
        "covariance": variable(("material", "row", "column"), [np.eye(2), 2 * np.eye(2)]),
        "log_prior": variable(("material",), np.log([0.25, 0.75])),
    }
    network = {"scale": variable(("row",), [1.0, 2.0])}
    groups = {
        "colour": Group({"material": number, "row": number, "column": number}, colour),
        "network": Group({"row": number}, network),
    }
    return Group(groups=groups)


FILES = {
    "htt": temperatures,
    "band": band,
    "tmm-model": classifier,
}


def put(place, *values, at=(0,)):
    """A change of a file: values of one of its arrays, by its path."""

    def change(root: Group) -> None:
        *groups, name = place.split("/")
        for group in groups:
            root = root.groups[group]
        old = root.variables[name]
        data = np.array(old.data, object if old.dtype.kind == "O" else float)
        for value in values:
            data[at] = value
        root.variables[name] = Variable(old.dims, data, old.units, old.long_name, old.attributes)

    return change


def axis(place, values, **rule):
    def change(root: Group) -> None:
        *groups, name = place.split("/")
        for group in groups:
            root = root.groups[group]
        old = root.axes[name]
        root.axes[name] = Axis(np.asarray(values), old.units, old.long_name, old.attributes | rule)

    return change


def without(part, name):
    def change(root: Group) -> None:
        getattr(root, part).pop(name)

    return change


TAU, FALLS = "give a transmittance above 0 and up to 1", "give a transmittance that falls with range"
VIOLATIONS: list[tuple[str, Callable, str]] = [
    ("atmq", put("grid/beta_star", -1.0, at=(1, 0, 1)), f"grid/beta_star: 1 of 24 values do not {TAU}"),
    ("atmq", put("grid/beta_star", 0.0, at=(1, 0, 1)), TAU),
    ("atmq", put("grid/beta_star", np.nan, at=(1, 0, 1)), TAU),
    ("atmq", put("grid/beta_star", 3e12, at=(1, 0, 1)), TAU),
    ("atmq", put("grid/beta_star", 600.0, at=(2, 1, 2)), f"grid/beta_star over range: 1 of 18 values do not {FALLS}"),
    (
        "atmq",
        axis("grid/range", [-1.0, 1.0, 5.0, 20.0]),
        "grid/beta_star over range: 1 of 4 values do not lie at 0 or above",
    ),
    (
        "lunar_atmq",
        put("grid/path_radiance_ratio", -1e-9),
        "grid/path_radiance_ratio: 3 of 12 values do not lie at 0 or above",
    ),
    ("atmq", put("grid/ambient_radiance", -1e-9), "ambient_radiance"),
    ("atmq", put("grid/direct_radiance", -1e-9), "direct_radiance"),
    ("atmq", put("grid/valid", 2, at=(0, 0, 0)), "equal 0 or 1"),
    ("atmq", put("grid/valid", 1, at=(3, 0, 0)), "grid/valid: 1 of 18 values do not stay 0 beyond the ground"),
    ("atmq", axis("grid/elevation", [-90.0, 90.0, 0.0]), "'elevation' is not a list of ascending numbers"),
    ("atmq", axis("grid/elevation", [-90.0, np.nan, 90.0]), "'elevation' is not a list of ascending numbers"),
    ("atmq", axis("grid/elevation", [-90.0, 0.0, 90.0], interpolation="cubic"), "is read by 'cubic'"),
    ("atmq", axis("grid/elevation", [-90.0, 0.0, 90.0], out_of_range="wrap"), "has out_of_range 'wrap'"),
    ("atmq", axis("grid/source_azimuth", [0.0, 90.0, 270.0]), "half the period"),
    ("atmq", axis("grid/source_azimuth", [-30.0, 90.0, 180.0]), "half the period"),
    ("atmq", put("grid/accuracy/rms", 3.0), "grid/accuracy/maximum: 1 of 1 values do not reach the rms"),
    ("atmq", put("grid/accuracy/p95", -1.0), "grid/accuracy/p95"),
    ("htt", put("temperature", 20.0, at=(0, 1)), "temperature: 1 of 4 values do not lie in 50 to 2000 K"),
    ("htt", put("temperature", 4000.0, at=(0, 1)), "lie in 50 to 2000 K"),
    ("htt", put("diagnostics/residual", -1.0), "diagnostics/residual"),
    ("htt", axis("time", [0.0, 24.0]), "less than the period 24"),
    ("htt", axis("material", [0, 5]), "material: 1 of 2 values do not lie in 1 to 65535"),
    ("htt", put("material_name", "rock"), "a name is empty or occurs twice"),
    *[
        ("band", put(name, 1.5), f"{name}: 1 of 2 values do not lie in 0 to 1")
        for name in ("reflectance", "emissivity")
    ],
    ("band", put("reflectance_planck", -0.1), "reflectance_planck"),
    ("band", put("reflectance_solar", -0.1), "reflectance_solar"),
    ("band", put("specular_fraction", 1.1), "specular_fraction"),
    ("band", put("emissivity", 0.7), "emissivity: 1 of 2 values do not equal 1 - reflectance"),
    ("band", put("emissivity_planck", 0.8), "stay below 1 - reflectance"),
    ("band", put("response", -0.1), "response: 1 of 3 values do not lie in 0 to 1"),
    ("band", put("response", 0.9, at=(1,)), "the peak is 0.9; allowed: 1"),
    ("band", put("blackbody_radiance", 60.0), "blackbody_radiance: 1 of 1 values do not rise with temperature"),
    ("band", put("shininess", 0.0), "shininess"),
    ("band", put("normalisation_by_angle", -1.0), "normalisation_by_angle"),
    ("band", put("reflectance_spectrum", -0.1, at=(1, 1)), "reflectance_spectrum: 1 of 6 values do not lie in 0 to 1"),
    ("band", put("emission_share", -0.1, at=(1, 1)), "emission_share: 1 of 6 values do not lie in 0 to 1"),
    ("band", put("emission_share", 0.5 + 3e-5, at=(1, 1)), "emission_share: 1 of 2 values do not sum to 1"),
    ("band", put("emission_share", np.nan, at=(1, 1)), "emission_share: 1 of 2 values do not sum to 1"),
    ("band", without("variables", "emission_share"), "the array 'emission_share' is missing"),
    ("band", without("variables", "reflectance_spectrum"), "the array 'reflectance_spectrum' is missing"),
    ("band", without("axes", "planck_temperature"), "the axis 'planck_temperature' is missing"),
    ("band", axis("band_wavelength", [8.0, 9.0, 10.0], period=360.0), "band_wavelength: found a period; allowed: none"),
    ("tmm-model", put("colour/covariance", np.diag([1.0, -1.0])), "form a positive definite matrix"),
    ("tmm-model", put("colour/covariance", np.zeros((2, 2))), "form a positive definite matrix"),
    ("tmm-model", put("colour/covariance", [[1.0, 0.5], [0.0, 1.0]]), "form a symmetric matrix"),
    ("tmm-model", put("colour/log_prior", 0.0), "the probabilities sum to 1.75; allowed: 1"),
    ("tmm-model", put("network/scale", 0.0), "network/scale"),
]


@pytest.mark.parametrize("filetype", ["atmq", "lunar_atmq", *FILES])
def test_a_file_that_obeys_the_laws_has_no_line(file_of, filetype):
    assert list(broken_laws(filetype, file_of(filetype))) == []


@pytest.mark.parametrize(("filetype", "change", "line"), VIOLATIONS)
def test_a_planted_violation_has_a_line(file_of, filetype, change, line):
    root = file_of(filetype)
    change(root)
    lines = list(broken_laws(filetype, root))
    assert any(line in text for text in lines), lines


def test_radiance_of_a_black_body_may_stay_within_rounding():
    root = FILES["band"]()
    put("blackbody_radiance", 5.0, at=(1,))(root)
    assert list(broken_laws("band", root)) == []


def test_shares_of_wavelengths_may_sum_to_1_within_rounding():
    root = FILES["band"]()
    put("emission_share", 0.5 + 5e-6, at=(1, 1))(root)
    assert list(broken_laws("band", root)) == []


def test_a_longer_path_may_hold_no_air(file_of):
    """beta* at its cap of 1e12 km, rounded to single precision to either side, says that nothing absorbs."""
    cap = np.float32(1e12)
    for value in (cap, np.nextafter(cap, np.float32(0))):
        root = file_of("atmq")
        put("grid/beta_star", value, at=(2, 1, 2))(root)
        assert list(broken_laws("atmq", root)) == []


def test_an_angle_and_its_mirror_image_may_have_nodes_anywhere_in_half_a_turn(file_of):
    root = file_of("atmq")
    axis("grid/source_azimuth", [30.0, 90.0, 150.0])(root)
    assert list(broken_laws("atmq", root)) == []


def test_beyond_the_ground_transmittance_need_not_fall(file_of):
    root = file_of("atmq")
    put("grid/beta_star", 500.0, at=(2, 1, 0))(root)
    assert list(broken_laws("atmq", root)) == []


def texture(path) -> None:
    axes = {name: Axis(np.arange(2.0), "1", name) for name in "yx"} | {"component": Axis(np.arange(3), "1", "rank")}
    plane, mixed = ("y", "x"), ("y", "x", "component")
    level = Group(
        axes,
        {
            "code": variable(plane, np.full((2, 2), 3, np.uint16)),
            "mix_code": variable(mixed, np.broadcast_to(np.array([3, 5, 0], np.uint16), (2, 2, 3))),
            "mix_weight": Variable(
                mixed, np.broadcast_to(np.array([60, 40, 0], np.uint16), (2, 2, 3)), "1", "w", {"total": 100}
            ),
            "confidence": variable(plane, np.full((2, 2), 0.5)),
        },
    )
    mixtures = {
        "composite": Axis(np.arange(1), "1", "number"),
        "component": Axis(np.arange(3), "1", "rank"),
    }
    weight = Variable(("composite", "component"), np.array([[60, 40, 0]], np.uint8), "percent", "w", {"total": 100})
    codes = {"material": Axis(np.array([3, 5], np.uint16), "1", "code")}
    groups = {
        "materials": Group(codes, {"name": NAMES}),
        "usage": Group(codes, {"share": variable(("material",), [0.6, 0.4])}),
        "composites": Group(mixtures, {"weight": weight}),
        "levels": Group(groups={"0": level}),
    }
    write_file(path, Group(groups=groups), Header("tmm", "d", "job"))


@pytest.mark.parametrize(
    ("name", "place", "value", "line"),
    [
        ("levels/0/mix_weight", (1, 1, 0), 61, "levels/0/mix_weight: 1 of 4 values do not sum to 100"),
        ("levels/0/mix_code", (1, 1, 1), 4, "levels/0/mix_code: 1 of 12 values do not name codes"),
        ("levels/0/code", (1, 1), 5, "equal the first code of the mixture"),
        ("levels/0/confidence", (1, 1), 1.5, "levels/0/confidence: 1 of 4 values do not lie in 0 to 1"),
        ("composites/weight", (0, 0), 61, "composites/weight: 1 of 1 values do not sum to 100"),
        ("usage/share", (0,), 0.7, "usage/share: 1 of 1 values do not sum to at most 1"),
        ("usage/share", (0,), -0.1, "usage/share: 1 of 2 values do not lie in 0 to 1"),
    ],
)
def test_a_planted_violation_of_a_texture_has_a_line(tmp_path, name, place, value, line):
    texture(tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        assert list(broken_texture_laws(file)) == []
        file[name][place] = value
        lines = list(broken_texture_laws(file))
    assert any(line in text for text in lines), lines
    assert any(line in text for text in problems(tmp_path / "a.h5"))


def test_arrays_of_a_texture_are_compared_row_by_row_however_large(tmp_path):
    """Of this width 16 MB, which are read at a time elsewhere, are fewer rows of mixtures than of codes."""
    rows, width = 600, 5000
    axes = {"y": Axis(np.arange(rows), "1", "y"), "x": Axis(np.arange(width), "1", "x")}
    axes["component"] = Axis(np.arange(3, dtype=np.uint8), "1", "rank")
    code = np.full((rows, width), 3, np.uint16)
    mix_code, mix_weight = np.zeros((2, rows, width, 3), np.uint16)
    mix_code[..., 0], mix_weight[..., 0] = 3, 100
    plane, mixed, chunk = ("y", "x"), ("y", "x", "component"), (256, 256)
    level = Group(
        axes,
        {
            "code": Variable(plane, code, "1", "code", chunks=chunk),
            "mix_code": Variable(mixed, mix_code, "1", "codes", chunks=(*chunk, 3)),
            "mix_weight": Variable(mixed, mix_weight, "1", "weights", {"total": 100}, chunks=(*chunk, 3)),
        },
    )
    materials = Group({"material": Axis(np.array([3], np.uint16), "1", "code")})
    groups = {"materials": materials, "levels": Group(groups={"0": level})}
    write_file(tmp_path / "a.h5", Group(groups=groups), Header("tmm", "d", "job"))
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        assert list(broken_texture_laws(file)) == []
        file["levels/0/code"][599, 4999] = 4
        assert len(list(broken_texture_laws(file))) == 1
