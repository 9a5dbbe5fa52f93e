"""Placement: uniform in area (Kolmogorov–Smirnov tests), isotropic in angle, without overlap.

Seeds are fixed, so that a p-value below 1e-3 means a change of the distribution and not chance.
"""

import numpy as np
import pytest
import sympy as sp
from examples.surfaces import SURFACES
from reference.surface import Z, area_below
from scipy.spatial.distance import cdist
from scipy.stats import kstest

from warp_rods.contact import overlap
from warp_rods.contact.overlap import without_overlap
from warp_rods.contact.segments import OccupiedSpace
from warp_rods.errors import SceneError
from warp_rods.membranes import sampling as placement
from warp_rods.membranes import surfaces

COUNT = 2000
UNLIKELY = 1e-3

CASES = {kind: values for kind, (values, _phi) in SURFACES.items()} | {
    "plane": {"size": 2.0},
    "torus": {"major": 1.0, "minor": 0.6},
    "bridge": {"neck": 0.4, "body": 1.0, "width": 1.0, "length": 4.0},
    "undulated": {},
}
"""Kind: values. Those that ``REVOLVED`` or a test states in closed form are given here."""

REVOLVED = {
    "cylinder": (sp.Float(0.36), 1.5),
    "cassini": (sp.sqrt(4 * Z**2 + sp.Float(1.1) ** 4) - Z**2 - 1, float(np.hypot(1.0, 1.1))),
    "bridge": ((0.4 + 0.6 * (1 - sp.exp(-(Z**2)))) ** 2, 2.0),
}
"""Kind: ρ²(z) and the half length."""


def surface(kind: str) -> surfaces.Surface:
    return surfaces.make(kind, CASES[kind])


def scattered(kind: str, seed: int = 3, count: int = COUNT) -> np.ndarray:
    return placement.uniform_points(surface(kind), count, np.random.default_rng(seed))


def likely(values: np.ndarray, distribution) -> bool:
    return kstest(values, distribution).pvalue > UNLIKELY


def uniform_angle(angle: np.ndarray) -> bool:
    return likely(angle % (2 * np.pi) / (2 * np.pi), "uniform")


def azimuth(x: np.ndarray) -> np.ndarray:
    return np.arctan2(x[:, 1], x[:, 0])


@pytest.mark.parametrize("kind", CASES)
def test_points_lie_on_the_surface_inside_its_box_and_repeat_with_the_seed(kind):
    x = scattered(kind, count=300)
    low, high = surface(kind).box
    assert x.shape == (300, 3)
    assert np.abs(surface(kind).phi(x)).max() < 1e-12
    assert ((x >= low) & (x <= high)).all()
    np.testing.assert_array_equal(x, scattered(kind, count=300))
    assert np.abs(x - scattered(kind, seed=4, count=300)).max() > 0.1


def test_uniform_on_the_plane():
    x = scattered("plane")
    assert all(likely(x[:, axis] / 2 + 0.5, "uniform") for axis in (0, 1))


def test_uniform_on_the_sphere():
    """Every coordinate is uniform (Archimedes)."""
    x = scattered("sphere") / 1.3
    assert all(likely((x[:, axis] + 1) / 2, "uniform") for axis in range(3))


def test_uniform_on_the_torus():
    """Density R + r cos θ around the tube."""
    x = scattered("torus")
    theta = np.arctan2(x[:, 2], np.hypot(x[:, 0], x[:, 1]) - 1.0) % (2 * np.pi)
    assert likely(theta, lambda t: (t + 0.6 * np.sin(t)) / (2 * np.pi))
    assert not uniform_angle(theta)
    assert uniform_angle(azimuth(x))


@pytest.mark.parametrize("kind", REVOLVED)
def test_uniform_on_surfaces_of_revolution(kind):
    x = scattered(kind)
    radius_squared, half = REVOLVED[kind]
    assert likely(x[:, 2], lambda z: area_below(z, radius_squared, -half, half))
    assert uniform_angle(azimuth(x))


