"""Path-ordered products: frames from strains along a rod, or from velocities in time, and back (2.46) to (2.48)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warp_rods import arguments
from warp_rods.errors import named
from warp_rods.frames import checks
from warp_rods.frames.motions import Pair, ad, se3_compose, se3_exp, se3_inverse, se3_log

ALONG = (1.0, 0.0, 0.0)
"""The strain U = e0 of a rod that neither stretches nor shears."""


def _first(A: np.ndarray) -> np.ndarray:
    return A[..., :-1, :]


def _mean(A: np.ndarray) -> np.ndarray:
    return 0.5 * (A[..., :-1, :] + A[..., 1:, :])


def _given(A: np.ndarray) -> np.ndarray:
    return A


def _integral(A: np.ndarray) -> np.ndarray:
    """The mean over each cell of the cubic through its four nearest nodes, and of its mirror image at the ends."""
    inner = (13 * (A[..., 1:-2, :] + A[..., 2:-1, :]) - A[..., :-3, :] - A[..., 3:, :]) / 24
    ends = [(9 * B[..., [0], :] + 19 * B[..., [1], :] - 5 * B[..., [2], :] + B[..., [3], :]) / 24
            for B in (A, A[..., ::-1, :])]  # fmt: skip
    return np.concatenate([ends[0], inner, ends[1]], axis=-2)


RULES: dict[str, tuple[Callable[[np.ndarray], np.ndarray], int]] = {
    "forward": (_first, 2),
    "mean": (_mean, 2),
    "midpoint": (_given, 1),
    "magnus": (_integral, 4),
}
"""By name: the mean generator of each cell from those at nodes, and the nodes that it needs. ``midpoint``: from
generators in the middles of the cells. Orders: 1, 2, 2, 4; ``magnus`` adds the commutator of (4.27)."""


def path_product(
    strain: ArrayLike,
    spacing: ArrayLike,
    stretch: ArrayLike = ALONG,
    *,
    rule: str = "mean",
    start: int = 0,
    R: ArrayLike = np.eye(3),  # noqa: B008 (never changed)
    r: ArrayLike = (0.0, 0.0, 0.0),
) -> Pair:
    """Frames (R [..., node, 3, 3], r [..., node, 3]) of ∂s S = S (Ω, U), from the one at the node ``start`` outwards.

    strain: Ω [..., node, 3], 1/length, twist first; stretch: U [..., node, 3], e0 by default (inextensible and
    unshearable). Velocities (ω, u) and time steps give the motion of a frame in the same way (4.4), (4.5). spacing: Δs,
    a number or one for each curve [...]. R [..., 3, 3], r [..., 3]: the frame at ``start``.

    Rules, a cell S exp(Δs A) each: "forward", A at its first node, order 1 (2.48), (D.74); "mean" of both its nodes,
    order 2 (4.30), (D.77), as ensembles do; "midpoint", order 2, where strains are given in the middles of cells and
    frames are one more; "magnus", order 4, by cubics through four nodes and the commutator of (4.27). All of them are
    exact for constant strain. Raises SceneError for too few nodes and an unknown rule.
    """
    of_cells, least = named(RULES, "rule", rule)
    omega = checks.nodal_vectors("strain", strain, least)
    u = checks.vectors("stretch", stretch)
    omega, u = np.broadcast_arrays(omega, u)
    ds = checks.spacings(spacing, omega.shape[:-2])[..., None]
    X = ds * of_cells(np.concatenate([omega, u], axis=-1))
    if rule == "magnus":
        X = X + ds**2 / 12 * _commutator(omega, u)
    cells = se3_exp(X[..., :3], X[..., 3:])
    nodes = X.shape[-2] + 1
    if arguments.whole("start", start, 0) >= nodes:
        raise arguments.wrong("start", start, f"a node, 0 to {nodes - 1}")
    return _outwards(cells, start, checks.rotations("R", R), checks.vectors("r", r))


def strain_of_frames(R: ArrayLike, r: ArrayLike, spacing: ArrayLike) -> Pair:
    """Mean strains (Ω, U) [..., cell, 3] between frames R [..., node, 3, 3], r [..., node, 3]: log(S⁻¹ S′)/Δs (B.17).

    The inverse of ``path_product`` by the rule "midpoint", for turns below π a cell.
    """
    R, r = checks.nodal_rotations("R", R, 2), checks.nodal_vectors("r", r, 2)
    ds = checks.spacings(spacing, R.shape[:-3])[..., None]
    back = se3_inverse(R[..., :-1, :, :], r[..., :-1, :])
    theta, mu = se3_log(*se3_compose(*back, R[..., 1:, :, :], r[..., 1:, :]))
    return theta / ds, mu / ds


def _commutator(omega: np.ndarray, u: np.ndarray) -> np.ndarray:
    """[A, A′] of the generators at both ends of each cell.

    The second term of the Magnus series of ∂s S = S A is +½ ∫∫ [A(ξ″), A(ξ′)], ξ″ < ξ′; (4.27) prints −½.
    """
    ends = (omega[..., :-1, :], u[..., :-1, :], omega[..., 1:, :], u[..., 1:, :])
    return np.concatenate(ad(*ends), axis=-1)


def _outwards(cells: Pair, start: int, R: np.ndarray, r: np.ndarray) -> Any:
    """Frames at all nodes from the one at ``start``."""
    count = cells[0].shape[-3]
    leading = np.broadcast_shapes(cells[0].shape[:-3], R.shape[:-2], r.shape[:-1])
    frames = [(np.broadcast_to(R, (*leading, 3, 3)), np.broadcast_to(r, (*leading, 3)))] * (count + 1)
    for i in range(start, count):
        frames[i + 1] = _times(frames[i], cells[0][..., i, :, :], cells[1][..., i, :])
    for i in range(start - 1, -1, -1):
        Q = np.swapaxes(cells[0][..., i, :, :], -1, -2)
        frames[i] = _times(frames[i + 1], Q, -(Q @ cells[1][..., i, :, None])[..., 0])
    return np.stack([f[0] for f in frames], axis=-3), np.stack([f[1] for f in frames], axis=-2)


def _times(frame: Pair, Q: np.ndarray, q: np.ndarray) -> Pair:
    """The product with (Q, q) from the right."""
    R, r = frame
    return R @ Q, (R @ q[..., None])[..., 0] + r
