"""The pages of the file formats say what the layouts say, and the layouts what the files say."""

import json

import pytest

from mat.maintain.format_pages import layout_names, page
from skyshine import schemas
from skyshine.schemas.hdf5 import read_file

FOLDER = schemas.path("formats").parent
REMEDY = "run: python -m mat.maintain.format_pages schemas BUILT/*.h5"


@pytest.mark.parametrize("name", layout_names(FOLDER))
def test_each_page_is_the_one_of_its_layout(pytestconfig, name):
    layout = json.loads((FOLDER / f"{name}.layout.json").read_text(encoding="utf-8"))
    pages = pytestconfig.rootpath / "schemas" / "formats"
    assert (pages / f"{name}.md").read_text(encoding="utf-8") == page(layout, name), REMEDY


@pytest.mark.parametrize("file", ["s01.htt.h5", "s01b01.atmq.h5", "s01b01.lunar_atmq.h5", "b01.band.h5"])
def test_each_field_is_described_as_in_the_file(small_build, file):
    root, attributes = read_file(small_build / file)
    layout = json.loads(schemas.path(f"{attributes['filetype']}-1.layout.json").read_text(encoding="utf-8"))

    def compare(group, content):
        for kind, items in (("axes", group.axes), ("variables", group.variables)):
            for name, item in items.items():
                rule = content[kind]["properties"][name]
                assert rule.get("description") == item.long_name, f"{name}: {REMEDY}"
                read = rule["properties"].get("interpolation", {})
                assert item.attributes.get("interpolation") in read.get("enum", [read.get("const")]), name
        for name, child in group.groups.items():
            compare(child, content["groups"]["properties"][name]["properties"])

    compare(root, layout["properties"])
