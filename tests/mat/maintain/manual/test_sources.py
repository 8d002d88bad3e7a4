"""The tree of the site: links to folders and files, pages in the navigation."""

import pytest

from mat.maintain.manual import python_pages, sources


@pytest.fixture
def checkout(tmp_path):
    """A small checkout with a page for each rule."""
    files = {
        "examples/manual/index.md": "# Site\n\n```{toctree}\nREADME\n```\n",
        "README.md": "# Top\n\n[m](materials) [n](materials/) [file](schemas/a.json#L3) ![p](examples/pictures/p.png)\n"
        "[page](materials/README.md#b) [here](#top) [out](https://example.org/materials)\n",
        "materials/README.md": "# M\n",
        "schemas/a.json": "{}",
        "schemas/formats/README.md": "# Formats\n",
        "schemas/formats/z-1.md": "# z\n",
        "schemas/formats/a-1.md": "# a\n",
        "examples/pictures/p.png": "picture",
        "tests/hidden.md": "# Not of the site\n",
    }
    for name, text in files.items():
        (tmp_path / "checkout" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "checkout" / name).write_text(text, encoding="utf-8")
    return tmp_path / "checkout"


@pytest.fixture
def tree(checkout, tmp_path, monkeypatch):
    monkeypatch.setattr(sources, "generated_pages", lambda: {"reference/a.md": "# A\n"})
    (tmp_path / "tree").mkdir()
    sources.gather(checkout, tmp_path / "tree")
    return tmp_path / "tree"


def test_links_to_folders_lead_to_their_pages(tree):
    text = (tree / "README.md").read_text(encoding="utf-8")
    assert text.count("(materials/README.md)") == 2
    assert "(materials/README.md#b)" in text and "(#top)" in text and "(https://example.org/materials)" in text


def test_links_follow_pages_that_stand_elsewhere_in_the_site(checkout, tmp_path, monkeypatch):
    """Pages of the site alone stand at its top: links to them and from them hold in the checkout and in the site."""
    monkeypatch.setattr(sources, "generated_pages", dict)
    pages = {
        "mat/physics.md": "# P\n\n[t](../examples/manual/tutorials/a.md) [l](../examples/manual/limits.md#x)\n",
        "examples/manual/limits.md": "# L\n\n[p](../../mat/physics.md#p) [a](tutorials/a.md)\n",
        "examples/manual/tutorials/a.md": "# A\n\n[p](../../../mat/physics.md) [l](../limits.md) [k](../ref/k.md)\n",
    }
    for name, text in pages.items():
        (checkout / name).parent.mkdir(parents=True, exist_ok=True)
        (checkout / name).write_text(text, encoding="utf-8")
    tree = tmp_path / "tree"
    tree.mkdir()
    sources.gather(checkout, tree)
    assert "[t](../tutorials/a.md) [l](../limits.md#x)" in (tree / "mat" / "physics.md").read_text(encoding="utf-8")
    assert "[p](mat/physics.md#p) [a](tutorials/a.md)" in (tree / "limits.md").read_text(encoding="utf-8")
    a = (tree / "tutorials" / "a.md").read_text(encoding="utf-8")
    assert "[p](../mat/physics.md) [l](../limits.md) [k](../ref/k.md)" in a


def test_files_that_pages_show_or_link_to_stand_beside_them(tree):
    assert (tree / "schemas" / "a.json").is_file() and (tree / "examples" / "pictures" / "p.png").is_file()


def test_pages_of_the_folders_enter_and_others_do_not(tree):
    pages = {path.relative_to(tree).as_posix() for path in tree.rglob("*.md")}
    formats = {f"schemas/formats/{name}.md" for name in ("README", "a-1", "z-1")}
    assert pages == {"index.md", "README.md", "materials/README.md", "reference/a.md", *formats}


def test_the_page_of_a_leading_folder_leads_to_the_others(tree):
    text = (tree / "schemas" / "formats" / "README.md").read_text(encoding="utf-8")
    assert "```{toctree}\n:hidden:\na-1.md\nz-1.md\n```" in text
    assert "toctree" not in (tree / "materials" / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("package", python_pages.PACKAGES)
def test_the_page_of_a_package_has_each_public_name(package):
    text = python_pages.page(package)
    module = python_pages.importlib.import_module(package)
    assert [name for name in module.__all__ if f":: {package}.{name}\n" not in text] == []
