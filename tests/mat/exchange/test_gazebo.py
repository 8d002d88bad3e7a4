"""Heat signatures of Gazebo: what its shader makes of them is the apparent temperature of `mat contrast`."""

import json
import shutil
import xml.etree.ElementTree as xml

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from skyshine.mat.api.contrast import contrast
from skyshine.mat.commands.gazebo import command
from skyshine.mat.exchange.gazebo import Moment, grey_of, write_heat_signatures
from skyshine.mat.render.contrast import Sight
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.tmm import TextureJob, map_texture, write_texture

AT_SIX = Moment(18.0, Sight(0.5, -45.0))


@pytest.fixture(scope="session")
def built(tmp_path_factory, small_job, build_once):
    """The small build, with the Sun alone, of the whole day, and a texture, red over green over blue, of a palette."""
    whole_day = small_job.read_text().replace("[-20, 0, 30, 60]", "[-20, 0, 30, 60, 90]") + "sources: [sun]\n"
    small_build = build_once("whole_day", whole_day)

    def folder(colours):
        out = tmp_path_factory.mktemp("gazebo")
        for path in [*small_build.glob("*.h5"), small_build / "catalog.json"]:
            shutil.copy(path, out)
        image = Image.new("RGB", (4, 6), (200, 0, 0))
        image.paste((0, 200, 0), (0, 2, 4, 4))
        image.paste((0, 0, 200), (0, 4, 4, 6))
        image.save(out / "field.png")
        job = TextureJob(image="field.png", palette={"colours": colours})
        write_texture(map_texture(job, out, load_library()), out / "field.tmm.h5")
        return out

    return folder


ALL = {"#C80000": "asphalt_road", "#00C800": "grass_green", "#0000C8": "grass_green"}


def read_as_gazebo(folder):
    """Kelvin of each texel by the arithmetic of heat_signature_fs.glsl: min + (max - min) red."""
    plugin = xml.fromstring((folder / "field.thermal.sdf").read_text().split("-->")[1])
    image, low, high = (plugin.find(name).text for name in ("heat_signature", "min_temp", "max_temp"))
    red = np.asarray(Image.open(folder / image).convert("RGB"))[..., 0] / 255
    return float(low) + (float(high) - float(low)) * red


def test_what_gazebo_reads_is_the_apparent_temperature(built, tmp_path):
    folder = built(ALL)
    write_heat_signatures(folder, tmp_path, AT_SIX)
    kelvin = read_as_gazebo(tmp_path)
    (day,) = contrast(folder, "asphalt_road", "grass_green", range=0.5, elevation=-45.0)
    at = np.argmin(np.abs(day.hours - 18.0))
    stated = json.loads((tmp_path / "temperatures.json").read_text())
    step = stated["textures"]["field"]["step"]
    assert np.all(np.abs(kelvin[:2] - day.material[at]) <= 0.51 * step + 0.002)
    assert np.all(np.abs(kelvin[2:] - day.background[at]) <= 0.51 * step + 0.002)
    assert stated["materials"]["asphalt_road"] == pytest.approx(day.material[at], abs=1e-6)


def test_texels_without_material_are_refused_or_named(built, tmp_path):
    folder = built({"#C80000": "asphalt_road", "#00C800": "grass_green"})
    with pytest.raises(InputError, match="has 8 texels without material; name a substitute"):
        write_heat_signatures(folder, tmp_path, AT_SIX)
    assert not list(tmp_path.glob("*.png"))
    write_heat_signatures(folder, tmp_path, AT_SIX, "asphalt_road")
    kelvin = read_as_gazebo(tmp_path)
    assert np.all(kelvin[4:] == kelvin[0, 0]) and np.all(kelvin[2:4] != kelvin[0, 0])


@pytest.mark.parametrize("kelvin", [np.full((2, 2), 300.0), np.array([[250.123, 330.456]]), np.array([[300.0, 300.2]])])
def test_grey_spans_the_temperatures_and_is_never_empty(kelvin):
    grey, low, high = grey_of(kelvin)
    assert high - low >= 1.0 and low <= kelvin.min() and high >= kelvin.max()
    assert np.all(np.abs(low + grey / 255 * (high - low) - kelvin) <= (high - low) / 510 + 1e-9)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["--unknown-material", "sea"], "lacks the material 'sea'"),
        (["--band", "b07"], "found the band 'b07'"),
        (["--state", "2"], "has no state 2"),
        (["--range", "900"], "allowed"),
        (["--elevation", "0"], "allowed: below 0"),
    ],
)
def test_what_cannot_be_written_is_one_line(built, tmp_path, changes, words):
    given = [str(built(ALL)), "--hour", "18", "--out", str(tmp_path), *changes]
    result = CliRunner().invoke(command, given)
    assert isinstance(result.exception, InputError) and words in str(result.exception)
