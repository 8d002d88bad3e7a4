"""Times of settings that `mat bench` models, against those of their builds: the starter job.

The settings lie between the built ones and beyond them, and their tables differ tenfold in the number of values.
"""

import numpy as np
import pytest

from skyshine.mat.bench.front import _compile
from skyshine.mat.bench.model import BY_VALUES, TimeModel, thinner
from skyshine.mat.bench.rungs import Rung
from skyshine.mat.bench.settings import AS_WRITTEN, settings_of
from skyshine.mat.bench.thinned import value_counts
from skyshine.mat.commands.front import _starter
from skyshine.mat.job.load import load_job
from skyshine.materials.library import load_library

pytestmark = pytest.mark.validation  # five minutes of a processor

BUILT, MODELLED = (AS_WRITTEN, "1 K", "0.2 K"), ("5 K", "0.5 K", "0.3 K")


def values_of(rung, change=lambda tables: tables):
    """Numbers of values of atmosphere and temperatures of a rung of one state."""
    job = rung.loaded.trimmed
    counts = [value_counts(change(rung.tables(1, band, source))) for band in job.needed_bands for source in job.sources]
    return sum(air for air, _ in counts), counts[0][1]


def test_modelled_times_are_within_a_quarter_of_the_real_ones(tmp_path):
    loaded, library = load_job(_starter(tmp_path / "starter")), load_library()
    settings = settings_of(loaded.document.data, (5.0, 1.0, 0.5, 0.3, 0.2))
    rungs = {setting.name: Rung.of(setting, loaded, tmp_path, 1) for setting in settings}
    _compile(list(rungs.values()), library, tmp_path, print)
    for rung in rungs.values():
        rung.build(library, None if rung is rungs[AS_WRITTEN] else rungs[AS_WRITTEN])
    built, finest = [rungs[name] for name in BUILT], rungs[BUILT[-1]]
    model = TimeModel(built, np.array([values_of(rung) for rung in built], float))
    seconds = []
    for name in MODELLED:
        values = values_of(finest, thinner(rungs[name], finest).tables)
        stages, uncertainty = model.stages(values)
        real = rungs[name].cost.stages
        ours, theirs = ([sum(of.values()), sum(of[stage] for stage in BY_VALUES)] for of in (stages, real))
        size = model.size(values) / rungs[name].size
        print(
            f"\n{name}: {ours[0]:.1f} ± {uncertainty:.1f} s modelled, {theirs[0]:.1f} s built; tables and temperatures"
            f" {ours[1]:.1f} s, {theirs[1]:.1f} s; values {values}, {values_of(rungs[name])}; bytes {size:.2f}"
        )
        assert ours[0] == pytest.approx(theirs[0], rel=0.25)
        assert ours[1] == pytest.approx(theirs[1], rel=0.5)
        seconds.append(theirs[1])
    assert max(seconds) > 2 * min(seconds)  # the settings differ in what is modelled
