"""Gauge transformations and the π-rotation symmetry of appendix C.4."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from warp_rods.rods import modes
from warp_rods.theory.symmetry import axis_residual, gauge_frame, gauge_strain, parity_residual, symmetric_gauge

S = np.linspace(-0.5, 0.5, 65)
ACTIVITY = -np.tanh(10 * S)


def writhing_strain() -> np.ndarray:
    """(C.63)–(C.65): even twist, odd Ω₁, even Ω₂."""
    envelope = 6 * modes.beam_mode(0, S)
    twist = 8 * np.log(np.cosh(10 * S) / np.cosh(5)) / 10
    return np.stack([twist, -envelope * np.sin(2 * np.pi * S), envelope * np.cos(2 * np.pi * S)], axis=-1)


def rebuild(strain: np.ndarray, middle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frames [node, 3, 3] and centre line [node, 3] from the middle outwards, exact for mean strains of cells."""
    step, half = S[1] - S[0], len(S) // 2
    frames, line = [middle] * len(S), [np.zeros(3)] * len(S)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    for i in range(half, len(S) - 1):
        for a, b, sign in ((i, i + 1, 1), (2 * half - i, 2 * half - i - 1, -1)):
            mean = 0.5 * (strain[a] + strain[b]) * sign * step
            frames[b] = frames[a] @ Rotation.from_rotvec(mean).as_matrix()
            tangents = [Rotation.from_rotvec(mean * (1 + x) / 2).as_matrix()[:, 0] for x in nodes]
            line[b] = line[a] + sign * step * frames[a] @ (weights @ np.array(tangents)) / 2
    return np.array(frames), np.array(line)


def test_parity_of_the_writhing_state_with_and_without_perturbation():
    strain = writhing_strain()
    assert parity_residual(strain, ACTIVITY) < 1e-14
    assert abs(parity_residual(strain, ACTIVITY + 0.1) - 0.1) < 1e-14
    strain[3, 0] += 0.02
    assert abs(parity_residual(strain, ACTIVITY) - 0.01) < 1e-14


@pytest.mark.parametrize("angle", [-2.0, 0.3, 1.2])
def test_the_symmetric_gauge_is_found(angle):
    turned = gauge_strain(np.stack([writhing_strain()] * 2), angle)
    assert np.all(parity_residual(turned, ACTIVITY) > 0.1)
    found = symmetric_gauge(turned)
    assert found.shape == (2,)
    np.testing.assert_allclose(np.sin(found + angle), 0.0, atol=1e-13)
    assert np.all(parity_residual(gauge_strain(turned, found), ACTIVITY) < 1e-12)


def test_strains_of_that_parity_make_a_centre_line_symmetric_about_its_first_normal():
    middle = Rotation.from_rotvec([0.4, -1.0, 0.7]).as_matrix()
    frames, line = rebuild(writhing_strain(), middle)
    assert axis_residual(line, middle[:, 1]) < 1e-13
    assert axis_residual(line, middle[:, 2]) > 0.1
    assert axis_residual(np.stack([line, line]), np.stack([middle[:, 1]] * 2)).shape == (2,)
    assert frames.shape == (65, 3, 3)


def test_a_change_of_gauge_leaves_the_centre_line_unchanged(verified):
    """S → SG⁻¹ and A → GAG⁻¹ (C.41), (C.42) describe the same curve."""
    strain, angle = writhing_strain(), 0.9
    frames, line = rebuild(strain, np.eye(3))
    other_frames, other_line = rebuild(gauge_strain(strain, angle), gauge_frame(np.eye(3)[None], angle)[0])
    verified.below(
        "symmetry", "centre line of strains in another gauge", measured=np.abs(other_line - line).max(), bound=1e-13,
        reference="(C.41), (C.42): unchanged",
    )  # fmt: skip
    np.testing.assert_allclose(other_frames, gauge_frame(frames, angle), atol=1e-12)
    turned = Rotation.from_rotvec(-angle * frames[7, :, 0]).as_matrix() @ frames[7]
    np.testing.assert_allclose(gauge_frame(frames, angle)[7], turned, atol=1e-13)
