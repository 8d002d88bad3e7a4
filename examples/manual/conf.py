"""Settings of Sphinx for the documentation site, which `python -m mat.maintain.manual` builds."""

from importlib.metadata import version as installed
from typing import Any

project = "skyshine"
release = version = installed("skyshine")
html_title = f"skyshine {release}"
root_doc = "index"
extensions = ["myst_nb", "sphinx_copybutton", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]

# Pages are read where no network is: the theme brings its own scripts and takes the fonts of the system, and widgets,
# which load a script of theirs, are off.
html_theme = "furo"
html_static_path = ["style"]
html_css_files = ["manual.css"]
html_copy_source = html_show_sourcelink = html_show_copyright = False
nb_ipywidgets_js: dict[str, Any] = {}

myst_heading_anchors = 4
nb_execution_mode = "off"  # notebooks have what their cells showed: python -m mat.maintain.notebooks
nb_merge_streams = True

default_role = "code"  # docstrings have one backtick around names
napoleon_google_docstring = False
napoleon_use_param = napoleon_use_rtype = False  # types are words, no links
toc_object_entries = False  # each has a heading of its name already
autodoc_typehints = "none"  # docstrings name types and units
autodoc_member_order = "bysource"
autodoc_class_signature = "separated"
pygments_style, pygments_dark_style = "friendly", "monokai"
