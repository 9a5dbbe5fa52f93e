"""One cell of a rod further: exponentials of mean strains for a tile of rods (D.69) to (D.71)."""

import warp as wp

from warp_rods.kernels.bound.rod import in_space
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Vector,
    add,
    any_of,
    dot,
    each,
    less,
    mul,
    sub,
    vector,
)
from warp_rods.kernels.layout import real
from warp_rods.kernels.lie import SERIES_BELOW, SERIES_C, SERIES_F, coefficients

wp.set_module_options({"enable_backward": False})


@wp.func_native(
    each(
        "Vector",
        """const double t = square.c[k];
    double C = c.c[7], F = f.c[7];
    for (int j = 6; j >= 0; --j) { C = c.c[j] + t * C; F = f.c[j] + t * F; }
    r.data[0][k] = 1.0 - t * C; r.data[1][k] = 0.5 - t * F; r.data[2][k] = C;""",
    )
)
def series_of(square: Lanes, c: wp.types.vector(8, real), f: wp.types.vector(8, real)) -> Vector:
    """A, B, C of (B.15), (B.16) by power series in the square of the angle."""


@wp.func_native(
    each(
        "Vector",
        """const double t = square.c[k];
    const double C = c.c[0] + t * (c.c[1] + t * (c.c[2] + t * c.c[3]));
    const double F = f.c[0] + t * (f.c[1] + t * (f.c[2] + t * f.c[3]));
    r.data[0][k] = 1.0 - t * C; r.data[1][k] = 0.5 - t * F; r.data[2][k] = C;""",
    )
)
def short_series_of(square: Lanes, c: wp.types.vector(8, real), f: wp.types.vector(8, real)) -> Vector:
    """The first terms of A, B, C: to 1e-9 for angles below 0.5, to 1e-3 below π."""


@wp.func
def coefficients_of(square: Lanes) -> Vector:
    """A, B, C of (B.15), (B.16) from the square of the angle."""
    found = series_of(square, SERIES_C, SERIES_F)
    if any_of(less(Lanes(SERIES_BELOW), square + real(1.0e-300))):
        k = int(0)  # noqa: RUF046, UP018 (a variable, so that the loop is not unrolled)
        while k < WIDTH:
            if square[k] >= SERIES_BELOW:
                a, b, c = coefficients(wp.vec3d(wp.sqrt(square[k]), real(0.0), real(0.0)))
                found[0, k] = a
                found[1, k] = b
                found[2, k] = c
            k += 1
    return found


@wp.func_native(
    each(
        "Vector",
        """const double x = theta.data[0][k], y = theta.data[1][k], z = theta.data[2][k];
    const double a = first.c[k], b = second.c[k];
    r.data[0][k] = 1.0 - b * (y * y + z * z);
    r.data[1][k] = b * x * y + a * z;
    r.data[2][k] = b * x * z - a * y;""",
    )
)
def turned_tangent(theta: Vector, first: Lanes, second: Lanes) -> Vector:
    """``(1 + first hat + second hat²) e0``."""


@wp.func
def about_one_cell_further(f: Filaments, tile: int, i: int, r: Vector, strain: Vector, ds: Lanes):
    """As ``one_cell_further`` with ``short_series_of``."""
    theta = ds * strain
    return moved(f, tile, i, r, theta, short_series_of(dot(theta, theta), SERIES_C, SERIES_F), ds)


@wp.func
def one_cell_further(f: Filaments, tile: int, i: int, r: Vector, strain: Vector, ds: Lanes):
    """Place and tangent of ``S exp(ds (strain, e0))`` from the frame at node i and its place r (D.81), (D.82)."""
    theta = ds * strain
    return moved(f, tile, i, r, theta, coefficients_of(dot(theta, theta)), ds)


@wp.func
def moved(f: Filaments, tile: int, i: int, r: Vector, theta: Vector, abc: Vector, ds: Lanes):
    """Place and tangent of ``S exp(θ, ds e0)`` with the coefficients A, B, C."""
    x = r + ds * in_space(f, tile, i, turned_tangent(theta, abc[1], abc[2]))
    return x, in_space(f, tile, i, turned_tangent(theta, abc[0], abc[1]))
