"""Requests of a page to other machines when a browser opens it."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

# Attributes by which a browser loads something without a click; links (`a`) are the reader's choice.
LOADS = {
    "link": ("href",),
    "script": ("src",),
    "img": ("src", "srcset"),
    "iframe": ("src",),
    "source": ("src", "srcset"),
    "video": ("src", "poster"),
    "audio": ("src",),
    "embed": ("src",),
    "object": ("data",),
}
PLAIN_LINKS = {"canonical", "license", "author"}  # `link` elements that name a page and load nothing
_OUTSIDE = re.compile(r"^\s*(?:[a-z][a-z0-9+.-]*:)?//", re.IGNORECASE)
_IMPORT = re.compile(r"""(?:url\(\s*|@import\s+)["']?((?:https?:)?//[^"')\s]+)""", re.IGNORECASE)


class _Loads(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        has = dict(attrs)
        if tag == "link" and PLAIN_LINKS & set((has.get("rel") or "").split()):
            return
        for name in LOADS.get(tag, ()):
            if _OUTSIDE.match(has.get(name) or ""):
                self.found.append(f"<{tag} {name}={has[name]}>")
        self.found += _IMPORT.findall(has.get("style") or "")


def requests_of_html(text: str) -> list[str]:
    """What a page loads from other machines.

    Examples
    --------
    >>> requests_of_html('<script src="https://cdn.org/a.js"></script><a href="https://b.org">b</a><img src="c.png">')
    ['<script src=https://cdn.org/a.js>']
    """
    reader = _Loads()
    reader.feed(text)
    return reader.found + [f"style: {url}" for url in _IMPORT.findall(text)]


def requests_of_folder(folder: Path) -> list[str]:
    """What the pages and style sheets of a folder load from other machines, each with its file."""
    requests = []
    for path in sorted(folder.rglob("*")):
        if path.suffix in (".html", ".css"):
            text = path.read_text(encoding="utf-8")
            loads = requests_of_html(text) if path.suffix == ".html" else _IMPORT.findall(text)
            requests += [f"{path.relative_to(folder)}: {load}" for load in loads]
    return requests
