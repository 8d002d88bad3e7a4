"""Error against run time of the starter job, as `mat bench --json` prints it: kept, and shown in comparisons.md.

``mat bench --json | python tests/validation/bench_results.py`` writes the results file beside this module and the
tables of the page. A test holds the page to the file.
"""

import json
import sys
from pathlib import Path

from result_blocks import keep

RESULTS = Path(__file__).with_name("bench_results.json")
PAGE = Path(__file__).parents[2] / "examples" / "manual" / "comparisons.md"


def kept(result):
    """What of the output is kept: errors and times."""

    def number(entry):
        return float(f"{entry['value']:.3g}")

    return {
        "headline": result["sentences"][0],
        "rungs": [
            {
                "name": rung["name"] + (", modelled" if rung["modelled"] else ""),
                **{name: number(rung[name]) for name in ("error", "rms", "time", "uncertainty", "size")},
            }
            for rung in result["rungs"]
        ],
        "parts": [
            {"part": part["part"], "key": part["key"], "error": number(part["error"]), "saved": number(part["saved"])}
            for part in result["parts"]
            if part["saved"]["value"] is not None
        ],
        "peers": [
            {"units": peer["error"]["units"], **{name: peer[name] for name in ("work", "peer", "note")}}
            | {name: number(peer[name]) for name in ("error", "time", "time_of_this_job")}
            for peer in result["peers"]
        ],
    }


def _table(heads, rows):
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in lines) + "\n"


def block(result):
    """Text of the page between its marks."""
    rungs = [
        (
            rung["name"],
            rung["error"],
            rung["rms"],
            rung["time"] if not rung["uncertainty"] else f"{rung['time']} ± {rung['uncertainty']}",
            round(rung["size"] / 1e6, 1),
        )
        for rung in result["rungs"]
    ]
    parts = [(part["part"], part["key"], part["error"], part["saved"]) for part in result["parts"]]
    peers = [
        (
            peer["work"],
            peer["peer"],
            f"{peer['error']:.2g} {peer['units'].removeprefix('1')}".strip(),
            f"{peer['time']:.2g}",
            f"{peer['time_of_this_job']:.2g}",
            peer["note"],
        )
        for peer in result["peers"]
    ]
    return "\n".join(
        [
            f"{result['headline']}\n",
            _table(("setting", "99 % of pixels, K", "rms, K", "processor s", "MB"), rungs),
            _table(("the job as written, but", "key", "99 %, K", "saves, s"), parts),
            _table(("at an error that both reach", "peer", "error", "its s", "our s", "settings, and judge"), peers),
        ]
    )


if __name__ == "__main__":
    keep(kept(json.load(sys.stdin)), RESULTS, PAGE, block)
