"""What the needs of the starter job save, and that no answer within them changes by more than the plan says."""

import json

import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.schemas.documents import read_yaml

pytestmark = pytest.mark.validation


def test_starter_with_and_without(tmp_path):
    CliRunner().invoke(main, ["init", str(tmp_path / "demo")], standalone_mode=False, catch_exceptions=False)
    file = tmp_path / "demo" / "job.yaml"
    job = dict(read_yaml(file).data)
    job.pop("textures")
    job |= {
        "materials": ["asphalt_road", "grass_green", "conifer"],
        "needs": {"range_km": [0.5, 8], "observer_altitude_km": [2.2, 4], "elevation_deg": [-90, -5], "hours": ["10:00", "16:00"]},
    }
    file.write_text(yaml.safe_dump(job), encoding="utf-8")
    done = CliRunner().invoke(main, ["bench", "leaving-out", str(file), "--json"], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    found = json.loads(done.output)
    less = {name: found["as_it_is"][name]["value"] / found["whole"][name]["value"] for name in ("time", "size")}
    print(f"\nshare of the whole: {less}; largest difference {max(d['largest'] for d in found['differences'].values()):.1e}")
    assert less["size"] < 0.5 and found["differences"]
    assert all(each["largest"] <= each["bound"] for each in found["differences"].values())
