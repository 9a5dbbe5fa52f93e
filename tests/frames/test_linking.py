"""wr.frames: writhe, twist and link of closed curves; Călugăreanu's theorem Lk = Wr + Tw."""

import numpy as np
import pytest
from examples.framed_curve import exact_frenet, knot
from examples.free import slope

import warp_rods as wr
from warp_rods import frames

KNOTS = {"unknot": (1, 2), "left trefoil": (2, 3), "right trefoil": (2, -3), "(3, 4) knot": (3, 4)}


def circle(nodes: int, centre=(0.0, 0.0, 0.0), upright=False) -> np.ndarray:
    t = 2 * np.pi * np.arange(nodes) / nodes
    points = np.stack([np.cos(t), np.sin(t), 0 * t], axis=-1)
    return np.array(centre) + (points[:, [0, 2, 1]] if upright else points)


def closed_frames(tangents: np.ndarray, turns: int) -> np.ndarray:
    """Frames on closed tangents [node, 3] that close after this many turns more than the shortest way."""
    carried = frames.parallel_transport(np.concatenate([tangents, tangents[:1]]))
    missing = np.arctan2(*(carried[-1, :, 1] @ carried[0, :, [2, 1]].T))
    angle = np.linspace(0, -missing + 2 * np.pi * turns, len(tangents), endpoint=False)
    # The end is turned by ``missing`` about the tangent: take that back along the curve.
    return frames.turned(carried[:-1], angle)


@pytest.mark.parametrize("name", KNOTS)
@pytest.mark.parametrize("turns", [0, -2])
def test_link_is_writhe_and_twist_of_polygons_to_round_off(name, turns, verified):
    """A ribbon on the segments of a polygon; its edge joins the middles of the segments, one director away."""
    position = knot(200, *KNOTS[name])[0]
    after = np.roll(position, -1, axis=0)
    R = closed_frames(after - position, turns)
    width = 0.02
    both_ends = np.stack([position + width * R[..., 1], after + width * R[..., 1]], axis=1).reshape(-1, 3)
    link = frames.link(position, both_ends)
    total = frames.writhe(position, closed=True) + frames.twist(R, closed=True)
    verified(
        "exact", f"wr.frames: Lk − Wr − Tw of a framed polygon, {name}, {turns} turns", measured=link - total,
        expected=0.0, within=1e-11, reference="Călugăreanu's theorem",
    )  # fmt: skip
    assert abs(link - round(float(link))) < 1e-11
    untwisted = closed_frames(after - position, 0)
    assert frames.twist(R, closed=True) - frames.twist(untwisted, closed=True) == pytest.approx(turns, abs=1e-11)


def test_link_is_writhe_and_twist_of_smooth_curves_to_second_order(verified):
    """The Frenet frame of the trefoil: ∫ τ ds/2π is its twist, and its self-linking number a whole one."""
    sizes, errors = [100, 200, 400], []
    for nodes in sizes:
        curve = knot(nodes)
        R, _, torsion, speed = exact_frenet(curve)
        Wr, Tw = frames.writhe(curve[0], closed=True), frames.twist(R, closed=True)
        exact = np.mean(torsion * speed)
        errors.append((abs(Tw - exact), abs(frames.link(curve[0], curve[0] + 0.02 * R[..., 1]) - Wr - exact)))
    verified.order(
        "wr.frames: Tw, and Wr = Lk − Tw, of a smooth trefoil: order in Δs",
        measured=[slope(sizes, [e[i] for e in errors]) for i in (0, 1)], reference="∫ τ ds/2π by Fourier series",
    )  # fmt: skip


def test_linking_numbers_of_known_links():
    one, other = circle(40), circle(31, (1.0, 0.0, 0.0), upright=True)
    far = circle(17, (5.0, 0.0, 0.0))
    assert abs(frames.link(one, other)) == pytest.approx(1, abs=1e-12)
    assert frames.link(one, other[::-1]) == pytest.approx(-frames.link(one, other), abs=1e-12)
    assert frames.link(other, one) == pytest.approx(frames.link(one, other), abs=1e-12)
    assert frames.link(one, far) == pytest.approx(0, abs=1e-12)
    both = frames.link(one, np.stack([circle(25, (5.0, 0, 0)), circle(25, (1.0, 0, 0), upright=True)]))
    np.testing.assert_allclose(both, [0, frames.link(one, other)], atol=1e-12)
    t = 2 * np.pi * np.arange(120) / 120
    for winds in (1, 3, -2):  # from ρ̂ to −ẑ: about φ̂, a right-handed screw where positive
        rho = 1 + 0.3 * np.cos(winds * t)
        around = np.stack([rho * np.cos(t), rho * np.sin(t), -0.3 * np.sin(winds * t)], axis=-1)
        assert frames.link(circle(120), around) == pytest.approx(winds, abs=1e-12)


def test_writhe_of_closed_curves():
    assert frames.writhe(circle(50), closed=True) == pytest.approx(0, abs=1e-13)
    curve = knot(150)[0]
    closed = frames.writhe(curve, closed=True)
    assert closed == pytest.approx(frames.writhe(np.concatenate([curve, curve[:1]])), abs=1e-13)
    assert frames.writhe(curve * [1, 1, -1], closed=True) == pytest.approx(-closed, abs=1e-12)
    moved = 3 * curve @ frames.rotation_exp([0.3, 1.0, -2.0]).T + 5
    np.testing.assert_allclose(
        frames.writhe(np.stack([curve, moved, np.roll(curve, 7, 0)]), closed=True), closed, atol=1e-12
    )


def test_many_pairs_are_summed_in_parts(monkeypatch):
    from warp_rods.frames import gauss

    curve, other = knot(60)[0], circle(40, (2.0, 0.0, 0.0), upright=True)
    whole = frames.writhe(curve, closed=True), frames.link(curve, other)
    monkeypatch.setattr(gauss, "_PAIRS_AT_ONCE", 100)
    np.testing.assert_allclose([frames.writhe(curve, closed=True), frames.link(curve, other)], whole, atol=1e-13)


def test_wrong_arguments_are_named():
    with pytest.raises(wr.SceneError, match="second: must have 3 nodes or more"):
        frames.link(circle(5), np.zeros((2, 3)))
    with pytest.raises(wr.SceneError, match=r"R\[0\]: the tangent of the next frame must not be opposite"):
        frames.twist(np.stack([np.eye(3), np.diag([-1.0, -1.0, 1.0])]))
    with pytest.raises(wr.SceneError, match=r"position: must be vectors \[..., 3\]"):
        frames.writhe(np.zeros((4, 2)))
