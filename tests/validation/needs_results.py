"""What the needs of a scene save, as `python -m mat.maintain.bench.scene_needs` wrote it: shown in mat/physics.md.

``PYTHONPATH=. python tests/validation/needs_results.py`` writes the table of the page from `needs_results.json` beside
this module. A test compares the page with it.
"""

import json
from pathlib import Path

from result_blocks import keep

from mat.maintain.bench.scene_needs import shares

RESULTS = Path(__file__).with_name("needs_results.json")
PAGE = Path(__file__).parents[2] / "mat" / "physics.md"


def block(results):
    """Text of the page between its marks: a row a scene."""
    lines = [
        "| scene | processor s, whole job | with needs | share | MB, whole job | with needs | share | largest"
        " difference of a read over its bound |",
        "|---" * 8 + "|",
    ]
    for name, result in results.items():
        whole, less, share = result["without_needs"], result["with_needs"], shares(result)
        seconds = [f"{whole['processor_s']:.1f}", f"{less['processor_s']:.1f}", f"{share['seconds']:.2f}"]
        size = [f"{whole['bytes'] / 1e6:.2f}", f"{less['bytes'] / 1e6:.2f}", f"{share['bytes']:.2f}"]
        lines.append("| " + " | ".join([name, *seconds, *size, f"{share['difference']:.2f}"]) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    keep(json.loads(RESULTS.read_text(encoding="utf-8")), RESULTS, PAGE, block)
