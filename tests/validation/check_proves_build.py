"""Random small jobs over every key of the schema: what `mat check` accepts, `mat build` builds.

    python tests/validation/check_proves_build.py --count 200 --seconds 600

Each job is a small one with some of its keys drawn anew from the schema: limits, values between and just beyond them,
other kinds, long names, contradictions; half of them are accepted. Those are built where their estimate allows that, in
this process and along few lines of sight, as tests are. Anything but one line of an `InputError` from the check, and
anything but files from the build, is printed with its job, and the exit status is 1. 200 jobs take six minutes of
processor time with the environment variable SKYSHINE_CACHE, without which each band is compiled again.
"""

from __future__ import annotations

import argparse
import copy
import importlib.util
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
from skyshine.schemas.errors import InputError

TESTS = Path(__file__).parents[1]
sys.path.insert(0, str(TESTS / "fuzz"))
import readers

_suite = importlib.util.spec_from_file_location("suite", TESTS / "conftest.py")
suite = importlib.util.module_from_spec(_suite)
_suite.loader.exec_module(suite)

BASE = {
    "skyshine": 1,
    "name": "drawn",
    "site": {"latitude_deg": 45, "longitude_deg": 9, "date": "2026-07-01", "utc_offset_h": 1, "altitude_km": 0.1},
    "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [14, 28]}}],
    "bands": [{"wavelength_um": [10, 10.2]}],
    "sources": ["sun"],
    "materials": ["asphalt_road", "soil_sand", "shrub"],
    "atmosphere_grid": {
        "tolerance": "5 K",
        "range_km": [0.01, 5],
        "altitude_km": [0.15, 3],
        "elevation_deg": [-90, 0, 90],
        "source_elevation_deg": [-10, 0, 60],
        "source_azimuth_deg": [0, 180],
    },
    "surface_grid": {"altitude_km": [0.1], "azimuth_deg": [0, 180], "slope_deg": [0, 90], "time": ["00:00", "12:00"]},
    "output": {"pictures": False},
}
LONGEST_BUILD = 60.0  # s by the estimate of the check; of the lines of sight of a test it takes a fifth
WRONG = 0.02  # share of the values that are of another kind or beyond their limits
DEEPER = 0.9  # share of the drawn keys that are within what the base has, and not the whole of it
MATERIALS = ("asphalt_road", "concrete", "grass_green", "water_sea", "soil_sand", "shrub")
TIMES = ("00:00", "06:30", "12:00", "23:59:59")
TOLERANCES = ("0.5 K", "5 K", "3 %", "1e-3 W m^-2 sr^-1", "0.05 K")
ODD = ("", "x", "12:00", "2026-02-30", "0.3 K", "a" * 300, None, True, -1, [], {})
FILES = {
    "sounding.csv": readers.SOUNDING,
    "weather.csv": readers.DAY,
    "year.epw": readers.EPW,
    "response.csv": readers.RESPONSE,
    "series.csv": readers.ENSEMBLE,
}
# Words of the keys that are texts, by their names in the schema.
WORDS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("materials", "material", "ground_material", "scene_materials"), MATERIALS),
    **dict.fromkeys(("time", "air_times", "hours"), TIMES),
    **dict.fromkeys(("tolerance", "accuracy"), TOLERANCES),
    "pixel": ("0.3 K", "5 K"),
    "date": ("2026-01-15", "2026-07-01", "2024-02-29"),
    "first": ("2026-01-01",),
    "last": ("2026-01-02", "2026-12-31"),
    "name": ("drawn", "D-1", "n" * 40),
    "bands": ("b01", "drawn"),
    "preset": ("clear", "hazy"),
    "table": ("series.csv",),
    "image": ("road.png",),
    "response": ("response.csv",),
    "sounding": ("sounding.csv", "auto"),
    "file": ("sounding.csv", "weather.csv", "year.epw"),
    "folder": ("built", "f" * 250, "a/b"),
    "output": ("built",),
}


