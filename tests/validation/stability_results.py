"""Extreme cases by kind, as `mat bench stability --json` prints them: kept, and shown in mat/physics.md.

``mat bench stability --seconds 300 --json | python tests/validation/stability_results.py`` writes the results file
beside this module and the table of the page. A test holds the page to the file.
"""

import json
import sys
from pathlib import Path

from result_blocks import keep

RESULTS = Path(__file__).with_name("stability_results.json")
PAGE = Path(__file__).parents[2] / "mat" / "physics.md"


def kept(result):
    """What of the output is kept: the kinds, and the measure of each that uses most of its limit."""
    worst = {}
    for entry in result["worst"]:  # the worst first
        worst.setdefault(entry["kind"], {key: entry[key] for key in ("measure", "value", "limit", "margin", "again")})
    return {
        "seed": result["seed"],
        "kinds": {
            kind: {
                "cases": values["cases"],
                "refused": values["refused"],
                "failures": len(values["failures"]),
                "processor_s": round(values["time"]["value"], 2),
                **worst.get(kind, {}),
            }
            for kind, values in result["kinds"].items()
        },
    }


def block(result):
    """Text of the page between its marks: a row a kind."""
    lines = [
        "| kind | cases | rightly refused | failed | processor s a case | nearest to its limit | value | limit |",
        "|---" * 8 + "|",
    ]
    for kind, row in result["kinds"].items():
        nearest = [row["measure"], f"{row['value']:.2g}", f"{row['limit']:.2g}"] if "measure" in row else ["", "", ""]
        cells = [
            kind,
            row["cases"],
            row["refused"],
            row["failures"],
            f"{row['processor_s'] / row['cases']:.2g}",
            *nearest,
        ]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    keep(kept(json.load(sys.stdin)), RESULTS, PAGE, block)
