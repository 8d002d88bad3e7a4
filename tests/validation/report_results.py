"""Error of a pixel of the examples, as `mat report` measures it: run, kept, and shown in mat/physics.md.

Run by itself it builds the jobs of `RUNS` in FOLDER, or takes what is finished there, and writes `report_results.json`
beside this module and the table of the page: ``python tests/validation/report_results.py FOLDER``. A test holds the
page to the file.
"""

import json
import subprocess
import sys
from pathlib import Path

from result_blocks import keep

RESULTS = Path(__file__).with_name("report_results.json")
PAGE = Path(__file__).parents[2] / "mat" / "physics.md"
RUNS = (("street", 2, 40), ("street", 1, 12), ("starter", 2, 12))  # example, band, scenes of each source
LEFT_OUT = ("tables", "face", "transmittance_extrapolation", "radiance_extrapolation")  # parts and sums of other rows
UNMODELLED = ("aureole", "seen_faces", "lobe", "depth_buffer", "aliasing")
VERTICES = ("vertices_centre", "vertices_nearest")
# Not among the sources of the pixel.
LAST = ("pixel", "all", *UNMODELLED, *VERTICES, "weather_of_the_air", "misclassification")
LEAST_K = 0.005  # largest error of any run below which a source has no row
MEASURES = ("rms", "p99", "maximum")


def measured(folder):
    """Errors of every run by source, in kelvin, with what was run."""
    return [entry for run in RUNS for entry in of_run(Path(folder), *run)]


def of_run(folder, example, band, scenes):
    """Entries of one run, one for each source; those that FOLDER holds are taken from there."""
    import skyshine.mat

    kept = folder / f"{example}_{band}.json"
    if kept.is_file():
        return json.loads(kept.read_text(encoding="utf-8"))
    job = folder / example / "job.yaml"
    if not job.is_file():
        init = "from skyshine.mat.cli import main; main()", "init", str(job.parent), "--example", example
        subprocess.run([sys.executable, "-c", *init], check=True, stdout=subprocess.DEVNULL)
    skyshine.mat.build(job, pictures=False)
    budgets = skyshine.mat.report(job, band=band, scenes=scenes).numbers["budgets"]
    entries = [
        {
            "example": example,
            "band": band,
            "wavelength_um": [round(limit, 3) for limit in budget["wavelength"]["values"]],
            "source": budget["source"],
            "views": budget["views"],
            "materials": len(budget["materials"]),
            "errors": {
                name: {"what": error["what"]} | {key: _rounded(error["temperature"][key]["value"]) for key in MEASURES}
                for name, error in budget["errors"].items()
            },
        }
        for budget in budgets
    ]
    kept.write_text(json.dumps(entries) + "\n", encoding="utf-8")
    return entries


def block(results):
    """Text of the page between its marks: what was run, and a row a source, largest first."""
    heads, runs = [], []
    for run in results:
        low, high = run["wavelength_um"]
        heads.append(f"{run['example']}, {low:g} to {high:g} um, {run['source'].capitalize()}")
        runs.append(f"{run['views']} views of {run['materials']} materials")
    known = {name: error["what"] for run in results for name, error in run["errors"].items()}

    def size(name):
        return max(run["errors"][name]["rms"] for run in results if name in run["errors"])

    def largest(name):
        return max(run["errors"][name]["maximum"] for run in results if name in run["errors"])

    sources = [name for name in known if name not in (*LEFT_OUT, *LAST)]
    rows = sorted((name for name in sources if largest(name) >= LEAST_K), key=size, reverse=True)
    rows += [name for name in LAST if name in known]
    lines = [f"| source; rms, 99 %, largest, K | {' | '.join(heads)} |", "|---" * (len(heads) + 1) + "|"]
    lines.append(f"| | {' | '.join(runs)} |")
    for name in rows:
        cells = [_cell(run["errors"].get(name)) for run in results]
        lines.append(f"| {known[name]} | {' | '.join(cells)} |")
    small = [known[name] for name in sources if largest(name) < LEAST_K]
    note = f"\nAt most {LEAST_K:g} K: {'; '.join(small)}.\n" if small else ""
    return "\n".join(lines) + "\n" + note


def _cell(error):
    return "" if error is None else ", ".join("-" if error[key] is None else f"{error[key]:.2g}" for key in MEASURES)


def _rounded(value):
    return None if value is None else round(value, 4)  # no percentile of few pixels


if __name__ == "__main__":
    keep(measured(sys.argv[1]), RESULTS, PAGE, block)
