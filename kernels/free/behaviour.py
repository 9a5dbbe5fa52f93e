"""Behaviours: events at random times that change what flagella do to a rod (docs/model.md §2.13).

A behaviour is a function of the number of its events so far: how long until the next one, and meanwhile by what it
multiplies the target of the flagella of either half, and how fast they turn the rod. To add one, add a number, a
function and a branch of ``after`` here, and a row with its parameters to the table in
``warp_rods/scene/behaviour.py``.
"""

import warp as wp

from warp_rods.kernels.free.state import Contact, Swimmers, Trial
from warp_rods.kernels.lanes import WIDTH, Pair, rods_in
from warp_rods.kernels.layout import Integers1D, Integers2D, Scalars1D, Scalars2D, real
from warp_rods.kernels.multistep import INFINITE, Pace
from warp_rods.kernels.philox import Words, philox, uniform, uniform_of_two
from warp_rods.kernels.status import OK

wp.set_module_options({"enable_backward": False})

REVERSAL, TUMBLE = wp.constant(0), wp.constant(1)
SECOND = wp.constant(65536)
"""Added to the number of a behaviour in the counter of the second four words of an event."""
FRONT, BACK = wp.constant(0), wp.constant(1)
"""The parameters of the law that are multiplied."""
REACHED = wp.constant(real(1.0e-14))
"""A time is that of an event if it is nearer than this, relative: steps taken together end there up to round-off."""
FIRST_STEP = wp.constant(real(1.0e-6))
"""The first step after an event, of rods in steps of their own."""

FULL_TURN = wp.constant(real(6.283185307179586))

Numbers = wp.types.vector(length=4, dtype=real)
Draws = wp.types.vector(length=5, dtype=real)
"""Random numbers in (0, 1) of an event; the first has 52 bits."""
NumbersOfRods = wp.array2d(dtype=Numbers)


@wp.struct
class Behaviours:
    """The behaviours of rods, and the events that each rod has had [rod, behaviour]."""

    kind: Integers1D  # numbers as above [behaviour]
    parameters: NumbersOfRods
    time: Scalars2D  # of the next event
    count: Integers2D  # of events so far
    target: NumbersOfRods  # the parameters of the law, as they were given [rod, 0]
    drag: Scalars1D  # ∫ ζ⊥ s² ds about the centre of drag [rod]: the couple that turns a stiff rod at the rate 1
    couple: wp.array(dtype=Pair)  # per length across the rod, in its Bishop frame [tile]; empty if nothing turns it
    stream: wp.array(dtype=wp.uint64)  # the random numbers of a rod are those of this stream [rod],
    seed: wp.array(dtype=wp.uint64)  # with this seed [rod]


@wp.struct
class Phase:
    """What holds from an event to the next: how long it lasts, the factors of the target, and the turning."""

    duration: real
    front: real  # of the second half, s > 0
    back: real
    spin: wp.vec2d  # angular velocity of a stiff rod across its tangent


@wp.func
def waiting_time(random: real, rate: real) -> real:
    """Exponentially distributed with this rate."""
    return -wp.log(random) / rate


@wp.func
def reversal(count: int, random: Draws, p: Numbers):
    """The flagella reverse at the rate p[0]."""
    phase = Phase()
    phase.duration = waiting_time(random[0], p[0])
    phase.front = real(1.0) - real(2.0) * real(count % 2)
    phase.back = phase.front
    return phase


@wp.func
def tumble(count: int, random: Draws, p: Numbers):
    """Runs end at the rate p[0]; then for the time p[1] each half has any part of its force, either way, and turns.

    A stiff rod turns about a random axis across, by an angle of root mean square p[2].
    """
    phase = Phase()
    phase.duration = waiting_time(random[0], p[0])
    phase.front = real(1.0)
    phase.back = real(1.0)
    if count % 2 == 1:
        phase.duration = p[1]
        phase.front = real(2.0) * random[1] - real(1.0)
        phase.back = real(2.0) * random[2] - real(1.0)
        speed = p[2] * wp.sqrt(-wp.log(random[3])) / p[1]
        axis = FULL_TURN * random[4]
        phase.spin = speed * wp.vec2d(wp.cos(axis), wp.sin(axis))
    return phase


