"""The conda recipe asks for what the package asks for, in the same version."""

import re
import tomllib
from pathlib import Path

import yaml

CHECKOUT = Path(__file__).parents[2]
# Names of conda-forge where they are not those of PyPI.
CONDA = {"matplotlib": "matplotlib-base", "openimageio": "py-openimageio", "pvlib": "pvlib-python"}
WITHIN = "astronomy-engine"  # installed by the recipe's script


def test_the_recipe_is_in_step_with_the_project():
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))
    recipe = yaml.safe_load((CHECKOUT / ".ci/conda/recipe.yaml").read_text(encoding="utf-8"))
    needed = {}
    for text in project["project"]["dependencies"]:
        name, version = re.match(r"([\w-]+)>=([\w.]+)", text).groups()
        needed[CONDA.get(name.lower(), name.lower())] = version
    script = " ".join(recipe["build"]["script"])
    assert f"{WITHIN}>={needed.pop(WITHIN)}" in script
    asked = dict(text.split(" >=") for text in recipe["requirements"]["run"])
    assert asked.pop("python") == project["project"]["requires-python"].removeprefix(">=")
    assert asked == needed
    assert recipe["context"]["version"] == project["project"]["version"]
    assert recipe["about"]["license"] == project["project"]["license"]
    built_with = dict(text.split(" >=") for text in recipe["requirements"]["host"] if " >=" in text)
    assert all(tuple(text.split(">=")) in built_with.items() for text in project["build-system"]["requires"])
    points = {tuple(text.split(" = ")) for text in recipe["build"]["python"]["entry_points"]}
    assert points == set(project["project"]["scripts"].items())
    assert all((CHECKOUT / name).is_file() for name in recipe["about"]["license_file"])
