"""Path-ordered products along a rod and in time: exact for constant strain, second order for varying strain."""

import numpy as np
import pytest
import warp as wp
from examples.framed_curve import curve
from reference import lie as reference
from scipy.integrate import cumulative_simpson
from scipy.spatial.transform import Rotation

from warp_rods.kernels import lie
from warp_rods.kernels.layout import per_node, per_rod, real

wp.set_module_options({"enable_backward": False})


@wp.kernel
def advance_repeatedly(
    omega: wp.array2d[wp.vec3d],
    u: wp.array2d[wp.vec3d],
    dt: wp.array[real],
    R: wp.array2d[wp.mat33d],
    r: wp.array2d[wp.vec3d],
):
    """Frames ``S[k+1] = S[k] exp(dt A[k])`` from the one in column 0."""
    i = wp.tid()
    for k in range(omega.shape[1]):
        Q, q = lie.advance(R[i, k], r[i, k], omega[i, k], u[i, k], dt[i])
        R[i, k + 1] = Q
        r[i, k + 1] = q


def frames_of(strain, spacing, start, R0, r0, device) -> tuple[np.ndarray, np.ndarray]:
    """Frames ``[rod, node, ...]`` from those ``[rod, ...]`` at node ``start``, by the kernel."""
    rods, nodes, _ = strain.shape
    strains, places = per_node(rods, nodes, wp.vec3d, device), per_node(rods, nodes, wp.vec3d, device)
    frames, spacings = per_node(rods, nodes, wp.mat33d, device), per_rod(rods, device=device)
    seed_R, seed_r = np.zeros((rods, nodes, 3, 3)), np.zeros((rods, nodes, 3))
    seed_R[:, start], seed_r[:, start] = R0, r0
    for array, values in ((strains, strain), (frames, seed_R), (places, seed_r), (spacings, spacing)):
        array.assign(values)
    wp.launch(lie.integrate_frames, rods, [strains, spacings, start, frames, places], device=device)
    return frames.numpy(), places.numpy()


def slope(sizes: list[int], errors: list[float]) -> float:
    """The fitted order of errors at steps of 1/size."""
    return float(-np.polyfit(np.log(sizes), np.log(errors), 1)[0])


@pytest.mark.parametrize("start", [0, 7, 16])
def test_frames_equal_those_of_matrix_exponentials(device, start, verified):
    """Strains from zero to radians per cell, so that both the series and the closed forms are used."""
    rng = np.random.default_rng(start)
    strain = rng.normal(size=(4, 17, 3)) * np.array([0.0, 1.0, 10.0, 40.0])[:, None, None]
    spacing = np.array([0.1, 0.05, 0.07, 0.06])
    R0 = np.array([reference.rotation_exp(rng.normal(size=3)) for _ in range(4)])
    r0 = rng.normal(size=(4, 3))
    R, r = frames_of(strain, spacing, start, R0, r0, device)
    seed_R, seed_r = np.repeat(R0[:, None], 17, axis=1), np.repeat(r0[:, None], 17, axis=1)
    R_twin, r_twin = reference.integrate_frames(strain, spacing, start, seed_R, seed_r)
    verified.below(
        "independent", f"path-ordered products from node {start}: frames and places",
        measured=[abs(R[:3] - R_twin[:3]).max(), abs(r[:3] - r_twin[:3]).max()], bound=5e-15,
        reference="products of SciPy's `expm`, strains up to 10",
    )  # fmt: skip
    # For the last rod, with rotations of radians per cell, expm loses two digits by repeated squaring.
    np.testing.assert_allclose(R[3], R_twin[3], rtol=0, atol=1e-12)
    np.testing.assert_allclose(r[3], r_twin[3], rtol=0, atol=1e-12)
    assert abs(np.swapaxes(R, 2, 3) @ R - np.eye(3)).max() < 5e-15


