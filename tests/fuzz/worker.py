"""Runs cases one after the other in a process of limited memory and time; the parent reads a line about each.

``python -m fuzz.worker KIND FIRST LAST FOLDER``: prints ``{"number": n}`` before a case, and its outcome after it.
"""

from __future__ import annotations

import faulthandler
import json
import re
import resource
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fuzz import files, formulas, lines, scenes

SECONDS = 10.0
"""Allowed for a case."""
COMPILING = 120.0
"""Allowed for each module of kernels that no test has compiled before on this machine."""
BYTES = 10**9
"""Allowed for a case."""
GRID = 3e5
"""Nodes of the grid of a membrane: with the 2e7 that users may have, a sound mesh takes a minute and two gigabytes."""
LARGE = 20_000
"""Nodes above which no steps are taken."""
KEYS = r"\b(title|seed|surface|filaments|swimmers|box|steric|time|units|output|sweep|scene)\b|TOML"
"""What a message must name, if not a file."""

MAKE: dict[str, Callable[[int, Path], str]] = {
    "scene": lambda number, folder: scenes.text(number),
    "formula": lambda number, folder: formulas.text(number),
    "mesh": files.mesh,
    "stack": files.stack,
    "line": lines.line,
}


def run(text: str, folder: Path, steps: bool) -> str:
    """Lay out the scene and take a few steps; returns the outcome, or raises what is not an answer to a user."""
    from warp_rods.errors import RodFailure, WarpRodsError
    from warp_rods.scene.scene import Scene

    try:
        scene = Scene.parse(text, folder)
        if steps:
            _few_steps(scene)
        else:
            _field(scene)
    except RodFailure:
        return "rods failed"
    except WarpRodsError as error:
        if error.exit_code != 2:
            raise AssertionError(f"exit code {error.exit_code}") from error
        if not re.search(KEYS, str(error)):
            raise AssertionError("the message names no key") from error
        return "refused"
    return "ran"


def _few_steps(scene: Any) -> None:
    from warp_rods.rods.together import exhaust
    from warp_rods.simulation.loop import Simulation
    from warp_rods.studies.plan import Plan

    if scene.sweep is not None:
        Plan(scene).check()
    simulation = Simulation(scene, "cpu")
    if sum(e.count * e.nodes for e in simulation.ensembles.values()) > LARGE:
        return
    if not simulation.by_error:
        exhaust(simulation.together.advance(simulation.step_size, 1))
    elif simulation.own_steps:
        first = min(e.first_step for e in simulation.ensembles.values())
        exhaust(simulation._advance_to(min(scene.time.end, 100 * first)))
    else:
        for _, _ in zip(range(3), simulation._advance_to(scene.time.end), strict=False):
            pass
    simulation.variables()
    simulation.new_failures()


def _field(scene: Any) -> None:
    """Differentiate the formula of the surface and write its kernel, which is not compiled."""
    from warp_rods.formula import FormulaError
    from warp_rods.membranes.catalogue import KINDS
    from warp_rods.membranes.surfaces import SceneError, Surface

    try:
        Surface(scene.surface.kind, scene.surface.parameters, KINDS[scene.surface.kind])
    except FormulaError as error:  # ``surfaces.make`` puts the key in front
        raise SceneError(f"surface.phi: {error}") from None


def timed_apart(compiled: Callable[..., Any]) -> Callable[..., Any]:
    """The compiler with a limit of its own: the first case on a new machine compiles what later ones find."""

    def compiling(*arguments: Any, **options: Any) -> Any:
        left, _ = signal.setitimer(signal.ITIMER_PROF, COMPILING)
        try:
            return compiled(*arguments, **options)
        finally:
            signal.setitimer(signal.ITIMER_PROF, max(left, 0.1))

    return compiling


def main(kind: str, first: int, last: int, folder: Path, every: int) -> None:
    """Each ``every``-th formula is compiled."""
    faulthandler.enable()
    faulthandler.register(signal.SIGPROF, chain=True)  # says where, and ends the process
    warnings.simplefilter("error", RuntimeWarning)
    from warp._src.context import Module

    from warp_rods.device import start
    from warp_rods.membranes import fit
    from warp_rods.simulation import estimates, layout, loop  # noqa: F401 (imported before memory is limited)

    start()
    if not every:
        Module._compile = timed_apart(Module._compile)
    estimates.memory_of_machine = lambda: estimates.PROCESS + BYTES
    fit.MOST_NODES = GRID
    for number in range(first, last):
        print(json.dumps({"number": number}), flush=True)
        text = MAKE[kind](number, folder)
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + BYTES + 2 * 10**8, resource.RLIM_INFINITY))
        signal.setitimer(signal.ITIMER_PROF, SECONDS * (3 if every else 1))  # of processor time: cores are shared
        begun, what = time.process_time(), ""
        try:
            outcome = run(text, folder, kind != "formula" or (every > 0 and number % every == 0))
        except Exception:
            outcome, what = "crashed", traceback.format_exc()
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        seconds = time.process_time() - begun
        print(json.dumps({"outcome": outcome, "seconds": seconds, "what": what}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]), int(sys.argv[5]))