def test_octants_of_the_undulated_sphere_and_the_ellipsoid_are_equally_likely():
    for kind in ("undulated", "ellipsoid"):
        octant = (scattered(kind) > 0) @ np.array([1, 2, 4])
        counts = np.bincount(octant, minlength=8)
        assert np.abs(counts - COUNT / 8).max() < 4 * np.sqrt(COUNT / 8)


@pytest.mark.parametrize("kind", ["sphere", "torus", "bridge"])
def test_directions_are_tangent_and_isotropic(kind):
    x = scattered(kind)
    q = placement.isotropic_directions(surface(kind), x, np.random.default_rng(5))
    n = surface(kind).normal(x)
    np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1, rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.sum(q * n, axis=-1), 0, rtol=0, atol=1e-15)
    around_z = np.stack([-np.sin(azimuth(x)), np.cos(azimuth(x)), np.zeros(COUNT)], axis=-1)
    upwards = np.cross(n, around_z)
    assert uniform_angle(np.arctan2(np.sum(q * upwards, axis=-1), np.sum(q * around_z, axis=-1)))


def test_a_surface_outside_its_box_is_refused(monkeypatch):
    row = surfaces.SURFACES["sphere"]
    small = surfaces.SurfaceKind(row.field, row.parameters, lambda v: (0.1,) * 3)
    monkeypatch.setitem(surfaces.SURFACES, "sphere", small)
    with pytest.raises(SceneError, match="no point of φ = 0"):
        scattered("sphere")


class Straight:
    """Straight filaments of 9 nodes along tangents; counts how many were requested."""

    def __init__(self, length: float = 0.5):
        self.s, self.requested = np.linspace(-length / 2, length / 2, 9), 0

    def __call__(self, r: np.ndarray, q: np.ndarray) -> np.ndarray:
        self.requested += len(r)
        return r[:, None] + self.s[:, None] * q[:, None]


def on_a_sphere(count: int, clearance: float, others: np.ndarray, lines: Straight):
    """Filaments on a sphere, uniform and isotropic, with a clearance."""
    sphere, rng = surface("sphere"), np.random.default_rng(6)

    def draw(rods: np.ndarray):
        r = placement.uniform_points(sphere, len(rods), rng)
        q = placement.isotropic_directions(sphere, r, rng)
        return (r, q), lines(r, q)

    return without_overlap(count, draw, clearance, OccupiedSpace([others.reshape(-1, 1, 3)], np.zeros(3)))


def test_filaments_keep_their_clearance_from_each_other_and_from_others():
    lines, others = Straight(), scattered("sphere", count=40).reshape(8, 5, 3)
    (r, q), redrawn, _ = on_a_sphere(40, 0.15, others, lines)
    assert redrawn > 0 and lines.requested == 40 + redrawn
    assert r.shape == q.shape == (40, 3)
    placed = lines(r, q)
    for i, line in enumerate(placed):
        rest = np.concatenate([np.delete(placed, i, axis=0).reshape(-1, 3), others.reshape(-1, 3)])
        assert cdist(line, rest).min() >= 0.15


def test_nothing_is_redrawn_where_there_is_room():
    (r, _), redrawn, _ = on_a_sphere(2, 1e-9, np.empty((0, 3)), Straight())
    assert len(r) == 2 and redrawn == 0


def test_too_many_filaments_are_refused_with_the_number_that_fits(monkeypatch):
    monkeypatch.setattr(overlap, "MOST_ROUNDS", 3)
    lines = Straight()
    with pytest.raises(SceneError) as caught:
        on_a_sphere(60, 1.2, np.empty((0, 3)), lines)
    message = str(caught.value)
    fitted = int(message.split("only ")[1].split()[0])
    assert "count = 60" in message and 0 < fitted < 60
    assert f"after {lines.requested - fitted} draws" in message and "1.2 apart" in message
