"""Contact as drag in a step of surface-bound filaments (docs/model.md §6.4).

The force at the end of a step is that at the extrapolated positions r*, less K (r − r*), K = Σ_j w_j |∂f/∂d| d̂d̂ᵀ where
contact pushes. With the formula of the step r − r* = (u − u*)/a. Both nodes of a pair move, which counts twice::

    f = f(r*) − D (u − u*),    D = 2K/a,    u* = (r*ⁿ⁺¹ − r*ⁿ)/(tⁿ⁺¹ − tⁿ)

D u is drag, its parts in the tangent plane C11, C12, C22; D u* is added to the force. The error of u* is of first order
in Δt and that of the step of second, as without contact.
"""

import warp as wp

from warp_rods.kernels.bound.levels import History, Plan
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import Matrices2D, real

wp.set_module_options({"enable_backward": False})


@wp.kernel
def set_contact_drag(f: Filaments, past: History, plan: Plan, stiffness: Matrices2D):
    """C of each node from K [rod, node] in space, and D u* added to the force; ``dim = (rods, nodes)``."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    R = f.rotation[rod, i]
    D = (real(2.0) / plan.rate[rod]) * (wp.transpose(R) * stiffness[rod, i] * R)
    u = wp.transpose(R) * (f.position[rod, i] - past.foretold[rod, i]) / (plan.end[rod] - past.foretold_at[rod])
    f.contact_drag[rod, i] = wp.vec3d(D[0, 0], D[0, 1], D[1, 1])
    f.force[rod, i] += R * wp.vec3d(D[0, 0] * u[0] + D[0, 1] * u[1], D[0, 1] * u[0] + D[1, 1] * u[1], real(0.0))


@wp.kernel
def keep_foretold(f: Filaments, past: History):
    """Keep the positions of the extrapolated state of a step that was taken; ``dim = (rods, nodes)``."""
    rod, i = wp.tid()
    if f.active[rod] == 1:
        past.foretold[rod, i] = f.position[rod, i]


@wp.kernel
def keep_time_foretold(f: Filaments, past: History, plan: Plan):
    """Keep the time of that state; ``dim = rods``."""
    rod = wp.tid()
    if f.active[rod] == 1:
        past.foretold_at[rod] = plan.end[rod]
