"""Measured centre lines as free rods: the rod passes through the points, and the smoothing is as wide as it says."""

import numpy as np
import pytest
from examples.free import slope
from examples.lines import helix, helix_curvature, helix_length, trefoil, unequal

import warp_rods as wr
from warp_rods.centrelines.curve import fitted_curve
from warp_rods.centrelines.rod import distances
from warp_rods.errors import SceneError

NODES = np.array([33, 65, 129])
STIFF = {"bend": 1e-2, "twist": 1e-2, "flagella": None}


def rod_of(line, nodes):
    """The centre line of ``FreeRods`` along a measured one, in units of the points."""
    placed = {"position": line.position[None], "rotation": line.rotation}
    return wr.FreeRods(1, nodes, shape=line.strain[None], **placed, **STIFF, device="cpu").position[0] * line.length


@pytest.mark.parametrize("curve", [helix, trefoil])
def test_the_rod_passes_through_the_points_at_second_order(curve, verified):
    """Distances of the nodes of ``FreeRods`` from the curve, which has unequally spaced points, in lengths."""
    points, dense = curve(unequal(400)), curve(np.linspace(0, 1, 200_001))
    errors, told = [], []
    for nodes in NODES:
        line = wr.from_centreline(points, nodes)
        rod = rod_of(line, nodes)
        np.testing.assert_allclose(rod, line.line, rtol=0, atol=1e-12 * line.length)
        errors.append(distances(rod, dense).max() / line.length)
        told.append(line.largest / line.length)
    verified.below(
        "exact", f"rod of 129 nodes through 400 points of a {curve.__name__}: largest distance", measured=errors[-1],
        bound=3e-4, reference="the curve in closed form",
    )  # fmt: skip
    verified.order(f"rod through points of a {curve.__name__}", measured=slope(NODES - 1, errors), reference="Δs → 0")
    assert slope(NODES - 1, told) == pytest.approx(2, abs=0.2)


def test_strains_of_a_helix_are_those_of_its_curvature_and_torsion():
    """|k| = κ, the phase of k turns at the torsion, there is no twist, and ends are free."""
    line = wr.from_centreline(helix(np.linspace(0, 1, 200)), 129)
    k = (line.strain[:, 1] + 1j * line.strain[:, 2])[4:-4] / line.length
    np.testing.assert_allclose(np.abs(k), helix_curvature(), rtol=2e-3)
    torsion = 0.8 / (2 * np.pi) * helix_curvature()
    turned = np.diff(np.unwrap(np.angle(k))) / (line.length / 128)
    np.testing.assert_allclose(turned, torsion, rtol=1e-3)  # the sign is that of a right-handed helix
    assert not line.strain[:, 0].any() and not line.strain[[0, -1]].any()
    assert line.length == pytest.approx(helix_length(), rel=1e-5)


def test_a_left_handed_helix_turns_the_other_way():
    lines = [wr.from_centreline(helix(np.linspace(0, 1, 200)) * [1, 1, sign], 65) for sign in (1, -1)]
    turned = [np.diff(np.unwrap(np.angle(x.strain[5:-5, 1] + 1j * x.strain[5:-5, 2]))).sum() for x in lines]
    assert turned[0] > 0.5 and turned[1] == pytest.approx(-turned[0], rel=1e-6)


def test_units_place_and_direction_do_not_change_the_shape():
    points = trefoil(unequal(150))
    one = wr.from_centreline(points, 65)
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    other = wr.from_centreline(1e-6 * (points @ turn.T) + 1e-4, 65)
    assert other.length == pytest.approx(1e-6 * one.length, rel=1e-9)
    size, again = (np.linalg.norm(x.strain, axis=1) for x in (one, other))
    np.testing.assert_allclose(again, size, atol=1e-6 * size.max())
    np.testing.assert_allclose(other.line, 1e-6 * (one.line @ turn.T) + 1e-4, atol=1e-12)


def test_from_the_other_end_the_rod_is_the_same():
    points = trefoil(unequal(150))
    one, other = wr.from_centreline(points[::-1], 65), wr.from_centreline(points, 65, reverse=True)
    np.testing.assert_array_equal(one.strain, other.strain)
    np.testing.assert_allclose(one.line[::-1], wr.from_centreline(points, 65).line, atol=1e-4 * one.length)


def test_repeated_and_missing_points_change_nothing():
    points = helix(unequal(120))
    rows = np.repeat(points, np.where(np.arange(120) % 7 == 0, 3, 1), axis=0)
    rows = np.insert(rows, [10, 50, 50, 100], np.nan, axis=0)
    line, plain = wr.from_centreline(rows, 33), wr.from_centreline(points, 33)
    np.testing.assert_array_equal(line.strain, plain.strain)
    assert line.notes == ("4 missing points left out", f"{2 * 18} repeated points left out") and not plain.notes


