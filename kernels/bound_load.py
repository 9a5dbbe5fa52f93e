"""What surface-bound filaments do to their membrane: the Lagrange multipliers' force (thesis 5.31, 5.32, D.28-D.34)."""

import warp as wp

from .bound_rod import spin
from .bound_state import Filaments, scalars, vectors
from .layout import real
from .stencils import derivative
from .surface import gaussian

wp.set_module_options({"enable_backward": False})


@wp.func
def normal_shear(f: Filaments, rod: int, i: int) -> real:
    """λ3 = m2' + Ω m1 − K12 m3 (D.32), the part of the internal force along n."""
    m = f.moment[rod, i]
    dm = derivative(f.moment, rod, i, f.spacing[rod])
    return dm[1] + f.geodesic[rod, i] * m[0] - f.curvature[rod, i][1] * m[2]


@wp.func
def orientation_moment(f: Filaments, rod: int, i: int) -> real:
    """χ = e0·(m' + Ω×m) − ζr ω0 (D.33)."""
    m = f.moment[rod, i]
    dm = derivative(f.moment, rod, i, f.spacing[rod])
    K = f.curvature[rod, i]
    return dm[0] - K[0] * m[2] - f.geodesic[rod, i] * m[1] - f.drag[rod][2] * spin(f, rod, i)[0]


@wp.func
def membrane_load(f: Filaments, shear3: scalars, rod: int, i: int) -> wp.vec3d:
    """Force per length on the membrane in the frame (q, n×q, n): minus the constraint force on the filament.

    Along n it balances (∂sλ + Ω×λ)·n + f·n; in the surface the filament feels χ(K12, K22) (D.35).
    """
    K = f.curvature[rod, i]
    h = f.spacing[rod]
    chi = orientation_moment(f, rod, i)
    shear2 = -derivative(f.moment, rod, i, h)[2] - f.shear[rod, i]
    f3 = wp.dot(f.rotation[rod, i] * wp.vec3d(real(0.0), real(0.0), real(1.0)), f.force[rod, i])
    press = derivative(shear3, rod, i, h) + K[1] * shear2 + K[0] * f.tension[rod, i] + f3
    return wp.vec3d(-chi * K[1], -chi * K[2], press)


@wp.kernel
def normal_shears(f: Filaments, shear3: scalars):
    """λ3 at nodes."""
    rod, i = wp.tid()
    shear3[rod, i] = normal_shear(f, rod, i)


@wp.kernel
def membrane_loads(f: Filaments, shear3: scalars, load: vectors):
    """Force per length on the membrane, in space, at nodes."""
    rod, i = wp.tid()
    load[rod, i] = f.rotation[rod, i] * membrane_load(f, shear3, rod, i)


@wp.kernel
def midpoint_gauss(f: Filaments, middle: int, gauss: wp.array(dtype=wp.float64)):
    """Gaussian curvature under each rod's middle node."""
    rod = wp.tid()
    gauss[rod] = gaussian(f.curvature[rod, middle])