def test_constant_strain_gives_a_helix_exactly_and_orthonormal_frames(device, verified):
    """``R = exp(s hat(Omega))`` and ``r = int R e0``: a helix about Omega, whatever the spacing."""
    strain, nodes, start = np.array([1.5, -2.0, 3.0]), 65, 32
    R, r = frames_of(np.tile(strain, (1, nodes, 1)), [1 / 16], start, np.eye(3), np.zeros(3), device)
    rate = np.linalg.norm(strain)
    axis = strain / rate
    s = ((np.arange(nodes) - start) / 16)[:, None]
    across, aside = np.array([1.0, 0.0, 0.0]) - axis * axis[0], np.cross(axis, [1.0, 0.0, 0.0])
    helix = axis * axis[0] * s + (across * np.sin(rate * s) + aside * (1 - np.cos(rate * s))) / rate
    turned = Rotation.from_rotvec(s * strain).as_matrix()
    verified.below(
        "exact", "path-ordered product of constant strain: places and frames",
        measured=[abs(r[0] - helix).max(), abs(R[0] - turned).max()], bound=2e-14,
        reference="a helix in closed form",
    )  # fmt: skip
    gram = abs(np.einsum("nki,nkj->nij", R[0], R[0]) - np.eye(3)).max()
    verified.below(
        "constraint", "path-ordered product of constant strain: RᵀR − 1", measured=gram, bound=2e-14, reference="0"
    )


def test_frames_are_second_order_in_the_spacing(device, verified):
    sizes, errors = [16, 32, 64, 128], []
    fine = np.linspace(-0.5, 0.5, 4097)
    tangent = curve(fine)[0][:, :, 0]
    centre_line = cumulative_simpson(tangent, x=fine, axis=0, initial=0.0)
    for size in sizes:
        s = np.linspace(-0.5, 0.5, size + 1)
        exact_R, strain = curve(s)
        exact_r = centre_line[:: 4096 // size]
        start = size // 4
        R, r = frames_of(strain[None], [1 / size], start, exact_R[start], exact_r[start], device)
        errors.append((abs(R[0] - exact_R).max(), abs(r[0] - exact_r).max()))
    found = [slope(sizes, [e[k] for e in errors]) for k in (0, 1)]
    name = "path-ordered product of varying strain: order in Δs of frames and places"
    verified.order(name, measured=found, reference="a rotation in closed form, Simpson's rule")


@pytest.mark.parametrize("rule", ["midpoint", "trapezoid"])
def test_a_frame_advanced_in_time_is_second_order(device, rule, verified):
    """Body velocities of the motion ``R = curve(t)``, ``r = (t^2, sin t, cos 3t)``."""

    def velocities(t: np.ndarray) -> np.ndarray:
        R, omega = curve(t)
        rate = np.stack([2 * t, np.cos(t), -3 * np.sin(3 * t)], axis=-1)
        return np.stack([omega, np.einsum("kji,kj->ki", R, rate)])

    sizes, errors = [16, 32, 64, 128], []
    for size in sizes:
        t = np.linspace(0.0, 1.0, size + 1)
        ends = velocities(t)
        A = velocities(0.5 * (t[1:] + t[:-1])) if rule == "midpoint" else 0.5 * (ends[:, 1:] + ends[:, :-1])
        exact_R, _ = curve(t)
        exact_r = np.stack([t**2, np.sin(t), np.cos(3 * t)], axis=-1)
        omega, u = (wp.array(a[None], dtype=wp.vec3d, device=device) for a in A)
        R = wp.array(np.tile(exact_R[0], (1, size + 1, 1, 1)), dtype=wp.mat33d, device=device)
        r = wp.array(np.tile(exact_r[0], (1, size + 1, 1)), dtype=wp.vec3d, device=device)
        dt = wp.array([1.0 / size], dtype=real, device=device)
        wp.launch(advance_repeatedly, 1, [omega, u, dt, R, r], device=device)
        errors.append((abs(R.numpy()[0] - exact_R).max(), abs(r.numpy()[0] - exact_r).max()))
    found = [slope(sizes, [e[k] for e in errors]) for k in (0, 1)]
    name = f"frame advanced in time, {rule} rule: order in Δt of frame and place"
    verified.order(name, measured=found, reference="a rigid motion in closed form")
