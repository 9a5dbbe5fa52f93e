"""Laws of the flagellar field f, the active force per length along the tangent (thesis 4.12).

A law gives the local part of ``τf ∂f/∂t = source − sink f + D f''``; diffusion is added for all but ``HELD``.
The sink is implicit in time, so write what opposes f there. A new law is a number, a function and a branch of
``reaction``, and a row in the table of ``warp_rods/rods/free/flagella.py``, which names its parameters.
"""

import warp as wp

from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

RELAXING = wp.constant(0)
HELD = wp.constant(1)


@wp.func
def relaxing(activity: real, axial: real, numbers: wp.vec4d):
    """Flagella align with the flow along the body: ``(1 − f²) u0`` (4.12)."""
    return axial, activity * axial


@wp.func
def reaction(law: int, activity: real, axial: real, numbers: wp.vec4d):
    """(source, sink) of a law at one node, from f, the tangential velocity u0 and the law's parameters."""
    if law == RELAXING:
        return relaxing(activity, axial, numbers)
    return real(0.0), real(0.0)
