"""Runs the notebooks of the examples and keeps what their cells show, for readers of the checkout and of the site; it
needs the extra ``docs``.

Run ``python -m mat.maintain.notebooks`` after a change that alters results, and look at the figures.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

FOLDER = Path(__file__).parents[2] / "examples" / "notebooks"
DOTS_PER_INCH = 72  # dots per inch of figures; a notebook stays below 400 kB
SETTINGS = f"import matplotlib.pyplot as plt\nplt.rcParams['figure.dpi'] = {DOTS_PER_INCH}"
TIMEOUT = 900  # s of a cell, on a busy machine


def run(path: Path) -> None:
    """Run the cells of a notebook in order and write it with their outputs.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        A cell fails.
    """
    notebook = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    notebook.cells.insert(0, nbformat.v4.new_code_cell(SETTINGS))  # type: ignore[no-untyped-call]
    NotebookClient(notebook, timeout=TIMEOUT, kernel_name="python3").execute()
    del notebook.cells[0]
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    for number, cell in enumerate(code, 1):
        cell.execution_count = number
        cell.metadata.pop("execution", None)
        cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]  # progress and logs
        for output in cell.outputs:
            if "execution_count" in output:
                output.execution_count = number
            data = output.get("data", {})
            for kind in data:
                if kind.startswith("text/"):
                    data[kind] = "<Figure>" if "image/png" in data else _without_folders(data[kind])
            if "text" in output:
                output.text = _without_folders(output.text)
    notebook.metadata.pop("language_info", None)
    nbformat.write(notebook, path)  # type: ignore[no-untyped-call]


def _without_folders(text: str) -> str:
    """Text without names of temporary folders."""
    return re.sub(rf"{re.escape(tempfile.gettempdir())}/[\w-]+", "FOLDER", text)


if __name__ == "__main__":
    for path in sorted(FOLDER.glob("*.ipynb")):
        run(path)
