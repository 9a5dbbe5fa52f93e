"""How long a run takes on this machine, from the time that its first steps take."""

from __future__ import annotations

import time

import numpy as np

from warp_rods.progress import in_words
from warp_rods.rods.together import exhaust
from warp_rods.simulation.estimates import (
    disk_bytes,
    frames_of,
    memory,
    shown_bytes,
    trajectory_bytes,
)
from warp_rods.simulation.loop import Simulation

BUDGET = 0.4
"""Seconds after which no more steps are tried."""
FIRST_SPAN = 100
"""The first time over which rods take steps of their own, in units of their first step; each further one is twice as
long."""
FASTER = 0.9
"""Steps of a given length have become faster where they take less than this part of the time of those before."""
SETTLED = {"filaments": 10.0, "swimmers": 0.2, "cosserat": 0.2}
"""Steps by error become about so many natural times long, by the kind of rods: in the shipped scenes within a factor of
five or so."""
ARRAYS, BYTES_PER_SECOND, SECONDS_OF_AN_ARRAY = 25, 3e8, 2e-4
"""Of writing a frame: arrays of an ensemble, and how fast they are written; about."""
STEPS_OF_EVENT = 50
"""Steps by error that an event of a behaviour costs, after which they begin short; measured, 40 to 60."""
EVENTS = {"reversal": 1, "tumble": 2}
"""Events for each time that a behaviour occurs: a tumble begins and ends."""


def estimated_seconds(simulation: Simulation, budget: float = BUDGET) -> tuple[float, str]:
    """Seconds until the end of a run whose kernels are loaded, and what they are based on. The state does not change.

    A few steps are tried. Steps by error change their length by orders of magnitude: those still to come are taken to
    be as long as they usually become.
    """
    with simulation.trial():
        begun = time.perf_counter()
        simulation.variables()
        of_a_frame = time.perf_counter() - begun + _writing(simulation)
        frames = simulation.frames.last - simulation.frame
        steps, basis = (_equal if not simulation.by_error else _own if simulation.own_steps else _together)(
            simulation, budget
        )
    return frames * of_a_frame + steps, basis


def _writing(simulation: Simulation) -> float:
    of_a_frame = trajectory_bytes(simulation.scene) / frames_of(simulation.scene)
    return len(simulation.ensembles) * ARRAYS * SECONDS_OF_AN_ARRAY + of_a_frame / BYTES_PER_SECOND


def _equal(simulation: Simulation, budget: float) -> tuple[float, str]:
    """Of steps of a given length. The first ones may be divided: more are tried as long as they still become faster."""
    left = simulation.frames.steps_to(simulation.frames.last) - simulation.steps_taken
    begun, done, number, each, faster = time.perf_counter(), 0, 1, 0.0, False
    while done < left and time.perf_counter() - begun < (budget if faster else budget / 3):
        number = min(number, left - done)
        before, last = time.perf_counter(), each
        exhaust(simulation.together.advance(simulation.step_size, number))
        done, each = done + number, (time.perf_counter() - before) / number
        number, faster = 2 * number, each < FASTER * last
    return time.perf_counter() - begun + (left - done) * each, f"by the first {done} steps"


def _own(simulation: Simulation, budget: float) -> tuple[float, str]:
    """Of steps that each rod takes by its error; where they became no longer, as many a time as in the last span."""
    begun, end, before, rate = time.perf_counter(), simulation.scene.time.end, simulation.rod_steps, 0.0
    span = FIRST_SPAN * min(e.first_step for e in simulation.ensembles.values())
    while simulation.now < end and time.perf_counter() - begun < budget / 3:
        started, since = time.perf_counter(), simulation.now
        exhaust(simulation._advance_to(min(since + span, end)))
        if simulation.now > since:
            rate = (time.perf_counter() - started) / (simulation.now - since)
        span *= 2
    spent, tried, left = time.perf_counter() - begun, simulation.rod_steps - before, end - simulation.now
    if left <= 0:
        return spent, ""
    longest = _settled_step(simulation)
    rest = min(left * rate, left / longest * simulation.rods * spent / max(tried, 1))
    return spent + rest, f"if steps become about {longest:.2g} long, as usual"


def _together(simulation: Simulation, budget: float) -> tuple[float, str]:
    """Of steps by error that all rods take together."""
    begun, end, control = time.perf_counter(), simulation.scene.time.end, simulation.together.control
    before = control.taken + control.rejected
    for _ in simulation._advance_to(end):
        if time.perf_counter() - begun > budget:
            break
    spent, tried, left = time.perf_counter() - begun, control.taken + control.rejected - before, end - simulation.now
    if left <= 0 or not tried:
        return spent, ""
    longest = _settled_step(simulation, control.step)
    return spent + left / longest * spent / tried, f"if steps become about {longest:.2g} long, as usual"


def _settled_step(simulation: Simulation, reached: float = 0.0) -> float:
    """The length that steps by error usually reach: they begin shorter by orders of magnitude.

    Not less than what they have ``reached`` already, as where the rods that could change soonest are at rest.
    """
    tables = ((kind, table) for kind in SETTLED for table in getattr(simulation.scene, kind))
    usual = min(SETTLED[kind] * simulation.ensembles[table.name].natural_time for kind, table in tables)
    settled = min(max(usual, reached), simulation.together.longest)
    return 1 / (1 / settled + STEPS_OF_EVENT * _events(simulation))


def _events(simulation: Simulation) -> float:
    """Events of behaviours in a unit of time: of a rod, or of all where they take their steps together."""
    found = 0.0
    for table in simulation.scene.swimmers:
        for name, values in (table.behaviour.behaviours if table.behaviour else {}).items():
            each = EVENTS[name] * np.broadcast_to(np.asarray(values["rate"], dtype=float), table.count)
            found += float(each.sum())
    return found / simulation.rods if simulation.own_steps else found


def lines(simulation: Simulation) -> list[str]:
    """What a run needs, its rest where it is continued, and the times on which rods change beside those of the run."""
    scene = simulation.scene
    seconds, basis = estimated_seconds(simulation)
    needed = memory(scene) + sum(s.grid.nbytes for s in simulation.surfaces.values() if s and s.grid is not None)
    long = f"{in_words(max(seconds, 1.0))}{' more' if simulation.now > 0 else ''} on this machine"
    size = (
        f"about {shown_bytes(disk_bytes(scene))} on disk in {frames_of(scene)} frames, {shown_bytes(needed)} of "
        f"memory, {long}{f' ({basis})' if basis else ''}"
    )
    times = [f"{name} {e.natural_time:.2g}" for name, e in simulation.ensembles.items()]
    steps = "" if simulation.by_error else f"Δt = {simulation.step_size:.3g}, "
    of_run = f"{steps}frames {scene.time.save_every:.3g} apart, end {scene.time.end:.3g}"
    return [f"shortest time in which a rod relaxes: {', '.join(times)}; {of_run}", size]
