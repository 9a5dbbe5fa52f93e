"""Active rods: rigid motions, mirror images, gauge and π-rotation symmetry; no drift of lengths and frames."""

import numpy as np
import pytest
from examples.free import MOMENT, in_space, planar, strain_in_space
from scipy.spatial.transform import Rotation

from warp_rods.errors import SceneError
from warp_rods.rods.free.rods import FreeRods
from warp_rods.theory import symmetry

STEP = 1e-3


def writhing(device, **other):
    """A rod that starts with the symmetry of appendix C.4."""
    given = {"bend": 2.5e-4, "twist": 1e-3, "moment": MOMENT, "shape": {"kind": "writhe", "amplitude": 3.0}}
    return FreeRods(1, 65, **(given | other), device=device)


def test_a_rigid_motion_of_the_start_moves_the_solution(device):
    R, r = Rotation.from_rotvec([0.4, 1.1, -0.8]).as_matrix(), np.array([3.0, -1.0, 2.0])
    rods, moved = in_space(device), in_space(device, rotation=R, position=r)
    rods.step(STEP, 300)
    moved.step(STEP, 300)
    np.testing.assert_allclose(moved.position, rods.position @ R.T + r, rtol=0, atol=1e-11)
    np.testing.assert_array_equal(moved.strain, rods.strain)


def test_a_mirrored_start_with_the_opposite_moment_mirrors_the_solution(device):
    """In the plane of the first two directors; the strain about its normal keeps its sign."""
    mirror = np.array([-1.0, -1.0, 1.0])
    rods = in_space(device)
    mirrored = in_space(device, moment=-MOMENT, shape=strain_in_space(65) * mirror)
    rods.step(STEP, 300)
    mirrored.step(STEP, 300)
    np.testing.assert_allclose(mirrored.position, rods.position * [1, 1, -1], rtol=0, atol=1e-11)


@pytest.mark.parametrize("third", [1, 2])
def test_a_change_of_gauge_does_not_change_the_motion(device, third):
    """(C.69) to (C.78): the three starts out of phase give one motion."""
    angle = 2 * np.pi * third / 3
    strain = strain_in_space(65)
    rods = in_space(device)
    turned = in_space(
        device,
        shape=symmetry.gauge_strain(strain, angle),
        rotation=symmetry.gauge_frame(np.eye(3), angle),
    )
    rods.step(STEP, 300)
    turned.step(STEP, 300)
    np.testing.assert_allclose(turned.position, rods.position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(turned.strain, symmetry.gauge_strain(rods.strain, angle), rtol=0, atol=1e-9)


def test_planar_motion_stays_planar(device):
    rods = planar(device, bend=1e-4)
    rods.step(STEP, 1000)
    assert not rods.position[..., 2].any()
    assert not rods.strain[..., :2].any()


def test_symmetric_states_stay_symmetric_without_being_forced_to(device):
    rods = writhing(device)
    rods.step(STEP, 200)
    strain, activity = rods.strain[0], rods.activity[0]
    assert symmetry.parity_residual(strain, activity) < 1e-9 * abs(strain).max()


def test_an_imposed_symmetry_is_exact(device):
    """(C.50) to (C.52) after 20 000 steps of a motion in which asymmetry grows."""
    rods, free = (writhing(device, bend=5.45e-5, moment=1e-2, symmetric=symmetric) for symmetric in (True, False))
    axis = rods.rotation[0, 32, :, 1]
    rods.step(STEP, 20_000)
    free.step(STEP, 20_000)
    rates = rods.rates()
    k, twist, activity = (rates[name][0] for name in ("bending", "twist", "activity"))
    np.testing.assert_array_equal(k, -k.conj()[::-1])
    np.testing.assert_array_equal(twist, twist[::-1])
    np.testing.assert_array_equal(activity, -activity[::-1])
    np.testing.assert_allclose(rates["tension"], rates["tension"][:, ::-1], rtol=0, atol=1e-12)
    assert symmetry.axis_residual(rods.position[0], axis) < 1e-11
    assert symmetry.parity_residual(free.strain[0], free.activity[0]) > 1e-6


def test_symmetric_rods_refuse_external_forces(device):
    with pytest.raises(SceneError, match="symmetric"):
        writhing(device, symmetric=True).force = np.zeros(3)


def test_nothing_drifts_in_a_hundred_thousand_steps(device):
    """Directors are orthonormal and segments have their length to round-off."""
    rods = writhing(device, bend=1e-4, moment=1e-2)
    rods.step(STEP, 100_000)
    rotation, position = rods.rotation[0], rods.position[0]
    assert not rods.status.any()
    assert abs(rods.strain).max() > 1  # it still swims, bent
    np.testing.assert_allclose(
        rotation.transpose(0, 2, 1) @ rotation, np.broadcast_to(np.eye(3), (65, 3, 3)), atol=1e-13
    )
    assert arc_lengths(rotation, position) == pytest.approx(np.full(64, 1 / 64), rel=1e-12)
    assert np.linalg.norm(rods.orientation[0], axis=-1) == pytest.approx(np.ones(65), abs=1e-13)


def arc_lengths(rotation, position):
    """Lengths of the screw motions from node to node; checks that they have no shear."""
    relative = rotation[:-1].transpose(0, 2, 1) @ rotation[1:]
    chord = np.einsum("nji,nj->ni", rotation[:-1], np.diff(position, axis=0))
    angle = Rotation.from_matrix(relative).as_rotvec()
    size = np.linalg.norm(angle, axis=1)[:, None]
    inverse = 1 / size**2 * (1 - size / 2 / np.tan(size / 2))
    straight = chord - np.cross(angle, chord) / 2 + inverse * np.cross(angle, np.cross(angle, chord))
    assert abs(straight[:, 1:]).max() < 1e-13
    return straight[:, 0]
