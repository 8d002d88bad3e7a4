"""Pages of the Python packages: the public functions by their docstrings, and the classes of what they return."""

from __future__ import annotations

import importlib
import inspect
import typing
from types import ModuleType

PACKAGES = ("skyshine.mat", "skyshine.tmm")


def page(package: str) -> str:
    """Text of the page of a package, whose docstrings Sphinx fills in.

    Parameters
    ----------
    package : str
        One of `PACKAGES`.
    """
    module = importlib.import_module(package)
    results = result_classes(module)
    lines = [f"# Python: `{package}`", "", *_directive("automodule", package)]
    for name in module.__all__:
        kind = "autoclass" if inspect.isclass(getattr(module, name)) else "autofunction"
        lines += ["", f"## `{name}`", "", *_directive(kind, f"{package}.{name}")]
    lines += ["", "## What the functions return"]
    for result in results:
        lines += [
            "",
            f"### `{result.__name__}`",
            "",
            *_directive("autoclass", f"{result.__module__}.{result.__name__}"),
        ]
    return "\n".join(lines) + "\n"


def result_classes(module: ModuleType) -> list[type]:
    """Classes of this package that public functions return, alone or in lists, but for public ones; in their order."""
    public = [getattr(module, name) for name in module.__all__]
    classes: list[type] = []
    for function in public:
        if inspect.isfunction(function):
            classes += _classes(typing.get_type_hints(function).get("return"))
    return [kind for kind in dict.fromkeys(classes) if kind not in public]


def _classes(hint: typing.Any) -> list[type]:
    inner = [kind for part in typing.get_args(hint) for kind in _classes(part)]
    is_class = inspect.isclass(hint) and hint.__module__.startswith("skyshine.") and not typing.get_args(hint)
    return [hint, *inner] if is_class else inner


def _directive(kind: str, target: str) -> list[str]:
    members = ["   :members:"] if kind == "autoclass" else []
    return ["```{eval-rst}", f".. {kind}:: {target}", *members, "```"]
