"""One cell of a filament further: exponentials of mean strains for a tile of rods (D.69) to (D.71)."""

import warp as wp

from warp_rods.kernels.bound.rod import in_space
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.cells import coefficients_of, mean_tangent
from warp_rods.kernels.lanes import Lanes, Vector, add, dot, mul, rows, vector  # noqa: F401 (operators)

wp.set_module_options({"enable_backward": False})


@wp.func_native(
    rows(
        "Vector",
        "s",
        """auto t = S[0];
        auto c = 1.0 / 6.0 - t * (1.0 / 120.0 - t * (1.0 / 5040.0 - t * (1.0 / 362880.0)));
        auto f = 1.0 / 24.0 - t * (1.0 / 720.0 - t * (1.0 / 40320.0 - t * (1.0 / 3628800.0)));
        R[0] = 1.0 - t * c; R[1] = 0.5 - t * f; R[2] = c;""",
    )
)
def short_series(s: Lanes) -> Vector:
    """The first terms of A, B, C from the square of the angle: to 1e-9 for angles below 0.5, to 1e-3 below π."""


@wp.func
def about_one_cell_further(f: Filaments, tile: int, i: int, r: Vector, strain: Vector, ds: Lanes):
    """As ``one_cell_further`` with ``short_series``."""
    theta = ds * strain
    return moved(f, tile, i, r, theta, short_series(dot(theta, theta)), ds)


@wp.func
def one_cell_further(f: Filaments, tile: int, i: int, r: Vector, strain: Vector, ds: Lanes):
    """Place and tangent of ``S exp(ds (strain, e0))`` from the frame at node i and its place r (D.81), (D.82)."""
    theta = ds * strain
    return moved(f, tile, i, r, theta, coefficients_of(dot(theta, theta)), ds)


@wp.func
def moved(f: Filaments, tile: int, i: int, r: Vector, theta: Vector, abc: Vector, ds: Lanes):
    """Place and tangent of ``S exp(θ, ds e0)`` with the coefficients A, B, C."""
    x = r + ds * in_space(f, tile, i, mean_tangent(theta, abc))
    return x, in_space(f, tile, i, mean_tangent(theta, vector(abc[0], abc[0], abc[1])))
