"""CITATION.cff states what pyproject.toml states."""

import tomllib
from pathlib import Path

import yaml

CHECKOUT = Path(__file__).parents[2]


def test_licence_and_version_are_those_of_the_package():
    """The citation format knows single licences and lists of alternatives, and no AND: the terms stand in the text."""
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((CHECKOUT / "CITATION.cff").read_text(encoding="utf-8"))
    assert " AND " in project["license"] and citation["message"].endswith(f": {project['license']}.")
    assert "license" not in citation and str(citation["version"]) == project["version"]
