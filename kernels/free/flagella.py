"""Laws of the flagellar field f, the active force per length along the tangent (4.12).

A law gives ``source`` and ``sink`` in ``τf ∂f/∂t = source − sink f + D f''``. The sink is implicit in time: write what
opposes f there. To add a law, add a number, a function and a branch of ``reaction`` here, and a row with its parameters
to the table in ``warp_rods/scene/flagella.py``. Fields are those of a tile of rods (``kernels/lanes.py``): take
``where`` for ``if``; ``parameters[0]`` is the first parameter. ``s`` is the arc length from the middle.
"""

import warp as wp

from warp_rods.kernels.lanes import WIDTH, Block, Lanes, add, div, mul, sub  # noqa: F401 (operators)
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

RELAXING = wp.constant(0)
HELD = wp.constant(1)
DRIVEN = wp.constant(2)


@wp.func
def relaxing(activity: Lanes, axial_velocity: Lanes, parameters: Block):
    """Flagella align with the flow along the body: ``(1 − f²) u0`` (4.12)."""
    return axial_velocity, activity * axial_velocity


@wp.func
def driven(s: real, parameters: Block):
    """Flagella relax towards a target: ``front`` where s > 0, ``back`` where s < 0, joined by tanh(``steepness`` s)."""
    front, back, steepness = parameters[0], parameters[1], parameters[2]
    join = Lanes()
    for lane in range(WIDTH):
        join[lane] = wp.tanh(steepness[lane] * s)
    half = real(0.5)
    return half * (front + back) + half * (front - back) * join, Lanes(real(1.0))


@wp.func
def reaction(law: int, s: real, activity: Lanes, axial_velocity: Lanes, parameters: Block):
    """(source, sink) of a law at a node, from s, f, the tangential velocity u0 and the parameters of the law."""
    if law == RELAXING:
        return relaxing(activity, axial_velocity, parameters)
    if law == DRIVEN:
        return driven(s, parameters)
    return Lanes(), Lanes()