class Drawer:
    """Draws values of a JSON schema."""

    def __init__(self, schema: dict[str, Any], seed: int):
        self.schema, self.draw = schema, random.Random(seed)

    def value(self, schema: dict[str, Any], name: str = "") -> Any:
        """A value that mostly fits the schema of a key."""
        if self.draw.random() < WRONG:
            return self.draw.choice(ODD)
        if "$ref" in schema:
            return self.value(self._of(schema), name)
        for key in ("anyOf", "oneOf"):
            if key in schema:
                return self.value(self.draw.choice(schema[key]), name)
        if "enum" in schema or "const" in schema:
            return self.draw.choice(schema.get("enum", [schema.get("const")]))
        kind = schema.get("type")
        if kind in ("number", "integer"):
            return self._number(schema, kind == "integer")
        if kind == "array":
            return self._array(schema, name)
        if kind == "object":
            return self._object(schema, name)
        if kind == "null":
            return None
        return self.draw.random() < 0.5 if kind == "boolean" else self.draw.choice(WORDS.get(name, ("x",)))

    def _of(self, schema: dict[str, Any]) -> dict[str, Any]:
        while "$ref" in schema:
            schema = self.schema["$defs"][schema["$ref"].rpartition("/")[2]]
        return schema

    def _number(self, schema: dict[str, Any], whole: bool) -> float:
        low = schema.get("minimum", schema.get("exclusiveMinimum", -1e3))
        high = schema.get("maximum", schema.get("exclusiveMaximum", 1e3))
        between = low + (high - low) * self.draw.random() ** self.draw.choice([1, 4])
        limits = [limit for key, limit in (("minimum", low), ("maximum", high)) if key in schema]
        beyond = [low - 1, high * 2 + 1, 0.0]
        chosen = self.draw.choice(
            beyond
            if self.draw.random() < WRONG
            else [*limits, between, between, between, schema.get("default") or between]
        )
        return int(chosen) if whole else float(f"{chosen:.6g}")

    def _array(self, schema: dict[str, Any], name: str) -> list[Any]:
        if "prefixItems" in schema:
            items = [self.value(item, name) for item in schema["prefixItems"]]
        else:
            size = min(max(1, schema.get("minItems", 0)) + self.draw.choice([0, 1, 2]), schema.get("maxItems", 10**9))
            items = [self.value(schema.get("items", {}), name) for _ in range(size)]
        plain = all(isinstance(item, float | int) for item in items) or all(isinstance(item, str) for item in items)
        return sorted({*items}) if plain and self.draw.random() > WRONG else items

    def _object(self, schema: dict[str, Any], name: str) -> dict[str, Any]:
        keys = list(schema.get("properties", {}))
        if not keys:
            return {self.draw.choice(MATERIALS): self.value(schema.get("additionalProperties") or {}, name)}
        chosen = {*schema.get("required", []), *self.draw.sample(keys, min(len(keys), self.draw.choice([1, 1, 2, 3])))}
        return {key: self.value(schema["properties"][key], key) for key in keys if key in chosen}

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
                inner = self._of(inner)
                if isinstance(below, dict) and "properties" in inner and self.draw.random() < DEEPER:
                    place, schema = below, inner
                    continue
                place[key] = self.value(inner, key)
                break
        return job


def outcome(job: dict[str, Any], folder: Path) -> tuple[str, str]:
    """What became of a job in a word, and the trace of a failure."""
    file = folder / "job.yaml"
    file.write_text(yaml.safe_dump(job), encoding="utf-8")
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "road.png").write_bytes(readers.seeds("texture")[0])
    try:
        checked = check(file)
    except InputError as error:
        return ("refused", "") if "\n" not in str(error) else ("FAILED: several lines", str(error))
    except Exception:
        return "FAILED in the check", traceback.format_exc()
    if sum(checked.seconds.values()) > LONGEST_BUILD:
        return "accepted, too long to build", ""
    try:
        suite.inline(checked.loaded, jobs=1)
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
