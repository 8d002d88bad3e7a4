"""Our glTF before the Khronos validator, the npm package gltf-validator, wherever node finds it (NODE_PATH)."""

import json
import shutil
import subprocess

import numpy as np
import pytest

from skyshine.tmm.database.levels import pure_level
from skyshine.tmm.exchange.gltf import write_gltf
from skyshine.tmm.exchange.gltf_mesh import write_mesh
from skyshine.tmm.exchange.image import MaterialImage

pytestmark = pytest.mark.validation

PROGRAM = """
const validator = require('gltf-validator'), fs = require('fs'), path = require('path'), file = process.argv[1];
const read = name => new Uint8Array(fs.readFileSync(name));
validator.validateBytes(read(file), {externalResourceFunction: uri => Promise.resolve(read(path.join(path.dirname(file), uri)))})
  .then(report => console.log(JSON.stringify(report)));
"""  # noqa: E501


@pytest.fixture(scope="module")
def node() -> str:
    program = shutil.which("node")
    if program is None:
        pytest.skip("node is not installed")
    if subprocess.run([program, "-e", "require('gltf-validator')"], capture_output=True).returncode:
        pytest.skip("node finds no gltf-validator: npm install gltf-validator, and set NODE_PATH")
    return program


def test_a_mesh_of_the_users_own(node, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    from PIL import Image

    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=Image.fromarray(np.full((8, 8, 3), 90, np.uint8)))
    visual = trimesh.visual.TextureVisuals(uv=corners[:, :2], material=material)
    mesh = trimesh.Trimesh(corners, [[0, 1, 2]], process=False, visual=visual)
    (tmp_path / "mesh.glb").write_bytes(trimesh.Scene(mesh).export(file_type="glb"))
    code = np.random.default_rng(0).integers(0, 4, (8, 8)).astype(np.uint16)
    image = MaterialImage("texture", {k: f"material_{k}" for k in range(1, 4)}, pure_level(code))
    before, after = (
        json.loads(subprocess.run([node, "-e", PROGRAM, str(path)], capture_output=True, text=True, check=True).stdout)
        for path in (tmp_path / "mesh.glb", *write_mesh(tmp_path / "out", image, tmp_path / "mesh.glb"))
    )
    assert after["issues"]["numErrors"] == 0, after["issues"]["messages"]
    assert after["issues"]["numWarnings"] <= before["issues"]["numWarnings"], after["issues"]["messages"]


@pytest.mark.parametrize("count", [1, 3, 300])
def test_no_error_and_no_warning(node, count, tmp_path):
    code = np.random.default_rng(count).integers(0, count + 1, (64, 128)).astype(np.uint16)
    image = MaterialImage("texture", {k: f"material_{k}" for k in range(1, count + 1)}, pure_level(code))
    found = subprocess.run(
        [node, "-e", PROGRAM, str(write_gltf(tmp_path, image)[0])], capture_output=True, text=True, check=True
    )
    issues = json.loads(found.stdout)["issues"]
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]
