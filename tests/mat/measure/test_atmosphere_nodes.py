"""Grids by tolerance on air whose quantities are known in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.job.atmosphere import AtmosphereGrid
from skyshine.mat.measure.atmosphere_nodes import placed_grids
from skyshine.mat.measure.probes import Probes
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.tables.gridded import QUANTITIES
from skyshine.schemas.errors import CheckFailed

BASE = PathGrid(
    [0.1, 1.0, 10.0, 30.0], [0.0, 1.0, 4.0], [-90.0, -5.0, 0.0, 30.0, 90.0], [-5.0, 0.0, 60.0], [0.0, 60.0, 180.0]
)
SCALE = Scale(10.0, 1.0, 1.0)


class Air:
    """Air that thins with height, bright around the source; lines that meet the ground are drawn to end there."""

    air = SimpleNamespace(shells=Shells.of(np.array([0.0, 1e4, 1e5]), np.array([2.5e25, 8e24, 1e20]), 1000.0))

    def quantities(self, r, a, e, s, angle):
        beta = 20.0 * np.exp((a + 0.02 * r * np.sin(np.radians(e))) / 2.0) + 0 * r
        tau = np.exp(-5.5 * r / beta)
        ratio = 2.0 + np.exp(-a / 3.0) / (1 + (angle / 5.0) ** 2) * np.cos(np.radians(s))
        direct = np.exp(-0.3 / np.sin(np.radians(np.maximum(s, 0.0) + 5.0))) + 0 * beta
        return beta, ratio + 0 * beta, 0.5 * direct, direct, tau

    def table(self, grid, wanted):
        r, a, e, s, z = np.meshgrid(*(getattr(grid, name) for name in PathGrid.__dataclass_fields__), indexing="ij")
        beta, ratio, ambient, direct, tau = self.quantities(
            r, a, e, s, z if grid.by_scattering_angle else scattering_angle(e, s, z)
        )
        path, source = (..., 0, 0), (..., 0)
        found = {
            "beta_star": beta[path],
            "path_radiance_ratio": ratio,
            "ambient": ambient[source],
            "direct": direct[source],
        }
        found = {name: value if name in wanted else None for name, value in found.items()}
        return AtmosphericQuantities(**found, valid=np.ones(tau[path].shape, bool), transmittance=tau[path])

    def along_lines(self, ranges, altitude, elevation, source, azimuth, ambient_at, irradiance, *, wanted):
        a, e, s = altitude[:, None, None], elevation[:, None, None], source[:, None]
        beta, ratio, ambient, direct, tau = self.quantities(
            ranges[:, :, None], a, e, s, scattering_angle(e, s, azimuth[:, None])
        )
        row = np.arange(len(ambient_at))
        return AtmosphericQuantities(
            beta[..., 0], ratio, ambient[row, ambient_at, 0], direct, np.ones(ranges.shape, bool), tau[..., 0]
        )


def placed(tolerance, names=tuple(QUANTITIES), max_nodes=10**6, base=BASE):
    air = Air()

    def probes(generator, key, count):
        return Probes.drawn(air, base, np.zeros(1), generator, sky=count if key == "ambient" else 0, count=count)

    return placed_grids(
        lambda grid, key: air.table(grid, (key,)),
        probes,
        base,
        dict.fromkeys(names, (SCALE, tolerance)),
        seed=3,
        max_nodes=max_nodes,
    )


@pytest.fixture(scope="module")
def found():
    return placed(0.02)


def test_tolerance_holds_on_fresh_lines(found):
    probes = Probes.drawn(Air(), BASE, np.zeros(1), np.random.default_rng(77))
    for name, error in probes.errors({name: one.table for name, one in found.items()}, SCALE).items():
        assert np.percentile(np.abs(error), 99) <= 0.02 and np.abs(error).max() <= 0.04, name


def test_each_quantity_has_the_axes_it_needs(found):
    shapes = {name: one.table.values.shape for name, one in found.items()}
    assert shapes["direct_radiance"][:3] == (3, 3, 3) < shapes["direct_radiance"][3:]  # it knows the source alone
    assert shapes["path_radiance_ratio"][4] > 6 and shapes["path_radiance_ratio"][0] == 3
    assert found["path_radiance_ratio"].table.axes[-1] == "scattering_angle"
    assert np.diff(found["path_radiance_ratio"].table.nodes[4]).argmin() < 5  # closest towards the source
    assert found["path_radiance_ratio"].ratio > 3


def test_the_same_seed_gives_the_same_nodes(found):
    again = placed(0.02, ("direct_radiance",))["direct_radiance"].table
    for one, other in zip(again.nodes, found["direct_radiance"].table.nodes, strict=True):
        np.testing.assert_array_equal(one, other)


def test_azimuths_of_part_of_the_circle_stay_azimuths():
    base = PathGrid(*(getattr(BASE, name) for name in list(PathGrid.__dataclass_fields__)[:4]), [30.0, 90.0])
    table = placed(0.2, ("path_radiance_ratio",), base=base)["path_radiance_ratio"].table
    assert table.axes[-1] == "source_azimuth" and table.nodes[-1][[0, -1]].tolist() == [30.0, 90.0]


def test_what_cannot_be_held_names_quantity_and_axis():
    words = (
        r"atmosphere_grid.tolerance 0.001 cannot be held for beta_star with 500 nodes: it takes more than .*, most for"
        r" the \w+; raise it"
    )
    with pytest.raises(CheckFailed, match=words):
        placed(1e-3, max_nodes=500)


def test_tolerances_by_quantity():
    assert AtmosphereGrid(tolerance="0.1 K").tolerances == dict.fromkeys(QUANTITIES, "0.1 K")
    assert AtmosphereGrid(tolerance={"direct_radiance": "1 K"}).tolerances == {"direct_radiance": "1 K"}
    assert AtmosphereGrid().tolerances == {}
