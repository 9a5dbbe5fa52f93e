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


def test_a_rigid_motion_of_the_start_moves_the_solution(device, verified):
    R, r = Rotation.from_rotvec([0.4, 1.1, -0.8]).as_matrix(), np.array([3.0, -1.0, 2.0])
    rods, moved = in_space(device), in_space(device, rotation=R, position=r)
    rods.step(STEP, 300)
    moved.step(STEP, 300)
    error = abs(moved.position - rods.position @ R.T - r).max()
    verified.below(
        "symmetry", "swimmer: a rotated and moved start", measured=error, bound=1e-12,
        reference="the solution rotated and moved, 300 steps",
    )  # fmt: skip
    verified.same("swimmer: strains after a rigid motion of the start", moved.strain, rods.strain, reference="unmoved")


def test_a_mirrored_start_with_the_opposite_moment_mirrors_the_solution(device, verified):
    """In the plane of the first two directors; the strain about its normal keeps its sign."""
    mirror = np.array([-1.0, -1.0, 1.0])
    rods = in_space(device)
    mirrored = in_space(device, moment=-MOMENT, shape=strain_in_space(65) * mirror)
    rods.step(STEP, 300)
    mirrored.step(STEP, 300)
    verified.below(
        "symmetry", "swimmer: a mirrored start with the opposite moment", measured=abs(
            mirrored.position - rods.position * [1, 1, -1]
        ).max(), bound=1e-11, reference="the mirrored solution, 300 steps",
    )  # fmt: skip


@pytest.mark.parametrize("third", [1, 2])
def test_a_change_of_gauge_does_not_change_the_motion(device, third, verified):
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
    found = {"place": (turned.position, rods.position, 1e-12)}
    found["strain"] = (turned.strain, symmetry.gauge_strain(rods.strain, angle), 1e-11)
    for name, (ours, theirs, bound) in found.items():
        verified.below(
            "symmetry", f"swimmer: {name} after a change of gauge by {third}/3 of a turn",
            measured=abs(ours - theirs).max(), bound=bound, reference="(C.69)–(C.78): one motion",
        )  # fmt: skip


def test_planar_motion_stays_planar(device, verified):
    rods = planar(device, bend=1e-4)
    start = rods.position
    rods.step(STEP, 1000)
    out = np.concatenate([rods.position[..., 2].ravel(), rods.strain[..., :2].ravel()])
    verified.below(
        "symmetry", "swimmer: departure from the plane of a planar start", measured=abs(out).max(), bound=0.0,
        reference="0 after 1000 steps",
    )  # fmt: skip
    assert abs(rods.position - start).max() > 0.1


def test_symmetric_states_stay_symmetric_without_being_forced_to(device, verified):
    rods = writhing(device)
    rods.step(STEP, 200)
    strain, activity = rods.strain[0], rods.activity[0]
    verified.below(
        "symmetry", "swimmer: parities that nothing enforces, over the largest strain",
        measured=symmetry.parity_residual(strain, activity) / abs(strain).max(), bound=1e-12,
        reference="(C.50), 200 steps",
    )  # fmt: skip


def test_an_imposed_symmetry_is_exact(device, verified):
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
    verified.below(
        "symmetry", "swimmer: an imposed symmetry under rotation by π, in places",
        measured=symmetry.axis_residual(rods.position[0], axis), bound=1e-11, reference="(C.52) after 20 000 steps",
    )  # fmt: skip
    assert symmetry.parity_residual(free.strain[0], free.activity[0]) > 1e-6


def test_symmetric_rods_refuse_external_forces(device):
    with pytest.raises(SceneError, match="symmetric"):
        writhing(device, symmetric=True).force = np.zeros(3)


@pytest.mark.parametrize("steps", [10_000, pytest.param(100_000, marks=pytest.mark.long)])
def test_nothing_drifts(device, steps, verified):
    """Directors, as they are kept, are orthonormal, and segments have their length to round-off.

    Orientations are unit quaternions whatever the directors are: they are compared with the tangents that are kept.
    """
    rods = writhing(device, bend=1e-4, moment=1e-2)
    rods.step(STEP, steps)
    rotation, position = rods.rotation[0], rods.position[0]
    assert not rods.status.any()
    assert abs(rods.strain).max() > 1  # it still swims, bent
    after = f"{steps} steps"
    errors = {
        "RᵀR − 1 of the directors": (abs(rotation.transpose(0, 2, 1) @ rotation - np.eye(3)).max(), 1e-13),
        "det R − 1": (abs(np.linalg.det(rotation) - 1).max(), 1e-13),
        "relative error of the lengths of segments": (abs(arc_lengths(rotation, position) * 64 - 1).max(), 1e-12),
        "tangents of the saved quaternions against the directors": (
            abs(Rotation.from_quat(rods.orientation[0]).as_matrix()[:, :, 0] - rotation[:, :, 0]).max(), 1e-13
        ),
    }  # fmt: skip
    for name, (error, bound) in errors.items():
        verified.below(
            "constraint", f"swimmer that writhes, {after}: {name}", measured=error, bound=bound, reference="0"
        )


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
