"""Steps of one ensemble under a force and a stiffness of contact that are given as functions of the places."""

import numpy as np

DOUBLINGS = 10


def lengths_of_steps(rods, dt, steps):
    """Equal steps; the first of all is divided into steps that begin with dt/1024 twice and then double."""
    if rods.time > 0 or not steps:
        return [dt] * steps
    return [dt * 2.0 ** (k - DOUBLINGS) for k in (0, *range(DOUBLINGS))] + [dt] * (steps - 1)


def take_steps(rods, dt, steps, force=None, stiffness=None):
    """Equal steps under ``force`` (t, r [rod, node, 3]) and the ``stiffness`` (r) [rod, node, 3, 3] of contact, if any.

    Both are evaluated where and when contact evaluates them: at the extrapolated end of each step.
    """
    for length in lengths_of_steps(rods, dt, steps):
        try_one(rods, length, force, stiffness)
        rods.accept_step()
        rods.finish_step()
    rods.show()


def try_one(rods, dt, force=None, stiffness=None):
    """A step without its end."""
    if force is not None:
        _ = rods.force_array
    if stiffness is not None:
        _ = rods.contact_stiffness_array
    rods.set_step(dt)
    rods.prepare_step(dt)
    rods.predict_step()
    if force is not None:
        r = rods.position_array.numpy().copy()
        rods.force_array.assign(np.broadcast_to(force(rods.time + dt, r), r.shape))
    if stiffness is not None:
        rods.contact_stiffness_array.assign(np.ascontiguousarray(np.broadcast_to(stiffness(r), (*r.shape, 3))))
    rods.try_step()
