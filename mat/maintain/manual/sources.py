"""The tree that Sphinx reads: pages of the checkout in their places, pages of the site alone, generated pages."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

from mat.maintain.manual import command_pages, python_pages, reader_page

OWN = "examples/manual"  # pages of the site alone, shown at its top
NOTEBOOKS = "examples/notebooks"
LEADING = ("atmospheres", "examples/runtimes", "schemas/formats")  # their README leads to all pages below
FOLDERS = ("mat", "tmm", "materials", "atmospheres", "schemas", "examples")
LINK = re.compile(r"(?<=\]\()([^()\s]+)(?=\))")


def checkout_pages(checkout: Path) -> list[str]:
    """Pages of the checkout by their paths, those at its top first."""
    below = [path for folder in FOLDERS for path in (checkout / folder).rglob("*.md")]
    pages = [path.relative_to(checkout).as_posix() for path in [*checkout.glob("*.md"), *below]]
    return sorted((page for page in pages if not page.startswith(f"{OWN}/")), key=lambda page: ("/" in page, page))


def generated_pages() -> dict[str, str]:
    """Texts of the pages that are made from readers, commands and docstrings, by their paths in the site."""
    pages = {reader_page.PAGE: reader_page.page()}
    pages |= {f"reference/commands/{name}.md": command_pages.page(name) for name in command_pages.GROUPS}
    return pages | {f"reference/python/{name}.md": python_pages.page(name) for name in python_pages.PACKAGES}


def gather(checkout: Path, tree: Path) -> None:
    """Write the tree that Sphinx reads.

    Parameters
    ----------
    tree : Path
        An empty folder.
    """
    shutil.copytree(checkout / OWN, tree, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    manual_pages = [path.relative_to(checkout).as_posix() for path in sorted((checkout / OWN).rglob("*.md"))]
    for page in [*checkout_pages(checkout), *manual_pages]:
        text = (checkout / page).read_text(encoding="utf-8")
        for file in linked_files(text, checkout, page):
            _copy(checkout / file, tree / _in_site(file))
        _write(tree / _in_site(page), links_of_site(text, checkout, page) + leads(page, checkout))
    for name, text in generated_pages().items():
        _write(tree / name, text)
    for path in (checkout / NOTEBOOKS).glob("*.ipynb"):
        _copy(path, tree / NOTEBOOKS / path.name)


def leads(page: str, checkout: Path) -> str:
    """Entries of the navigation below a page: those of its folder, if it is one that leads to them."""
    folder = os.path.dirname(page)
    if folder not in LEADING or not page.endswith("/README.md"):
        return ""
    below = [path.relative_to(checkout / folder).as_posix() for path in (checkout / folder).rglob("*.md")]
    entries = sorted(name for name in below if name != "README.md")
    return "\n".join(["", "```{toctree}", ":hidden:", *entries, "```", ""])


def linked_files(text: str, checkout: Path, page: str) -> Iterator[str]:
    """Files of the checkout that a page links to or shows and that are no pages themselves."""
    for target in LINK.findall(text):
        path = _place(page, target)
        if (checkout / path).is_file() and not path.endswith(".md"):
            yield path


def links_of_site(text: str, checkout: Path, page: str) -> str:
    """The text of a page with its links as the site has them: to the pages that describe folders, in their places.

    Links that lead nowhere in the checkout, such as those of pages of the site alone to generated ones, stay.
    """

    def lead(match: re.Match[str]) -> str:
        if match[1].startswith("#") or "://" in match[1]:
            return match[1]
        path, anchor = _place(page, match[1]), match[1].partition("#")[2]
        if (checkout / path).is_dir() and (checkout / path / "README.md").is_file():
            path += "/README.md"
        if not (checkout / path).is_file():
            return match[1]
        link = os.path.relpath(_in_site(path), os.path.dirname(_in_site(page)) or ".").replace(os.sep, "/")
        return f"{link}#{anchor}" if anchor else link

    return LINK.sub(lead, text)


def _in_site(path: str) -> str:
    """Path in the site of a path in the checkout."""
    return path.removeprefix(f"{OWN}/")


def _place(page: str, target: str) -> str:
    """Path in the checkout that a link of a page leads to."""
    return os.path.normpath(os.path.join(os.path.dirname(page), target.partition("#")[0])).replace(os.sep, "/")


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def _write(target: Path, text: str) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(text, encoding="utf-8")
