"""Fields of the built-in surfaces: φ, ∇φ, ∇∇φ, outward where φ > 0 (docs/model.md §5.1).

``p.v`` holds the parameters in the order of the table in ``warp_rods/membranes/built_in.py``.
"""

import warp as wp

from warp_rods.kernels.layout import real
from warp_rods.kernels.surface.geometry import Parameters
from warp_rods.kernels.surface.trigonometry import cosine, sine

wp.set_module_options({"enable_backward": False})


@wp.func
def diagonal(a: real, b: real, c: real) -> wp.mat33d:
    return wp.diag(wp.vec3d(a, b, c))


@wp.func
def plane(x: wp.vec3d, p: Parameters):
    """φ = z."""
    return x[2], wp.vec3d(real(0.0), real(0.0), real(1.0)), wp.mat33d()


@wp.func
def sphere(x: wp.vec3d, p: Parameters):
    """φ = (|x|² − R²)/2R: the distance to the surface, to first order."""
    R = p.v[0]
    return (wp.dot(x, x) - R * R) / (real(2.0) * R), x / R, diagonal(real(1.0) / R, real(1.0) / R, real(1.0) / R)


@wp.func
def ellipsoid(x: wp.vec3d, p: Parameters):
    """φ = (x²/a² + y²/b² + z²/c² − 1)/2."""
    w = wp.vec3d(real(1.0) / (p.v[0] * p.v[0]), real(1.0) / (p.v[1] * p.v[1]), real(1.0) / (p.v[2] * p.v[2]))
    g = wp.cw_mul(w, x)
    return real(0.5) * (wp.dot(g, x) - real(1.0)), g, wp.diag(w)


@wp.func
def cylinder(x: wp.vec3d, p: Parameters):
    """φ = (x² + y² − R²)/2R."""
    R = p.v[0]
    phi = (x[0] * x[0] + x[1] * x[1] - R * R) / (real(2.0) * R)
    return phi, wp.vec3d(x[0], x[1], real(0.0)) / R, diagonal(real(1.0) / R, real(1.0) / R, real(0.0))


@wp.func
def torus(x: wp.vec3d, p: Parameters):
    """φ = ((ρ − R)² + z² − r²)/2r with ρ² = x² + y²: a tube of radius r about a circle of radius R."""
    rho = wp.sqrt(x[0] * x[0] + x[1] * x[1])
    d = rho - p.v[0]
    e = wp.vec3d(x[0] / rho, x[1] / rho, real(0.0))
    z = wp.vec3d(real(0.0), real(0.0), real(1.0))
    phi = (d * d + x[2] * x[2] - p.v[1] * p.v[1]) / (real(2.0) * p.v[1])
    hoop = diagonal(real(1.0), real(1.0), real(0.0)) - wp.outer(e, e)
    H = wp.outer(e, e) + hoop * (d / rho) + wp.outer(z, z)
    return phi, (e * d + z * x[2]) / p.v[1], H / p.v[1]


@wp.func
def cassini(x: wp.vec3d, p: Parameters):
    """φ = (ρ² + z² + a²)² − 4a²z² − b⁴: a dumbbell along z for a < b < √2 a, waist radius √(b² − a²)."""
    a2 = p.v[0] * p.v[0]
    z = wp.vec3d(real(0.0), real(0.0), x[2])
    Q = wp.dot(x, x) + a2
    phi = Q * Q - real(4.0) * a2 * x[2] * x[2] - p.v[1] * p.v[1] * p.v[1] * p.v[1]
    g = real(4.0) * Q * x - real(8.0) * a2 * z
    H = real(8.0) * wp.outer(x, x) + diagonal(real(4.0) * Q, real(4.0) * Q, real(4.0) * Q - real(8.0) * a2)
    return phi, g, H


@wp.func
def bridge(x: wp.vec3d, p: Parameters):
    """φ = (x² + y² − ρ(z)²)/2, ρ = neck + (body − neck)(1 − exp(−z²/width²)): the neck between two cells."""
    w2 = p.v[2] * p.v[2]
    bump = (p.v[1] - p.v[0]) * wp.exp(-x[2] * x[2] / w2)
    rho = p.v[1] - bump
    slope = bump * real(2.0) * x[2] / w2
    bend = bump * (real(2.0) / w2 - real(4.0) * x[2] * x[2] / (w2 * w2))
    phi = real(0.5) * (x[0] * x[0] + x[1] * x[1] - rho * rho)
    return phi, wp.vec3d(x[0], x[1], -rho * slope), diagonal(real(1.0), real(1.0), -slope * slope - rho * bend)


@wp.func
def undulated(x: wp.vec3d, p: Parameters):
    """φ = |x|² − R² + ε(cos kx + cos ky + cos kz): a sphere with bumps."""
    k = p.v[2]
    c = wp.vec3d(cosine(k * x[0]), cosine(k * x[1]), cosine(k * x[2]))
    s = wp.vec3d(sine(k * x[0]), sine(k * x[1]), sine(k * x[2]))
    phi = wp.dot(x, x) - p.v[0] * p.v[0] + p.v[1] * (c[0] + c[1] + c[2])
    two = wp.vec3d(real(2.0), real(2.0), real(2.0))
    return phi, real(2.0) * x - s * (p.v[1] * k), wp.diag(two - c * (p.v[1] * k * k))
