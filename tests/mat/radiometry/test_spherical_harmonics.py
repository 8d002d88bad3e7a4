"""Harmonics of irradiance against quadrature over the sphere and against closed forms of simple fields."""

import numpy as np
import pytest
from scipy.special import eval_legendre

from skyshine.mat.radiometry.spherical_harmonics import (
    COUNTS,
    HARMONICS,
    ambient_of_faces,
    face_normal,
    harmonics_at,
    irradiance_factors,
    legendre,
    zonal,
)

NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)
HALF = 0.5 * (NODES + 1), 0.5 * WEIGHTS
TURNS = 48


def sphere():
    """Unit vectors (N, 3) and solid angles (N,), exact for polynomials on each hemisphere."""
    nodes, weights = (np.concatenate(halves) for halves in ((-HALF[0], HALF[0]), (HALF[1], HALF[1])))
    azimuth = 2 * np.pi * (np.arange(TURNS) + 0.5) / TURNS
    cosine, turn = (part.ravel() for part in np.meshgrid(nodes, azimuth, indexing="ij"))
    sine = np.sqrt(1 - cosine**2)
    weight = np.repeat(weights * 2 * np.pi / TURNS, TURNS)
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=-1), weight


def faces(count=50):
    normal = np.random.default_rng(5).normal(size=(count, 3))
    return np.concatenate([normal / np.linalg.norm(normal, axis=1, keepdims=True), [[0, 0, 1], [0, 0, -1], [1, 0, 0]]])


def light(radiance, count, level, ground=0.0, emitted=0.0):
    """Ambient of `faces` in a field given at `sphere`."""
    vectors, weight = sphere()
    coefficients = (radiance * weight) @ harmonics_at(vectors, HARMONICS[:count])
    below = (vectors[:, 2] < 0) * ground
    zones = (below * weight) @ harmonics_at(vectors, zonal(count))
    return ambient_of_faces(np.float64(level), coefficients, zones, np.float64(emitted), faces())


def test_they_are_orthonormal():
    vectors, weight = sphere()
    values = harmonics_at(vectors)
    np.testing.assert_allclose(np.einsum("nh,ng,n->hg", values, values, weight), np.eye(len(HARMONICS)), atol=1e-12)


@pytest.mark.parametrize("order", [4, 6])
def test_legendre_polynomials(order):
    cosine = np.linspace(-1, 1, 21)
    np.testing.assert_allclose(legendre(order, cosine), eval_legendre(order, cosine), atol=1e-14)


def test_factors_are_those_of_the_clamped_cosine():
    """A_l = 2 pi times the integral of the cosine times P_l over the hemisphere."""
    cosine, weight = HALF
    expected = [2 * np.sum(weight * cosine * eval_legendre(code // 10, cosine)) for code in HARMONICS]
    np.testing.assert_allclose(irradiance_factors(HARMONICS), expected, atol=1e-12)


@pytest.mark.parametrize("count", COUNTS)
def test_even_light_from_all_sides_lights_every_face_alike(count):
    found = light(np.full(len(sphere()[0]), 7.0), count, 7.0)
    np.testing.assert_allclose(found, 7.0, rtol=1e-12)


@pytest.mark.parametrize("count", COUNTS)
def test_an_even_ground_is_seen_by_its_view_factor(count):
    """(1 - cos(slope)) / 2 of what it emits, at any emission, under a sky that is black."""
    found = light(np.zeros(len(sphere()[0])), count, 0.0, ground=0.9, emitted=40.0)
    np.testing.assert_allclose(found, 36.0 * (1 - faces()[:, 2]) / 2, atol=1e-10)


@pytest.mark.parametrize("count", COUNTS)
def test_a_level_face_has_the_level_value_whatever_the_coefficients(count):
    draw = np.random.default_rng(3)
    found = ambient_of_faces(
        np.float64(5.0), draw.normal(size=count), draw.normal(size=len(zonal(count))), np.float64(2.0), np.eye(3)[2]
    )
    assert found == pytest.approx(5.0, rel=1e-14)


@pytest.mark.parametrize(("count", "limit"), [(6, 0.012), (11, 0.005)])
def test_a_sky_that_brightens_towards_the_horizon(count, limit):
    """Radiance of thin air, 1 - exp(-0.3 / cosine): faces against the integral over their hemispheres."""
    cosine, weight = np.polynomial.legendre.leggauss(400)
    turn = 2 * np.pi * (np.arange(200) + 0.5) / 200
    sky = np.where(cosine > 0, -np.expm1(-0.3 / np.maximum(cosine, 1e-9)), 0.0)
    mu, phi = np.meshgrid(cosine, turn, indexing="ij")
    sine = np.sqrt(1 - mu**2)
    vectors = np.stack([sine * np.cos(phi), sine * np.sin(phi), mu], axis=-1)
    solid = (weight * 2 * np.pi / 200)[:, None] * sky[:, None]
    coefficients = np.einsum("ab,abh->h", np.broadcast_to(solid, mu.shape), harmonics_at(vectors, HARMONICS[:count]))

    def exact(normal):
        return np.sum(solid * np.maximum(vectors @ normal, 0.0)) / np.pi

    expected = np.array([exact(normal) for normal in faces()])
    zones = np.zeros(len(zonal(count)))
    found = ambient_of_faces(np.float64(exact(np.eye(3)[2])), coefficients, zones, np.float64(0.0), faces())
    assert np.abs(found - expected).max() < limit * expected.max()


def test_normals_of_slopes_and_azimuths():
    np.testing.assert_allclose(
        face_normal([0, 90, 90, 180], [33, 0, 90, 0]), [[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, -1]], atol=1e-12
    )


@pytest.mark.parametrize(("count", "degree"), [(COUNTS[0], 4), (COUNTS[1], 6)])
def test_a_field_of_the_first_missing_harmonic_lights_faces_by_its_own_polynomial(count, degree):
    """All coefficients that are kept are 0; the level value alone carries the field to every slope."""
    slopes = np.array([0.0, 20.0, 60.0, 90.0, 130.0, 180.0])
    normal = face_normal(slopes, 35.0)
    light = ambient_of_faces(np.ones(6), np.zeros((6, count)), np.zeros((6, len(zonal(count)))), np.zeros(6), normal)
    assert light == pytest.approx(np.maximum(eval_legendre(degree, np.cos(np.radians(slopes))), 0.0), abs=1e-12)