def test_a_line_in_a_plane_stays_in_it():
    """Exactly, so that a planar swimmer stays planar: Ω₁ = 0 with two columns, and at any height."""
    x = np.linspace(0, 3, 80)
    for points in (np.stack([x, np.sin(x)], axis=1), np.stack([x, np.sin(x), 0 * x + 0.3], axis=1)):
        line = wr.from_centreline(points, 33)
        assert not line.strain[:, :2].any() and line.strain[:, 2].any()
        assert not np.ptp(line.line[:, 2])
    assert line.rotation[2, 2] == 1.0


@pytest.mark.parametrize("wave, kept", [(0.05, 1 / 65), (0.1, 0.5), (0.2, 64 / 65)])
@pytest.mark.parametrize("spacing", ["equal", "unequal", "dense in a half"])
def test_the_smoothing_halves_waves_of_the_wavelength_that_it_states(wave, kept, spacing, verified):
    """A small wave along a straight line, away from the ends; the factor is 1/(1 + (Λ/wavelength)⁶)."""
    x = {
        "equal": np.linspace(0, 1, 801),
        "unequal": unequal(801),
        "dense in a half": np.r_[np.linspace(0, 0.5, 1201)[:-1], np.linspace(0.5, 1, 401)],
    }[spacing]
    points = np.stack([x, 1e-5 * np.sin(2 * np.pi * x / wave), 0 * x], axis=1)
    curve = fitted_curve(points, 0.1)
    s = np.linspace(0.3, 0.7, 4001)
    found = np.ptp(curve.place(s)[:, 1]) / 2e-5
    verified(
        "exact", f"smoothing 0.1 of a wave of length {wave:g}, points {spacing}: what is kept of it", measured=found,
        expected=kept, within=2e-3, reference="1/(1 + (Λ/λ)⁶)",
    )  # fmt: skip


def test_noise_is_smoothed_and_told():
    """Points of a helix with noise of 1 % of its length: the rod is nearer to the helix than its points are."""
    rng, points = np.random.default_rng(3), helix(unequal(300))
    noise = 0.01 * helix_length() * rng.normal(size=points.shape)
    line = wr.from_centreline(points + noise, 65, smoothing=0.25)
    off = distances(line.line, helix(np.linspace(0, 1, 20_001)))
    across = np.sqrt(2) * 0.01 * helix_length()
    assert off[3:-3].max() < 0.4 * across and off.max() < 1.5 * across  # ends are moved along the line, too
    assert line.rms == pytest.approx(across, rel=0.15)
    assert line.smoothing == pytest.approx(0.25 * line.length, rel=1e-2)
    rough = wr.from_centreline(points + noise, 65)
    assert np.abs(rough.strain).max() > 3 * np.abs(line.strain).max()


def test_a_smoothing_in_points_is_that_many_distances_of_points():
    line = wr.from_centreline(helix(np.linspace(0, 1, 101)), 65, smoothing="10 points")
    assert line.smoothing == pytest.approx(0.1 * line.length, rel=1e-3)


def test_without_smoothing_the_line_passes_through_every_point():
    points = helix(unequal(30))
    curve = fitted_curve(points, 0)
    dense = curve.place(np.linspace(0, curve.length, 20_001))
    assert distances(points, dense).max() < 1e-6
    assert wr.from_centreline(points, 65, smoothing=0).smoothing == 0


def test_a_gap_or_points_out_of_order_are_told():
    points = np.delete(helix(np.linspace(0, 1, 200)), slice(80, 110), axis=0)
    (note,) = wr.from_centreline(points, 33).notes
    assert note.startswith("points 79 and 80 are 29.3 times as far apart as usual")


HELIX = helix(np.linspace(0, 1, 50))


@pytest.mark.parametrize(
    "points, given, said",
    [
        (HELIX[:3], {}, "has 3 different points, of 3 rows: must be 4 or more"),
        (np.repeat(HELIX[:1], 9, axis=0), {}, "has 1 different points, of 9 rows"),
        (np.full((9, 3), np.nan), {}, "has 0 different points, of 9 rows"),
        (np.where(np.arange(50)[:, None] == 7, np.inf, HELIX), {}, "has an infinite value in row 7"),
        (HELIX.T, {}, r"must be points \[point, 2 or 3\]; has shape \(3, 50\)"),
        (HELIX + 1e9, {}, "sizes from the origin: move it there"),
        (HELIX, {"smoothing": -1}, "smoothing = -1: must be a number, 0 or more, or a number of points in quotes"),
        (HELIX, {"smoothing": "much"}, "smoothing = 'much': must be a number"),
        (HELIX, {"smoothing": 2.0}, "must be at most the length of the line"),
        (HELIX, {"reverse": 1}, "reverse = 1: must be True or False"),
        (HELIX, {"nodes": 2}, "nodes = 2: must be a whole number, 3 or more"),
        (HELIX, {"frame": 1}, "frame: chooses a line of a file; points are given"),
        ("nowhere.csv", {}, "points: nowhere.csv cannot be read: No such file"),
        ("points.xyz", {}, r"points: points.xyz must end in one of .csv"),
    ],
)
def test_what_is_no_line_is_refused(points, given, said):
    with pytest.raises(SceneError, match=said):
        wr.from_centreline(points, **given)
