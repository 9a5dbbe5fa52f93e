"""The active moment from the shape of the flagella (§4.2): local drag summed along a helix."""

import numpy as np
import pytest

import warp_rods as wr


def force_and_torque(pitch: float, circumference: float, drag_ratio: float, hand: float) -> tuple[float, float]:
    """Of the fluid, along and about the axis of a helix that turns at the rate 1; ζ∥ = 1, per contour length."""
    a, turn = circumference / (2 * np.pi), np.linspace(0, 2 * np.pi, 400, endpoint=False)
    r = np.stack([a * np.cos(turn), a * np.sin(turn), hand * pitch * turn / (2 * np.pi)], axis=-1)
    t = np.stack([-a * np.sin(turn), a * np.cos(turn), hand * pitch / (2 * np.pi) + 0 * turn], axis=-1)
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    v = np.cross([0.0, 0.0, 1.0], r)
    along = np.sum(v * t, axis=1, keepdims=True) * t
    f = -along - drag_ratio * (v - along)
    return f[:, 2].mean(), np.cross(r, f)[:, 2].mean()


@pytest.mark.parametrize("eta", [2.0, 1.6])
def test_the_moment_is_that_of_local_drag_on_a_helix(eta, verified):
    force, torque = force_and_torque(2.0, 1.5, eta, hand=-1.0)
    assert force < 0 and torque < 0  # left-handed: the same direction, M > 0
    right = force_and_torque(2.0, 1.5, eta, hand=1.0)
    assert right[0] == pytest.approx(-force) and right[1] == pytest.approx(torque)
    verified(
        "exact", f"moment_from_flagella, η = {eta:g}", measured=wr.moment_from_flagella(2.0, 1.5, 30.0, eta),
        expected=torque / force / 30.0, relative=1e-12, reference="local drag, summed along the helix",
    )  # fmt: skip


def test_the_numbers_of_the_text():
    """F = 2µC²ℓω/Pc of the text is the thrust of C ≪ P; with that drag its torque is 2µC²ℓω/πc, not …/π²c."""
    pitch, small = 2.0, 1e-3
    force, torque = force_and_torque(pitch, small, 2.0, hand=-1.0)
    drag = 4 * np.pi  # ζ∥ = 4πµ/c
    assert -force * drag == pytest.approx(2 * small**2 / pitch, rel=1e-6)
    assert -torque * drag == pytest.approx(2 * small**2 / np.pi, rel=1e-6)
    np.testing.assert_allclose(wr.moment_from_flagella(2.0, 1.5, [10.0, 100.0]), [8.157e-2, 8.157e-3], rtol=1e-3)
    assert wr.moment_from_flagella(pitch, small, 10.0) == pytest.approx(pitch / (10 * np.pi), rel=1e-6)


def test_it_is_the_moment_of_swimmers():
    rods = wr.FreeRods(2, 17, bend=1e-3, twist=1e-3, moment=wr.moment_from_flagella(2.0, 1.5, [50.0, 100.0]))
    np.testing.assert_allclose(rods.moment, [1.631e-2, 8.157e-3], rtol=1e-3)


@pytest.mark.parametrize(
    "given, words",
    [
        ((0.0, 1.5, 10.0), "pitch = 0: must be positive"),
        ((2.0, -1.5, 10.0), "circumference = -1.5: must be positive"),
        ((2.0, 1.5, 10.0, 1.0), "drag_ratio = 1: must be greater than 1"),
        (([1.0, 2.0], 1.5, [1.0, 2.0, 3.0]), "shapes must broadcast"),
        (("2 um", 1.5, 10.0), "pitch = '2 um': must be a number"),
    ],
)
def test_wrong_arguments_are_named(given, words):
    with pytest.raises(wr.SceneError, match=words):
        wr.moment_from_flagella(*given)
