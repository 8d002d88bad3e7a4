"""OpenMATERIAL 3D: what its schemas and checker rules (annex A of 1.1.0) ask, and the light that is reflected."""

import json
import math
import re

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.commands.openmaterial import command
from skyshine.mat.exchange.openmaterial import write_openmaterial
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

CHOSEN = ("concrete", "paint_white_on_metal", "glass_window")
# "metadata" of material_schema.json, material_brdf_schema.json and mapping_schema.json: required, and their patterns.
REQUIRED = {"name", "uuid", "openMaterial3dVersion", "copyrights", "license", "authors"}
UUID = r"\b[0-9a-fA-F]{8}-[0-9a-fA-F]{4}-[0-9a-fA-F]{4}-[0-9a-fA-F]{4}-[0-9a-fA-F]{12}\b$"
SEMANTIC = r"^\d+\.\d+\.\d+$"
# Columns of a BRDF table: wavelength [m], incident and exit zenith, exit azimuth [rad], BRDF [1/sr].
LIMITS = ((1e-9, 17.16e-3), (0, 1.570796), (0, 1.570796), (0, 6.283185), (0, math.inf))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("openmaterial")
    write_openmaterial(load_library(), CHOSEN, out)
    return out


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", [f"{m}{end}" for m in CHOSEN for end in (".xomp", "_brdf.xompt")] + ["materials.xomm"])
def test_files_keep_the_rules_of_the_standard(folder, name):
    kind = {"xomp": "material", "xompt": "material_brdf", "xomm": "mapping"}[name.split(".")[-1]]
    second = (folder / name).read_text(encoding="utf-8").splitlines()[1]
    tag = "https://raw.githubusercontent.com/asam-ev/OpenMATERIAL-3D/refs/tags/v1.1.0/schemas"
    assert second.strip() == f'"$schema": "{tag}/{kind}_schema.json",'
    metadata = read(folder / name)["metadata"]
    version = "mappingVersion" if kind == "mapping" else "materialVersion"
    assert set(metadata) >= REQUIRED | {version} | ({"sources"} if kind == "material_brdf" else set())
    assert re.search(UUID, metadata["uuid"])
    assert re.search(SEMANTIC, metadata[version]) and re.search(SEMANTIC, metadata["openMaterial3dVersion"])
    assert all(isinstance(metadata[key], list) and metadata[key] for key in ("copyrights", "authors"))
    assert all(isinstance(text, str) and text for key in ("copyrights", "authors") for text in metadata[key])


@pytest.mark.parametrize("name", CHOSEN)
def test_a_material_names_files_that_are_there_and_sources(folder, name):
    properties = read(folder / f"{name}.xomp")["materialProperties"]
    assert all(re.search(r".*_brdf\.xompt$", uri) and (folder / uri).is_file() for uri in properties["brdfUris"])
    emission, density = properties["emissivityData"], properties["densityData"]
    assert 0 <= emission["emissivityCoefficient"] <= 1 and emission["temperature"] == 300
    assert 0 <= density["density"] <= 25000 and density["sources"] and emission["sources"]


@pytest.mark.parametrize("name", CHOSEN)
def test_a_table_is_sorted_within_limits_and_its_light_is_the_diffuse_share(folder, name):
    brdf = read(folder / f"{name}_brdf.xompt")["brdf"]
    table, rows = np.array(brdf["lookupTable"]), brdf["lookupTable"]
    assert rows == sorted(rows) and table.shape[1] == 5
    assert all(
        low <= column.min() and column.max() <= high for column, (low, high) in zip(table.T, LIMITS, strict=True)
    )
    assert brdf["wavelengths"] == sorted(set(table[:, 0].tolist()))
    material = load_library()[name]
    # The integral of f cos over the hemisphere, by the midpoint rule, of a value that is the same in all corners.
    values = table[:, 4].reshape(len(brdf["wavelengths"]), -1)
    assert np.all(values == values[:, :1])
    zenith = (np.arange(200) + 0.5) * math.pi / 400
    solid = 2 * math.pi * np.sum(np.cos(zenith) * np.sin(zenith)) * math.pi / 400
    share = material.reflectance * (1 - material.specular_fraction)
    assert values[:, 0] * solid == pytest.approx(share, abs=5e-5)
    own = read(folder / f"{name}.xomp")["materialProperties"]["customProperties"]["skyshine"]
    assert own["specularFraction"] == material.specular_fraction and own["lobeFwhmDegree"] == material.lobe_fwhm


def test_known_emissivities(tmp_path):
    """Polished aluminium .04 to .1, white paint .9 to .96: Incropera, Fundamentals of Heat and Mass Transfer, A.11."""
    write_openmaterial(load_library(), ["aluminium_polished", "paint_white_on_metal"], tmp_path)

    def emissivity(name):
        return read(tmp_path / f"{name}.xomp")["materialProperties"]["emissivityData"]["emissivityCoefficient"]

    assert emissivity("aluminium_polished") < 0.1 and 0.9 < emissivity("paint_white_on_metal") < 0.97


def test_the_same_materials_give_the_same_bytes(folder, tmp_path):
    CliRunner().invoke(command, [*CHOSEN, "--out", str(tmp_path)], catch_exceptions=False)
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == {p.name: p.read_bytes() for p in tmp_path.iterdir()}


def test_an_unknown_material_is_one_line_and_writes_nothing(tmp_path):
    with pytest.raises(InputError, match="concret"):
        write_openmaterial(load_library(), ["concret"], tmp_path)
    assert not list(tmp_path.iterdir())