@wp.func
def after(kind: int, count: int, random: Draws, p: Numbers):
    """The phase of a behaviour that follows its events so far."""
    if kind == TUMBLE:
        return tumble(count, random, p)
    return reversal(count, random, p)


@wp.func
def phase_of(rod: int, column: int, b: Behaviours):
    """The present phase of a behaviour of a rod: a function of seed, stream, behaviour and number of the event."""
    stream, seed, kind, count = b.stream[rod], b.seed[rod], b.kind[column], b.count[rod, column]
    lower, upper = wp.uint32(stream), wp.uint32(stream >> wp.uint64(32))
    word = philox(Words(wp.uint32(count), wp.uint32(kind), lower, upper), seed)
    more = philox(Words(wp.uint32(count), wp.uint32(kind + SECOND), lower, upper), seed)
    wait = uniform_of_two(word[0], word[1])
    random = Draws(wait, uniform(word[2]), uniform(word[3]), uniform(more[0]), uniform(more[1]))
    return after(kind, count, random, b.parameters[rod, column])


@wp.func
def pass_events(rod: int, now: real, b: Behaviours):
    """Let all events of a rod up to a time happen."""
    for column in range(b.kind.shape[0]):
        while b.time[rod, column] <= now:
            b.count[rod, column] = b.count[rod, column] + 1
            phase = phase_of(rod, column, b)
            b.time[rod, column] = b.time[rod, column] + phase.duration


@wp.func
def set_target(tile: int, lane: int, rods: Swimmers, trial: Trial, b: Behaviours):
    """Target and couple of a rod by the phases of its behaviours; no step goes beyond the next event."""
    rod = tile * WIDTH + lane
    front, back, limit, spin = real(1.0), real(1.0), real(1.0) * INFINITE, wp.vec2d()
    for column in range(b.kind.shape[0]):
        phase = phase_of(rod, column, b)
        front *= phase.front
        back *= phase.back
        spin += phase.spin
        limit = wp.min(limit, b.time[rod, column])
    law, given = rods.law_parameters[tile], b.target[rod, 0]
    law[FRONT, lane] = front * given[FRONT]
    law[BACK, lane] = back * given[BACK]
    rods.law_parameters[tile] = law
    trial.limit[rod] = limit
    if b.couple.shape[0] > 0:
        couple = b.couple[tile]
        couple[0, lane] = b.drag[rod] * spin[0]
        couple[1, lane] = b.drag[rod] * spin[1]
        b.couple[tile] = couple


@wp.func
def begin_anew(tile: int, lane: int, pace: Pace, contact: Contact):
    """Let a rod begin anew from its present shape: its past does not foretell what follows."""
    rod = tile * WIDTH + lane
    pace.levels[rod] = 1
    pace.order[rod] = 1
    pace.waited[rod] = 0
    pace.step[rod] = FIRST_STEP
    if contact.present == 1:
        for node in range(contact.velocity.shape[1]):
            v, lag = contact.velocity[tile, node], contact.lag[tile, node]
            for k in range(3):
                v[k, lane] = real(0.0)
                lag[k, lane] = real(0.0)
            contact.velocity[tile, node] = v
            contact.lag[tile, node] = lag


@wp.kernel
def start(b: Behaviours):
    """The times of the first events, from time 0 on; ``dim = (rods, behaviours)``."""
    rod, column = wp.tid()
    phase = phase_of(rod, column, b)
    b.time[rod, column] = phase.duration


@wp.kernel
def set_targets(rods: Swimmers, trial: Trial, b: Behaviours):
    """Targets and limits of steps from the events so far; ``dim = tiles``."""
    tile = wp.tid()
    for lane in range(rods_in(tile, trial.limit.shape[0])):
        set_target(tile, lane, rods, trial, b)


@wp.kernel
def meet_events(rods: Swimmers, pace: Pace, contact: Contact, trial: Trial, before: real, b: Behaviours):
    """Events of rods that have come to one, if it is before a time; ``dim = tiles``."""
    tile = wp.tid()
    for lane in range(rods_in(tile, trial.limit.shape[0])):
        rod = tile * WIDTH + lane
        now = pace.at[rod, 0] * (real(1.0) + REACHED)
        if rods.status[rod] == OK and trial.limit[rod] <= now and trial.limit[rod] < before:
            pass_events(rod, now, b)
            set_target(tile, lane, rods, trial, b)
            begin_anew(tile, lane, pace, contact)
