"""Steps of one ensemble whose lengths are known, under forces that are given as functions of the places."""

import numpy as np

from warp_rods.rods.together import Together

DOUBLINGS = 10


def lengths_of_steps(rods, dt, steps):
    """Equal steps; the first of all is divided into steps that begin with dt/1024 twice and then double."""
    if rods.reached > 0 or not steps:
        return [dt] * steps
    return [dt * 2.0 ** (k - DOUBLINGS) for k in (0, *range(DOUBLINGS))] + [dt] * (steps - 1)


def take_steps(rods, dt, steps, force=None, stiffness=None):
    """Equal steps under ``force`` (t, r [rod, node, 3]) and the ``stiffness`` (r) [rod, node, 3, 3] of contact, if any.

    Both are evaluated where and when contact evaluates them: at the extrapolated end of each step. Unlike ``step``,
    which divides the first steps by their error, the lengths are those of ``lengths_of_steps``.
    """
    for length in lengths_of_steps(rods, dt, steps):
        take_one(rods, length, force, stiffness)
    rods.show()


def take_one(rods, dt, force=None, stiffness=None):
    """One step of this length, undivided."""
    try_one(rods, dt, force, stiffness)
    rods.accept_step()
    rods.finish_step()
    rods.end_planned_step()


def try_one(rods, dt, force=None, stiffness=None):
    """A step without its end."""
    forces = Given(rods, force, stiffness)
    rods.set_step(dt)
    rods.prepare_step(dt)
    rods.predict_step()
    forces.apply()
    rods.apply_given_force()
    rods.try_step()


def together(rods, force, stiffness=None):
    """Steps as a simulation takes them, under these forces."""
    return Together([rods], Given(rods, force, stiffness))


class Given:
    """Forces of ``Together`` from functions."""

    def __init__(self, rods, force, stiffness):
        self._rods, self._force, self._stiffness = rods, force, stiffness
        if force is not None:
            _ = rods.force_array
        if stiffness is not None:
            _ = rods.contact_stiffness_array

    def apply(self):
        """Write them at the present places; returns that no node has moved."""
        rods = self._rods
        r = rods.position_array.numpy().copy()
        if self._force is not None:
            rods.force_array.assign(np.broadcast_to(self._force(rods.reached + rods._clock.step, r), r.shape))
        if self._stiffness is not None:
            K = np.broadcast_to(self._stiffness(r), (*r.shape, 3))
            rods.contact_stiffness_array.assign(np.ascontiguousarray(K))
        return 0.0

    def keep(self):
        """Displacements are not counted."""
