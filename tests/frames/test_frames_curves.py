"""wr.frames: curvature, torsion, Frenet and Bishop frames of points, against exact derivatives."""

import numpy as np
import pytest
from examples.framed_curve import exact_frenet, knot, spiral
from examples.free import slope
from scipy.integrate import cumulative_simpson, quad

import warp_rods as wr
from warp_rods import frames

SIZES = [65, 129, 257, 513]
CURVES = {
    "spiral": (False, lambda nodes: spiral(np.linspace(0.5, 3.0, nodes))),
    "trefoil": (True, lambda nodes: knot(4 * (nodes - 1))),
}


def bishop_angle(fine: list[np.ndarray], step: float) -> np.ndarray:
    """∫ τ ds from the first node, by which the Frenet frame turns against a Bishop frame; of every eighth node."""
    _, _, torsion, speed = exact_frenet(fine)
    return cumulative_simpson(torsion * speed, dx=step / 8, initial=0.0)[::8]


@pytest.mark.parametrize("name", CURVES)
def test_frames_of_points_are_second_order(name, verified):
    closed, make = CURVES[name]
    found = []
    for nodes in SIZES:
        curve = make(nodes)
        R, k, tau, _ = exact_frenet(curve)
        step = 2 * np.pi / len(R) if closed else 2.5 / (nodes - 1)
        bishop = frames.turned(R, -bishop_angle(make(8 * (nodes - 1) + 1), step))
        ours = frames.bishop_frame(curve[0], closed, normal=bishop[0, :, 1])
        pairs = [
            (frames.curvature(curve[0], closed), k),
            (frames.torsion(curve[0], closed), tau),
            (frames.frenet_frame(curve[0], closed), R),
            (ours, bishop),
        ]
        found.append([abs(a - b).max() for a, b in pairs])
    verified.order(
        f"wr.frames, {name}: κ, τ, Frenet and Bishop frame: order in Δs",
        measured=[slope(SIZES, column) for column in zip(*found, strict=True)], reference="exact derivatives",
    )  # fmt: skip
    assert np.max(found[-1]) < 2e-2


def test_frames_are_orthonormal_for_batches_of_curves():
    position = spiral(np.linspace(0.5, 3.0, 33))[0]
    batch = np.stack([position, 2 * position[::-1], position @ frames.rotation_exp([1.0, 2.0, 0.3]).T])
    for make in (frames.frenet_frame, frames.bishop_frame):
        R = make(batch)
        assert R.shape == (3, 33, 3, 3)
        np.testing.assert_allclose(np.swapaxes(R, -1, -2) @ R, np.broadcast_to(np.eye(3), R.shape), atol=5e-15)
        np.testing.assert_allclose(np.linalg.det(R), 1)
        np.testing.assert_allclose(R[..., 0], frames.tangent(batch), atol=1e-15)
    k, tau = frames.curvature(batch), frames.torsion(batch)
    np.testing.assert_allclose(k[1], k[0, ::-1] / 2, rtol=1e-12)
    np.testing.assert_allclose(tau[1], tau[0, ::-1] / 2, rtol=1e-9)  # the sense of the curve changes no sign of τ
    np.testing.assert_allclose([k[2], tau[2]], [k[0], tau[0]], rtol=1e-9)
    np.testing.assert_allclose(frames.torsion(batch * [1, 1, -1]), -tau, rtol=1e-9)


def test_the_material_frame_has_the_twist_that_it_is_given():
    position = spiral(np.linspace(0.5, 3.0, 257))[0]
    angle = 5 * np.linspace(0, 1, 257) ** 2
    R = frames.material_frame(position, angle)
    assert frames.twist(R) == pytest.approx(5 / (2 * np.pi), abs=1e-12)
    np.testing.assert_allclose(frames.angle_between(frames.bishop_frame(position), R), angle, atol=1e-12)


def test_arc_length():
    s = frames.arc_length(spiral(np.linspace(0.0, 1.0, 401))[0])
    exact, _ = quad(lambda t: np.sqrt(1 + t**4 / 4), 0, 1)
    assert s[0] == 0 and s[-1] == pytest.approx(exact, abs=1e-6)
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    np.testing.assert_allclose(frames.arc_length(square, closed=True), [0, 1, 2, 3, 4])


def test_straight_pieces_have_no_torsion_and_it_is_said():
    """An oblique line, whose rounded points make up curvature: NaN, with a warning; its Bishop frame is constant."""
    line = np.linspace(0, 1, 65)[:, None] * np.array([0.3, -0.7, 0.2]) + np.array([10.0, 3.0, -7.0])
    bent = spiral(np.linspace(0.5, 3.0, 65))[0]
    with pytest.warns(RuntimeWarning, match=r"torsion: the curvature is zero at 65 nodes, first at \[1, 0\]"):
        tau = frames.torsion(np.stack([bent, line]))
    assert np.isfinite(tau[0]).all() and np.isnan(tau[1]).all()
    with pytest.warns(RuntimeWarning, match="frenet_frame: the curvature is zero at 65 nodes"):
        R = frames.frenet_frame(line)
    assert np.isfinite(R[..., 0]).all() and np.isnan(R[..., 1:]).all()
    np.testing.assert_allclose(frames.bishop_frame(line), frames.bishop_frame(line)[[0] * 65], atol=1e-12)


LINE = np.linspace(0, 1, 7)[:, None] * np.array([1.0, 2.0, 0.0])


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: frames.curvature(LINE[[0, 1, 2, 2, 3, 4]]), r"nodes 2 and 3 are the same point \(0.33.*leave one"),
        (lambda: frames.torsion(np.stack([LINE[:6], LINE[[0, 1, 2, 3, 3, 4]]])), r"position\[1\]: nodes 3 and 4"),
        (lambda: frames.curvature(LINE[[0, 1, 2, 3, 4, 0]], closed=True), "nodes 5 and 0 .*do not repeat the first"),
        (lambda: frames.tangent(LINE[[0, 1, 2, 1, 0]]), "the curve turns back on itself at node 2"),
        (lambda: frames.tangent(LINE[:4]), "position: must have 5 nodes or more"),
        (lambda: frames.tangent(LINE[:, :2]), r"position: must be vectors \[..., 3\]; has shape \(7, 2\)"),
        (lambda: frames.bishop_frame(LINE, normal=[1.0, 2.0, 0.0]), "normal.*not along the first tangent"),
        (lambda: frames.parallel_transport([[1.0, 0, 0], [-1.0, 0, 0]]), r"tangents\[0\]: the next one must not"),
        (lambda: frames.parallel_transport([[1.0, 0, 0], [0.0, 0, 0]]), r"tangents\[1\] = 0"),
        (lambda: frames.tangent(LINE, closed=1), "closed = 1: must be True or False"),
    ],
)  # fmt: skip
def test_wrong_curves_are_named(call, words):
    with pytest.raises(wr.SceneError, match=words):
        call()
