"""What a ray sees of a surface: the footprint of its pixel."""

from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.render import seen


def test_a_footprint_is_the_width_of_the_ray_where_it_meets_the_surface(monkeypatch):
    """Straight down on level ground: its width at the camera and what it widens by on the way; 60 degree off, sqrt 2
    times as much.
    """
    monkeypatch.setattr(seen, "start_height", lambda surface: 0.0)
    slant = [np.sin(np.pi / 3), 0.0, -np.cos(np.pi / 3)]
    rays = SimpleNamespace(
        origin=np.zeros((2, 3)), direction=np.array([[0.0, 0.0, -1.0], slant]), side=0.5, spread=np.array([0.01, 0.02])
    )
    hits = SimpleNamespace(
        met=np.array([True, True]), face=np.array([0, 0]), weights=np.zeros((2, 2)), distance=np.array([100.0, 200.0])
    )
    surface = SimpleNamespace(
        normal=np.array([[0.0, 0.0, 1.0]]), points=lambda face, weights: np.zeros((2, 3)), altitude=0.3
    )
    materials = SimpleNamespace(at=lambda face, weights, footprint: footprint)
    found = seen.SeenSurface.of(rays, surface, materials, SimpleNamespace(first=lambda *_: hits))
    assert found.materials == pytest.approx([0.5 + 0.01 * 100, (0.5 + 0.02 * 200) * np.sqrt(2)])
    assert found.range == pytest.approx([0.1, 0.2]) and found.altitude == pytest.approx([0.3, 0.3])
