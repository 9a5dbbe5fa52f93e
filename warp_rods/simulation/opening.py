"""How a run begins: afresh, in place of another one, or where one was left; and what describes it in its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.rods.variables import static_variable
from warp_rods.scene.scene import Scene
from warp_rods.simulation.begun import Begun
from warp_rods.simulation.checkpoint import State, read_checkpoint
from warp_rods.simulation.kept_surfaces import KeptSurfaces
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.output import chosen
from warp_rods.simulation.report import Report
from warp_rods.simulation.run_folder import RunFolder, starts_anew
from warp_rods.simulation.trajectory import GroupSpec

__all__ = ["opened", "where_to_begin"]


def where_to_begin(
    scene: Scene, folder: Path, resume: bool, overwrite: bool, report: Report
) -> tuple[Scene, bool, bool]:
    """The scene that is run, whether it continues the run in ``folder``, and whether it replaces what is there.

    Raises RunFolderError where neither is possible; nothing is changed.
    """
    if resume and starts_anew(folder, scene):
        report.note(f"nothing to continue from in {folder}: starting anew")
        resume, overwrite = False, True
    if not resume:
        RunFolder.check_free(folder, overwrite)
        return scene, resume, overwrite
    read_checkpoint(folder)
    continued = Begun.read(folder).continued(scene)
    if continued.time.save_every != scene.time.save_every:
        report.note(f"time.save_every = {continued.time.save_every:g}, as in the run so far")
    return continued, resume, overwrite


def opened(
    folder: Path, simulation: Simulation, resume: bool, overwrite: bool, expected: tuple[int, ...]
) -> tuple[RunFolder, State | None]:
    """The folder of a run to be written, and the state from which it is continued; ``expected`` as in ``create``."""
    attributes = _attributes(simulation)
    if resume:
        return RunFolder.resume(folder, simulation.scene, attributes, simulation.restore)
    surfaces = KeptSurfaces(simulation.scene, simulation.surfaces, simulation.starts)
    kept = RunFolder.create(
        folder, _groups(simulation), attributes, scene=simulation.scene, surfaces=surfaces, overwrite=overwrite,
        expected=expected,
    )  # fmt: skip
    return kept, None


def _groups(simulation: Simulation) -> dict[str, GroupSpec]:
    period, output = np.array(simulation.scene.period), simulation.scene.output
    space = {"period": np.where(period > 0, period, np.inf)}
    return {
        name: GroupSpec(
            e.count,
            e.nodes,
            chosen(output, e.saved),
            {k: (static_variable(k, v.ndim), v) for k, v in (e.static() | space).items()},
            output.frames_per_file if output else None,
            simulation.scene.units.scale.in_si if simulation.scene.units else str,
        )
        for name, e in simulation.ensembles.items()
    }


def _attributes(simulation: Simulation) -> dict[str, Any]:
    scene = simulation.scene
    return {
        "title": scene.title,
        "seed": scene.seed,
        "device": str(simulation.device),
        "step": "chosen by error" if simulation.by_error else simulation.step_size,
        "units": scene.units.said if scene.units else "dimensionless",
        "scene_hash": scene.hash(),
    }
