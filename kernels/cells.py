"""Frames of a tile of rods from one node to the next: exponentials of mean strains (D.81), (D.82); see ``lie.py``."""

import warp as wp

from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Matrix,
    Vector,
    add,
    any_of,
    dot,
    less,
    mul,
    rods_in,
    rows,
)
from warp_rods.kernels.layout import real
from warp_rods.kernels.lie import SERIES_BELOW, coefficients, factorial

wp.set_module_options({"enable_backward": False})


def _horner(shift: int) -> str:
    """``sum (-1)^j t^j/(2j + shift)!``, eight terms, which reach round-off at t = 1."""
    terms = [f"{(-1) ** j / factorial(2 * j + shift)!r}" for j in range(8)]
    text = terms[7]
    for term in reversed(terms[:7]):
        text = f"({term} + t * {text})"
    return text


@wp.func_native(
    rows(
        "Vector",
        "s",
        f"auto t = S[0]; auto c = {_horner(3)}; R[0] = 1.0 - t * c; R[1] = 0.5 - t * {_horner(4)}; R[2] = c;",
    )
)
def series(s: Lanes) -> Vector:
    """A, B, C of (B.15), (B.16) by power series in the square of the angle."""


@wp.func
def coefficients_of(square: Lanes):
    """A, B, C of (B.15), (B.16) from the square of the angle; rod by rod where series do not reach."""
    found = series(square)
    if any_of(less(Lanes(SERIES_BELOW), square)):
        for lane in range(rods_in(0, WIDTH)):
            if square[lane] > SERIES_BELOW:
                a, b, c = coefficients(wp.vec3d(wp.sqrt(square[lane]), real(0.0), real(0.0)))
                found[0, lane] = a
                found[1, lane] = b
                found[2, lane] = c
    return found


@wp.func_native(
    rows(
        "Matrix",
        "tf",
        """auto x = T[0], y = T[1], z = T[2], a = F[0], b = F[1];
        R[0] = 1.0 - b * (y * y + z * z); R[1] = b * x * y - a * z; R[2] = b * x * z + a * y;
        R[3] = b * x * y + a * z; R[4] = 1.0 - b * (x * x + z * z); R[5] = b * y * z - a * x;
        R[6] = b * x * z - a * y; R[7] = b * y * z + a * x; R[8] = 1.0 - b * (x * x + y * y);""",
    )
)
def hat_polynomial(t: Vector, f: Vector) -> Matrix:
    """``1 + f0 hat + f1 hat²`` of t."""


@wp.func_native(
    rows(
        "Vector",
        "tf",
        "R[0] = 1.0 - F[2] * (T[1] * T[1] + T[2] * T[2]);"
        "R[1] = F[2] * T[0] * T[1] + F[1] * T[2]; R[2] = F[2] * T[0] * T[2] - F[1] * T[1];",
    )
)
def mean_tangent(t: Vector, f: Vector) -> Vector:
    """``(1 + f1 hat + f2 hat²) e0`` of t: the mean of the tangent on the way, in the frame at its start."""


@wp.func
def advance_cell(R: Matrix, r: Vector, strain: Vector, ds: Lanes):
    """``S exp(ds (strain, e0))``: the frame one cell further along an inextensible, unshearable rod."""
    theta = ds * strain
    abc = coefficients_of(dot(theta, theta))
    return R * hat_polynomial(theta, abc), r + R * (ds * mean_tangent(theta, abc))
