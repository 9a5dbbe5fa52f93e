"""Rigid rods that are pushed apart until they keep a clearance (docs/model.md §6.5).

Only rods that were moved are looked at again: two that were not are as far apart as before.
"""

import warp as wp

from warp_rods.kernels.contact.box import nearest_image
from warp_rods.kernels.contact.segments import (
    CROSSED,
    NONE,
    TINY,
    Segments,
    insert_rod,
    is_finite,
    lists_around,
    may_touch,
    middle,
    nearest_points,
    remove_rod,
)
from warp_rods.kernels.layout import Integers1D, Matrices1D, Scalars1D, Vectors1D, Vectors2D, real
from warp_rods.kernels.lie import rotation_exp

wp.set_module_options({"enable_backward": False})


@wp.struct
class Rigid:
    """Rigid rods, which follow those that stay, and their motion in a round."""

    first: int  # the number of the first one among all rods
    apart: real  # the distance to which segments that touch are pushed
    position: Vectors1D  # middles [rod]
    rotation: Matrices1D
    shape: Vectors2D  # centre lines about the middles [rod, node]
    length: Scalars1D
    moved: Integers1D  # 1 for rods that moved in the last round
    shift: Vectors1D  # sum of the translations of all pushes
    turn: Vectors1D  # sum of the rotations
    pushes: Integers1D  # number of pushes
    flat: int  # 1 for rods that rotate about z only
    low: real  # bounds of the heights z of flat rods
    high: real


@wp.func
def push_point(rods: Rigid, segments: Segments, s: int, along: real, push: wp.vec3d):
    """Give a point of a rod its displacement, shared as by a force on a uniform rod.

    The rod moves by push/(1 + 12 a²/L²) and turns by 12/L² a × of that, where a is the arm of the point.
    """
    rod = segments.rod[s] - rods.first
    if rod >= 0:
        x, y = segments.node[segments.begin[s]], segments.node[segments.end[s]]
        arm = x + along * (y - x) - rods.position[rod]
        inverse_inertia = real(12.0) / (rods.length[rod] * rods.length[rod])
        share = push / (real(1.0) + inverse_inertia * wp.dot(arm, arm))
        rods.shift[rod] += share
        rods.turn[rod] += inverse_inertia * wp.cross(arm, share)
        rods.pushes[rod] += 1


@wp.func
def direction_apart(segments: Segments, s: int, t: int, gap: wp.vec3d) -> wp.vec3d:
    """The unit vector along which to separate two segments: that of their middles if they intersect."""
    d = gap
    if wp.length(gap) < CROSSED * segments.longest:
        d = nearest_image(middle(segments, s) - middle(segments, t), segments.period)
    return d / wp.max(wp.length(d), TINY)


@wp.func
def push_apart(rods: Rigid, segments: Segments, s: int, t: int) -> real:
    """Let two segments that are close push each other; returns by how much they are too close."""
    gap, x, y = nearest_points(segments, s, t)
    distance = wp.length(gap)
    if distance >= segments.clearance:
        return real(0.0)
    push = real(0.5) * (rods.apart - distance) * direction_apart(segments, s, t, gap)
    push_point(rods, segments, s, x, push)
    push_point(rods, segments, t, y, -push)
    return segments.clearance - distance


@wp.func
def is_pair(rods: Rigid, segments: Segments, s: int, t: int) -> bool:
    """Whether segments, of which s has moved, may touch and are looked at from s.

    They are looked at once: from the rod that comes first, or from the one that has moved.
    """
    rod, other = segments.rod[s], segments.rod[t]
    if not may_touch(segments, s, t):
        return False
    if other > rod or other < rods.first:
        return True
    return rods.moved[other - rods.first] == 0


@wp.func
def push_from(rods: Rigid, segments: Segments, s: int) -> real:
    """Push a segment and those close to it apart; returns the sum of what they are too close."""
    overlap = real(0.0)
    if is_finite(segments, s):
        lists, count = lists_around(segments, middle(segments, s))
        for k in range(count):
            t = int(lists[k])
            while t != NONE:
                if is_pair(rods, segments, s, t):
                    overlap += push_apart(rods, segments, s, t)
                t = int(segments.older[t])
    return overlap


@wp.kernel
def push_rods(rods: Rigid, segments: Segments, overlap: Scalars1D):
    """Push every rod that moved, and those close to it; ``dim = 1``.

    overlap[0]: the sum of what they are too close.
    """
    total = real(0.0)
    for rod in range(rods.moved.shape[0]):
        if rods.moved[rod] == 1:
            for s in range(segments.first[rods.first + rod], segments.first[rods.first + rod + 1]):
                total += push_from(rods, segments, s)
    overlap[0] = total


@wp.func
def move_rod(rods: Rigid, rod: int):
    """Move a rod by the mean of its pushes."""
    each = real(1.0) / real(rods.pushes[rod])
    position, turn = rods.position[rod] + each * rods.shift[rod], each * rods.turn[rod]
    if rods.flat == 1:
        turn = wp.vec3d(real(0.0), real(0.0), turn[2])
        position[2] = wp.clamp(position[2], rods.low, rods.high)
    rods.position[rod] = position
    rods.rotation[rod] = rotation_exp(turn) @ rods.rotation[rod]


@wp.func
def lay_rod(rods: Rigid, segments: Segments, rod: int):
    """Put the nodes of a rod where its position and rotation have them."""
    start = segments.begin[segments.first[rods.first + rod]]
    for i in range(rods.shape.shape[1]):
        segments.node[start + i] = rods.position[rod] + rods.rotation[rod] @ rods.shape[rod, i]


@wp.kernel
def move_rods(rods: Rigid, segments: Segments):
    """Move every rod by the mean of its pushes; ``dim = 1``."""
    for rod in range(rods.moved.shape[0]):
        rods.moved[rod] = wp.min(rods.pushes[rod], 1)
        if rods.pushes[rod] > 0:
            remove_rod(segments, rods.first + rod)
            move_rod(rods, rod)
            lay_rod(rods, segments, rod)
            insert_rod(segments, rods.first + rod)
            rods.shift[rod] = wp.vec3d()
            rods.turn[rod] = wp.vec3d()
            rods.pushes[rod] = 0
