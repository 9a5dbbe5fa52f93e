"""What ``warp-rods check SCENE`` says: what a run of a scene would be, without running it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from warp_rods.progress import waiting
from warp_rods.scene.scene import Scene
from warp_rods.simulation.estimates import check_disk, check_memory
from warp_rods.simulation.files import default_folder


def check_scene(path: str | Path, about: Sequence[str] = (), warned: Sequence[str] = ()) -> str:
    """Rods, notes, warnings and estimates of the scene in a file; raises SceneError for one that cannot run.

    about, warned: what else is to be said of it, as of the study of which it is the first scene, and further warnings.
    Rods are placed, and a few steps are tried to tell how long a run takes; what needs too much memory or disk is
    refused before.
    """
    scene, folder = Scene.load(path), default_folder(path)
    check_memory(scene)
    check_disk(scene, folder)
    from warp_rods.simulation import timing
    from warp_rods.simulation.loop import Simulation

    with waiting("placing rods"):
        simulation = Simulation(scene, "cpu")
    warnings = [*simulation.warnings, *check_disk(simulation.scene, folder), *warned]
    with waiting("compiling kernels (once on a machine, then cached), and trying a few steps"):
        simulation.warm_up()
        estimates = timing.lines(simulation)
    rods = [
        f"{name}: {e.count} rod{'s' if e.count > 1 else ''} of {e.nodes} nodes"
        for name, e in simulation.ensembles.items()
    ]
    count = len(warnings)
    result = f"{count} warning{'s' if count > 1 else ''}" if count else "no problems found"
    said = [f"warning: {line}" for line in warnings]
    return "\n".join([*rods, *simulation.notes, *estimates, *about, *said, f"{simulation.pace}: {result}"])
