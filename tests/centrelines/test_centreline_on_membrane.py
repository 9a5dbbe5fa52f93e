"""Measured centre lines on membranes: the filament passes through the points, and is refused where it is far."""

import numpy as np
import pytest
from examples.free import slope
from examples.lines import on_torus, unequal

import warp_rods as wr
from warp_rods.centrelines.rod import distances
from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces

TORUS = {"major": 1.0, "minor": 0.4}
NODES = np.array([33, 65, 129])


def filament(line, nodes, surface) -> wr.BoundRods:
    return wr.BoundRods(
        surface, line.position[None], line.direction[None], nodes=nodes, length=line.length,
        geodesic_curvature=line.geodesic_curvature, device="cpu",
    )  # fmt: skip


def test_the_filament_passes_through_the_points_at_second_order(verified):
    torus, points = surfaces.make("torus", TORUS), on_torus(unequal(300))
    dense, errors = on_torus(np.linspace(0, 1, 100_001)), []
    for nodes in NODES:
        line = wr.from_centreline(points, nodes, surface=torus)
        rods = filament(line, nodes, torus)
        assert rods.status[0] == 0
        errors.append(distances(rods.position[0], dense).max() / line.length)
        assert line.off_largest < 1e-12 and distances(line.line, dense).max() < 1e-6
    assert errors[-1] < 2e-4
    verified.order("filament through points on a torus", measured=slope(NODES - 1, errors), reference="Δs → 0")


def test_a_circle_of_latitude_has_its_geodesic_curvature_and_sign():
    """On a sphere of radius 2 at the polar angle θ: cot θ/2, towards the pole to the left of the direction."""
    sphere = surfaces.make("sphere", {"radius": 2.0})
    for sign in (1, -1):
        angle = sign * np.linspace(0, 2, 100)
        points = 2 * np.stack([np.sin(1) * np.cos(angle), np.sin(1) * np.sin(angle), np.cos(1) + 0 * angle], axis=1)
        line = wr.from_centreline(points, 65, surface=sphere)
        np.testing.assert_allclose(line.geodesic_curvature[2:-2], sign / np.tan(1) / 2, rtol=2e-4)
        assert line.length == pytest.approx(4 * np.sin(1), rel=1e-5)
        height = filament(line, 65, sphere).position[0, 1:-1, 2]
        np.testing.assert_allclose(height, 2 * np.cos(1), atol=2e-3)


def test_points_off_the_membrane_are_projected_and_told():
    """By 0.03 outwards everywhere."""
    sphere, angle = surfaces.make("sphere", {"radius": 1.0}), np.linspace(0, 1.5, 80)
    points = 1.03 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    line = wr.from_centreline(points, 33, surface=sphere)
    assert line.off_rms == pytest.approx(0.03, rel=1e-6) and line.off_largest == pytest.approx(0.03, rel=1e-6)
    assert line.largest == pytest.approx(0.03, rel=1e-3) and line.length == pytest.approx(1.5, rel=1e-5)
    with pytest.raises(SceneError, match=r"is up to 0.2 away from the membrane, more than 0.1 of its length 1.8"):
        wr.from_centreline(points * 1.2 / 1.03, 33, surface=sphere)


def test_scale_and_length_give_the_unit_and_the_length():
    sphere, angle = surfaces.make("sphere", {"radius": 1.0}), np.linspace(0, 1.5, 80)
    points = 500 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    with pytest.raises(SceneError, match="or give scale, what one unit of the points is in its units"):
        wr.from_centreline(points, 33, surface=sphere)
    assert wr.from_centreline(points, 33, surface=sphere, scale=2e-3).length == pytest.approx(1.5, rel=1e-5)
    longer = wr.from_centreline(points, 33, surface=sphere, scale=2e-3, length=1.55)
    assert longer.length == 1.55 and longer.off_largest < 0.05
