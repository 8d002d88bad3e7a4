"""Small textures written to disk as their formats are, and the library that gives codes."""

import json
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
from click.testing import CliRunner
from filelock import FileLock

from skyshine.materials.library import load_library
from skyshine.tmm import map_texture, open_tmm, write_texture
from skyshine.tmm.cli import main
from skyshine.tmm.images.texture import Texture, TextureFile
from skyshine.tmm.job.model import TextureJob


@pytest.fixture(scope="session")
def library():
    return load_library(None)


@pytest.fixture
def write_image(tmp_path):
    """Writes (H, W, C) values in a type that OpenImageIO names and returns the file name."""

    def write(name: str, values: np.ndarray, kind: str = "uint8") -> str:
        height, width, channels = values.shape
        output = oiio.ImageOutput.create(str(tmp_path / name))
        assert output.open(str(tmp_path / name), oiio.ImageSpec(width, height, channels, kind)), output.geterror()
        assert output.write_image(np.ascontiguousarray(values)), output.geterror()
        output.close()
        return name

    return write


@pytest.fixture
def two_halves(write_image):
    """Green on the left, grey on the right, 40 x 20, with noise."""
    random = np.random.default_rng(1)
    values = np.empty((20, 40, 3))
    values[:, :20], values[:, 20:] = (60, 140, 50), (120, 120, 125)
    return write_image("halves.png", np.clip(values + random.normal(0, 6, values.shape), 0, 255).astype(np.uint8))


GREEN, GREY = "grass_green", "asphalt_road"


@pytest.fixture
def job():
    """A job of the given image, with polygons of grass on the left and asphalt on the right by default."""

    def make(image: str, polygons: dict | None = None, **settings) -> TextureJob:
        if polygons is None and "seeds" not in settings:
            polygons = {GREEN: [[[2, 2], [12, 2], [12, 15], [2, 15]]], GREY: [[[25, 3], [38, 3], [38, 12], [25, 12]]]}
        seeds = settings.pop("seeds", {"polygons": polygons})
        return TextureJob.model_validate({"image": image, "seeds": seeds, **settings})

    return make


class Built:
    """A texture mapped and written: what `map_texture` found, what was written, and the arrays of the file."""

    def __init__(self, job, folder, library, path):
        self.path, self.map = path, map_texture(job, folder, library)
        self.written = write_texture(self.map, path)
        with open_tmm(path) as file:
            names = ("code", "confidence", "typicality")
            arrays = (file.array(f"levels/0/{name}") if file.has(f"levels/0/{name}") else None for name in names)
            self.code, self.confidence, self.typicality = arrays


@pytest.fixture
def build(tmp_path, library):
    """Maps and writes the texture of a job whose files stand in `tmp_path`."""
    return lambda job, name="built.tmm.h5": Built(job, tmp_path, library, tmp_path / name)


@pytest.fixture
def read():
    """Reads a texture file as a whole into memory."""

    def whole(path, *arguments, **settings) -> Texture:
        file = TextureFile(path, *arguments, **settings)
        return Texture(*file.window(slice(0, file.height), slice(0, file.width)), file.encoding)

    return whole


@pytest.fixture(scope="session")
def demo_folder() -> Path:
    return Path(__file__).parents[2] / "examples" / "textures"


@pytest.fixture(scope="session")
def demo(demo_folder, folder_of_the_run):
    """The texture file of the demo, and its report, which the first worker that needs them makes."""
    folder = folder_of_the_run / "demo_texture"
    folder.mkdir(exist_ok=True)
    with FileLock(folder / "lock"):
        if not (folder / "report.json").exists():
            command = ["classify", str(demo_folder / "job.tmm.yaml"), "--out", str(folder), "--json"]
            result = CliRunner().invoke(main, command)
            assert result.exit_code == 0, result.output
            (folder / "report.json").write_text(result.output, encoding="utf-8")
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return folder / "yellowstone_road.tmm.h5", report["textures"][0]
