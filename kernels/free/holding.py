"""Ends that are held at places in space, and loads with directions in space (docs/model.md §2.11).

A held end gets the velocity of its place at the end of the step, and what it has drifted off before, over Δt: the
velocities of the equations discretised in s are those of the nodes only up to errors of second order. Δt is that of the
last step, in which the drift arose, or of this one if that is longer; a shorter step must not mean a faster correction.
"""

import warp as wp

from warp_rods.kernels.clock import STEP
from warp_rods.kernels.free.output import angle_from, material
from warp_rods.kernels.free.state import CLAMPED, FREE, End, Midpoint, Shape, Swimmers
from warp_rods.kernels.lanes import WIDTH, Vector, rods_in
from warp_rods.kernels.layout import Matrices2D, Scalars1D, Vectors2D, real
from warp_rods.kernels.lie import rotation_log
from warp_rods.kernels.multistep import Pace

wp.set_module_options({"enable_backward": False})


NO_TIME = wp.constant(real(1.0e-300))
"""Δt where there is neither step nor drift yet."""


@wp.struct
class Hold:
    """What holds or loads both ends of rods in space [rod, end]."""

    position: Vectors2D  # where they are held now
    rotation: Matrices2D  # and how their material frame is turned
    velocity: Vectors2D  # of these at the end of the step
    angular_velocity: Vectors2D
    drift: Vectors2D  # from the rod to there, in the material frame of the end
    drift_angle: Vectors2D
    force: Vectors2D  # dead loads
    couple: Vectors2D
    along: Vectors2D  # (thrust, torque, 0): loads along and about the tangent


@wp.func
def end_node(end: int, nodes: int) -> int:
    """The node of the first (0) or last (1) end."""
    return end * (nodes - 1)


@wp.kernel
def find_drift(rods: Swimmers, shape: Shape, midpoint: Midpoint, rotation: Matrices2D, position: Vectors2D, hold: Hold):
    """How far the ends are from where they are held, from the present frames; ``dim = (rods, 2)``."""
    rod, end = wp.tid()
    node = end_node(end, position.shape[1])
    angle = midpoint.angle[rod] + angle_from(rod, rods.tracked, node, rods.spacing, shape.twist)
    R = wp.transpose(material(rotation[rod, node], angle))
    hold.drift[rod, end] = R * (hold.position[rod, end] - position[rod, node])
    hold.drift_angle[rod, end] = rotation_log(R * hold.rotation[rod, end])


@wp.func
def turned(v: wp.vec3d, angle: real):
    """A vector of the material frame in the Bishop frame."""
    c, s = wp.cos(angle), wp.sin(angle)
    return wp.vec3d(v[0], c * v[1] - s * v[2], s * v[1] + c * v[2])


@wp.func
def set_lane(field: wp.array(dtype=Vector), rod: int, v: wp.vec3d):
    """Set the value of one rod."""
    values = field[rod // WIDTH]
    for i in range(3):
        values[i, rod % WIDTH] = v[i]
    field[rod // WIDTH] = values


@wp.func
def set_end(rod: int, index: int, end: End, R: wp.mat33d, angle: real, dt: real, hold: Hold):
    """Velocities and loads of an end whose Bishop frame at the extrapolated shape is R."""
    to_body = wp.transpose(R)
    if end.kind == FREE:
        thrust = wp.vec3d(hold.along[rod, index][0], real(0.0), real(0.0))
        set_lane(end.force, rod, to_body * hold.force[rod, index] + thrust)
    else:
        u = to_body * hold.velocity[rod, index] + turned(hold.drift[rod, index], angle) / dt
        set_lane(end.velocity, rod, u)
    if end.kind == CLAMPED:
        omega = to_body * hold.angular_velocity[rod, index] + turned(hold.drift_angle[rod, index], angle) / dt
        set_lane(end.angular_velocity, rod, omega)
    else:
        torque = wp.vec3d(hold.along[rod, index][1], real(0.0), real(0.0))
        set_lane(end.couple, rod, to_body * hold.couple[rod, index] + torque)


@wp.kernel
def set_ends(
    rods: Swimmers,
    shape: Shape,
    angle: Scalars1D,
    pace: Pace,
    clock: Scalars1D,
    rotation: Matrices2D,
    hold: Hold,
):
    """Conditions at both ends at the extrapolated shape; ``dim = tiles``."""
    tile = wp.tid()
    last = rotation.shape[1] - 1
    for lane in range(rods_in(tile, rotation.shape[0])):
        rod = tile * WIDTH + lane
        dt = wp.max(wp.max(clock[STEP], pace.at[rod, 0] - pace.at[rod, 1]), NO_TIME)
        first_angle = angle[rod] + angle_from(rod, rods.tracked, 0, rods.spacing, shape.twist)
        last_angle = angle[rod] + angle_from(rod, rods.tracked, last, rods.spacing, shape.twist)
        set_end(rod, 0, rods.first, rotation[rod, 0], first_angle, dt, hold)
        set_end(rod, 1, rods.last, rotation[rod, last], last_angle, dt, hold)
