"""Random small jobs over every key of the schema: what `mat check` accepts, `mat build` builds.

    python tests/validation/check_proves_build.py --count 200 --seconds 600

Each job is a small one with some of its keys drawn anew from the schema: limits, values between and just beyond them,
other kinds, long names, contradictions. A job that the check accepts is built where its estimate allows
that. Anything but one line of an `InputError` from the check, and anything but files from the build, is printed with
its job, and the exit status is 1. A build may say that no affordable grid meets a tolerance.
"""

from __future__ import annotations

import argparse
import copy
import json
import random
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path
from typing import Any

import yaml

import skyshine.schemas as schemas
from skyshine.mat.api.check import check
from skyshine.mat.builder.build import build
from skyshine.schemas.errors import CheckFailed, InputError

BASE = {
    "skyshine": 1,
    "name": "drawn",
    "site": {"latitude_deg": 45, "longitude_deg": 9, "date": "2026-07-01", "utc_offset_h": 1, "altitude_km": 0.1},
    "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [14, 28]}}],
    "bands": [{"wavelength_um": [10, 10.2]}],
    "materials": ["asphalt_road"],
    "atmosphere_grid": {
        "range_km": [0.01, 5],
        "altitude_km": [0.15, 3],
        "elevation_deg": [-90, 0, 90],
        "source_elevation_deg": [-10, 0, 60],
        "source_azimuth_deg": [0, 180],
    },
    "surface_grid": {"altitude_km": [0.1], "azimuth_deg": [0, 180], "slope_deg": [0, 90], "time": ["00:00", "12:00"]},
    "output": {"pictures": False},
}
LONGEST_BUILD = 12.0  # s by the estimate of the check
WORDS = (
    "sun",
    "moon",
    "none",
    "auto",
    "air",
    "file",
    "concrete",
    "water_sea",
    "12:00",
    "2026-02-30",
    "0.3 K",
    "a" * 300,
    "",
)


class Drawer:
    """Draws values of a JSON schema."""

    def __init__(self, schema: dict[str, Any], seed: int):
        self.schema, self.draw = schema, random.Random(seed)

    def value(self, schema: dict[str, Any], depth: int = 0) -> Any:
        """A value that mostly fits a schema."""
        if "$ref" in schema:
            return self.value(self.schema["$defs"][schema["$ref"].rpartition("/")[2]], depth)
        for key in ("anyOf", "oneOf"):
            if key in schema:
                return self.value(self.draw.choice(schema[key]), depth)
        if "enum" in schema or "const" in schema:
            return self.draw.choice(schema.get("enum", [schema.get("const")]))
        kind = schema.get("type")
        if kind in ("number", "integer"):
            return self._number(schema, kind == "integer")
        if kind == "array":
            return self._array(schema, depth)
        if kind == "object":
            return self._object(schema, depth)
        return self.draw.choice([True, False, None]) if kind in ("boolean", "null") else self.draw.choice(WORDS)

    def _number(self, schema: dict[str, Any], whole: bool) -> float:
        low = schema.get("minimum", schema.get("exclusiveMinimum", -1e3))
        high = schema.get("maximum", schema.get("exclusiveMaximum", 1e3))
        between = low + (high - low) * self.draw.random() ** self.draw.choice([1, 4])
        beyond = self.draw.choice([low - 1, high * 2 + 1, 0.0])
        chosen = self.draw.choice([low, high, between, between, between, beyond])
        return int(chosen) if whole else float(f"{chosen:.6g}")

    def _array(self, schema: dict[str, Any], depth: int) -> list[Any]:
        if "prefixItems" in schema:
            return [self.value(item, depth + 1) for item in schema["prefixItems"]]
        least = schema.get("minItems", 0)
        size = min(least + self.draw.choice([0, 1, 2]), schema.get("maxItems", 10**9))
        items = [self.value(schema.get("items", {}), depth + 1) for _ in range(size)]
        return sorted(items) if all(isinstance(item, float) for item in items) and self.draw.random() < 0.8 else items

    def _object(self, schema: dict[str, Any], depth: int) -> dict[str, Any]:
        keys = list(schema.get("properties", {}))
        if not keys:
            return {
                self.draw.choice(["asphalt_road", "concrete", "x"]): self.value(
                    schema.get("additionalProperties") or {}, depth + 1
                )
            }
        chosen = {*schema.get("required", []), *self.draw.sample(keys, min(len(keys), self.draw.choice([1, 1, 2, 3])))}
        return {key: self.value(schema["properties"][key], depth + 1) for key in chosen}

    def job(self) -> dict[str, Any]:
        """The base job with one to three keys drawn anew, at the top or within what is there."""
        job = copy.deepcopy(BASE)
        for _ in range(self.draw.choice([1, 1, 2, 3])):
            place, schema = job, self.schema
            while True:
                key = self.draw.choice(list(schema["properties"]))
                inner = schema["properties"][key]
                below = place.get(key)
                if isinstance(below, list) and below and isinstance(below[0], dict) and "items" in inner:
                    below, inner = below[0], inner["items"]
                while "$ref" in inner:
                    inner = self.schema["$defs"][inner["$ref"].rpartition("/")[2]]
                if isinstance(below, dict) and "properties" in inner and self.draw.random() < 0.9:
                    place, schema = below, inner
                    continue
                place[key] = self.value(inner)
                break
        return job


def outcome(job: dict[str, Any], folder: Path) -> tuple[str, str]:
    """What became of a job in a word, and the trace of a failure."""
    file = folder / "job.yaml"
    file.write_text(yaml.safe_dump(job), encoding="utf-8")
    try:
        checked = check(file)
    except InputError as error:
        return ("refused", "") if "\n" not in str(error) else ("FAILED: several lines", str(error))
    except Exception:
        return "FAILED in the check", traceback.format_exc()
    if sum(checked.seconds.values()) > LONGEST_BUILD:
        return "accepted, too long to build", ""
    try:
        build(checked.loaded, jobs=1)
    except CheckFailed as error:
        return ("no affordable grid", "") if "tolerance" in str(job) else ("FAILED in the build", str(error))
    except Exception:
        return "FAILED in the build", traceback.format_exc()
    missing = [name for name in checked.files if not (checked.loaded.output_folder / name).is_file()]
    return ("FAILED: files are missing", str(missing)) if missing else ("built", "")


def run(count: int, seed: int, seconds: float) -> tuple[Counter[str], list[str]]:
    """Outcomes of so many jobs, within a time; jobs that failed, with their traces."""
    drawer = Drawer(json.loads(schemas.path("mat-job.schema.json").read_text(encoding="utf-8")), seed)
    outcomes: Counter[str] = Counter()
    failures = []
    end = time.monotonic() + seconds
    for _ in range(count):
        job = drawer.job()
        with tempfile.TemporaryDirectory() as folder:
            word, trace = outcome(job, Path(folder))
        outcomes[word] += 1
        if word.startswith("FAILED"):
            failures.append(f"{word}\n{yaml.safe_dump(job)}\n{trace}")
            print(failures[-1], flush=True)
        if time.monotonic() > end:
            break
    return outcomes, failures


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1800.0)
    given = parser.parse_args()
    outcomes, failures = run(given.count, given.seed, given.seconds)
    print(", ".join(f"{number} {word}" for word, number in outcomes.most_common()))
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
