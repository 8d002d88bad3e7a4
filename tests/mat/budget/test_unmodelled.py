"""Closed forms of what no table of a job holds: depth buffers, pixels across edges, microfacets."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.budget.runtime_terms import Finish, reflection
from skyshine.mat.budget.unmodelled import depth_buffer_range, microfacet_reflection, share_beyond_edge
from skyshine.mat.quantities.lines_of_sight import direction


def test_a_depth_buffer_steps_by_the_square_of_range():
    """Between 1 m and 100 km, 24 bits: half a step is r^2 / (2 n 2^24), 3 m at 10 km; its ends are exact."""
    distance = np.linspace(9000.0, 11000.0, 4001)
    read = depth_buffer_range(distance, 1.0, 1e5)
    assert np.abs(read - distance).max() == pytest.approx(11000.0**2 / 2 / 2**24, rel=0.02)
    np.testing.assert_allclose(depth_buffer_range(np.array([1.0, 1e5]), 1.0, 1e5), [1.0, 1e5], rtol=1e-9)


@pytest.mark.parametrize(
    ("face", "pixel", "place", "share"),
    [(10.0, 1.0, 0.5, 0.0), (10.0, 1.0, 0.0, 0.5), (10.0, 1.0, 0.98, 0.3), (10.0, 40.0, 0.3, 0.75)],
)
def test_share_of_a_pixel_beyond_the_edges(face, pixel, place, share):
    found = share_beyond_edge(np.array([face]), np.array([pixel]), np.array([place]))
    assert found == pytest.approx([share])


FINISH = Finish(np.array([0.04]), np.array([1.0]), np.array([2000.0]), np.array([1.0]))


def mirrored(make_views, angle):
    """A level face that mirrors the source at an angle from its normal to the observer."""
    return make_views(1, source_elevation=90.0 - angle, source_azimuth=180.0, elevation=-(90.0 - angle), heading=180.0)


@pytest.mark.parametrize("angle", [0.0, 60.0, 85.0])
def test_facets_reflect_the_flux_that_fresnel_says(make_views, angle):
    """Over all observers, a narrow spread sends the mirror's share of the light: Schlick's over that at normal
    incidence, times pi cos(angle) of a diffuse surface."""
    source = mirrored(make_views, angle)
    offsets = np.radians(np.linspace(-12.0, 12.0, 193))
    step = offsets[1] - offsets[0]
    flux = 0.0
    towards = -source.to_source[0] * [1, 1, -1]
    east = np.array([1.0, 0.0, 0.0])
    across = np.cross(towards, east)
    for a in offsets:
        rays = towards + np.tan(a) * east + np.tan(offsets)[:, None] * across
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        up = rays[:, 2] > 0.001
        elevation, heading = -np.degrees(np.arcsin(rays[:, 2])), np.degrees(np.arctan2(-rays[:, 0], -rays[:, 1]))
        views = make_views(
            len(rays), source_elevation=90.0 - angle, source_azimuth=180.0, elevation=elevation, heading=heading
        )
        radiance = microfacet_reflection(views, views.normal, FINISH)[:, 0]
        solid = step**2 * (rays @ towards) ** 3 / (np.cos(a) ** 2 * np.cos(offsets) ** 2)
        flux += np.sum((radiance * solid * rays[:, 2])[up])
    fresnel = 0.04 + 0.96 * (1 - np.cos(np.radians(angle))) ** 5
    expected = np.pi * np.cos(np.radians(angle)) * fresnel / 0.04
    assert flux == pytest.approx(expected, rel=0.03 if angle < 80 else 0.5)


def test_without_specular_reflection_both_are_diffuse(make_views):
    views = make_views(3, source_elevation=np.array([10.0, 40.0, 80.0]))
    dull = replace(FINISH, specular_fraction=np.zeros(1))
    np.testing.assert_allclose(microfacet_reflection(views, views.normal, dull), reflection(views, views.normal, dull))
    assert views.normal[0] == pytest.approx(direction(90.0, 0.0))
