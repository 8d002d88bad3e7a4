"""Texel formats, nodes of axes, and the two languages of the shader."""

import ctypes
import re
import shutil
import subprocess

import numpy as np
import pytest
from gpu_files import read_gpu

from skyshine.mat.gpu.container import FORMATS, GpuFile, texture, write_gpu
from skyshine.mat.gpu.evaluation import face_weights
from skyshine.mat.gpu.nodes import best_counts, insertion_order
from skyshine.mat.gpu.shader import shader
from skyshine.mat.radiometry.spherical_harmonics import HARMONICS, ambient_of_faces, face_normal
from skyshine.schemas.errors import InputError


@pytest.mark.parametrize("kind", FORMATS)
def test_textures_come_back_as_they_were_written(tmp_path, kind):
    channels = FORMATS[kind][1]
    values = np.arange(3 * 2 * 5 * channels).reshape(3, 2, 5, channels)
    content = GpuFile("band", {}, {"a": texture(kind, values if channels > 1 else values[..., 0], "numbers")}, {"n": 1})
    found = read_gpu(write_gpu(content, tmp_path, "x")).textures["a"]
    assert found.size == (5, 2, 3)
    assert np.array_equal(found.texels, values)


@pytest.mark.parametrize("value", [65520.0, np.inf, np.nan, -1e9])
def test_what_half_floats_do_not_hold_is_refused(value):
    with pytest.raises(InputError, match="beyond 65504"):
        texture("R16F", np.array([[1.0, value]]), "heat")


def test_a_half_float_keeps_its_digits_down_to_its_smallest_normal_number():
    values = np.array([[6.2e-5, 1.0, 65504.0]])
    assert texture("R16F", values, "x").texels.astype(float)[0, 0, :, 0] == pytest.approx(values[0], rel=2**-11)


def test_nodes_go_where_a_function_bends():
    place = np.linspace(0.0, 1.0, 101)
    order, error = insertion_order(place, np.abs(place - 0.3)[:, None], np.array([0, 100]), 50)
    assert place[order[2]] == pytest.approx(0.3)
    assert error[2] == pytest.approx(0.0, abs=1e-12)
    assert np.all(np.diff(error[1:]) <= 1e-12)


def test_an_axis_of_one_node():
    order, error = insertion_order(np.array([2.0]), np.array([[5.0]]), np.array([0]), 9)
    assert (order.tolist(), error.tolist()) == ([0], [0.0])


def test_counts_share_the_texels():
    falling = np.array([np.inf, 8.0, 4.0, 2.0, 1.0, 0.5])
    steep = np.array([np.inf, 1.0, 0.1, 0.0])
    first, second = best_counts((falling, steep), 12, 0.2)
    assert first * second <= 12
    assert (first, second) == (6, 2)


@pytest.mark.parametrize("count", [6, 11])
def test_the_light_of_a_face_is_linear_in_level_value_and_harmonics(count):
    random = np.random.default_rng(3)
    slope, azimuth = random.uniform(0, 180, 50), random.uniform(0, 360, 50)
    level, light = 9.0, random.normal(0, 0.3, count)
    light[0] = 20.0
    codes = np.array(HARMONICS[:count])
    zones = np.zeros(np.sum(codes % 10 == 0))
    exact = ambient_of_faces(np.array(level), light, zones, np.array(0.0), face_normal(slope, azimuth))
    weights = face_weights(slope, azimuth, codes)
    assert weights @ np.concatenate([[level], light]) == pytest.approx(exact)
    assert face_weights(np.zeros(1), np.zeros(1), codes)[0] == pytest.approx([1.0] + [0.0] * count, abs=1e-12)


BODY = """{
    SkyshineFace face;
    face.normal = VEC(0.0, 0.0, 1.0);
    face.toSource = face.normal;
    face.toObserver = face.normal;
    SkyshineAirOfPixel air = skyshineAirAt(1.0, face.toObserver);
    float kelvin = skyshineTemperature(0, 0.1, 30.0, 10.0);
    float radiance = skyshineSurfaceRadiance(air, 0, kelvin, face) + skyshinePath(air, face);
"""
PROGRAMS = {
    "GLSL": (
        "#version 300 es\n%s\nout vec4 colour; void main() %s colour = vec4(radiance, "
        "skyshineApparentTemperature(radiance), kelvin, 1.0); }",
        ["-S", "frag"],
    ),
    "HLSL": (
        "%s\nfloat4 main() : SV_Target %s return float4(radiance, "
        "skyshineApparentTemperature(radiance), kelvin, 1.0); }",
        ["-D", "-S", "frag", "-e", "main", "-V"],
    ),
}


@pytest.mark.parametrize("language", PROGRAMS)
def test_the_shader_compiles(tmp_path, language):
    compiler = shutil.which("glslangValidator")
    if compiler is None:
        pytest.skip("glslangValidator is not installed")
    frame, options = PROGRAMS[language]
    body = BODY.replace("VEC", "vec3" if language == "GLSL" else "float3")
    (tmp_path / "pixel.frag").write_text(frame % (shader(language), body), encoding="utf-8")
    done = subprocess.run([compiler, *options, "pixel.frag"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_both_languages_have_the_same_functions():
    names = [
        {word.split("(")[0] for word in shader(language).split() if word.startswith("skyshine") and "(" in word}
        for language in PROGRAMS
    ]
    assert names[0] == names[1]
    assert len(names[0]) > 8


def test_angles_of_faces_do_not_depend_on_the_sign_of_zero(tmp_path):
    """The function of the include, compiled as C, for it is C as well; a face exactly to the south has x of 0 or -0."""
    text = shader("GLSL")
    code = re.search(r"^float skyshineAngle\(.*?^}", text, re.S | re.M).group(0)
    words = "".join(f"#define {word} {word}f\n" for word in ("sqrt", "atan")) + "#define abs fabsf\n#define max fmaxf\n"
    (tmp_path / "angle.c").write_text(f"#include <math.h>\n{words}{code}\n", encoding="utf-8")
    compiler = shutil.which("cc") or pytest.skip("no C compiler")
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", "-o", "angle.so", "angle.c", "-lm"], cwd=tmp_path, check=True)
    angle = ctypes.CDLL(tmp_path / "angle.so").skyshineAngle
    angle.argtypes, angle.restype = [ctypes.c_float] * 2, ctypes.c_float
    random = np.random.default_rng(3).normal(size=(200, 2))
    exact = [(zero, along) for zero in (0.0, -0.0) for along in (1.0, -1.0, 1e-3, -1e3)]
    for across, along in [*exact, (1.0, 0.0), (-1.0, -0.0), (1e-4, -1.0), *random]:
        turn = angle(across, along) - np.degrees(np.arctan2(across, along))
        assert abs((turn + 180) % 360 - 180) < 1e-4, (across, along)
    assert angle(0.0, 0.0) == 0.0
    assert not any(re.search(r"atan2|atan\([^()]*,", shader(language)) for language in PROGRAMS)
