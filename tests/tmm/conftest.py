"""Small textures written to disk as their formats are, and the library that gives codes."""

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from skyshine.materials.library import load_library
from skyshine.tmm.job import TextureJob


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


@pytest.fixture(scope="session")
def demo_folder() -> Path:
    return Path(__file__).parents[2] / "examples" / "textures"
