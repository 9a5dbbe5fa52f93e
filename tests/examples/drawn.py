"""A small trajectory to draw: rods on a ball that turn, and two cells beside it."""

import numpy as np

from warp_rods.rods.status import Status
from warp_rods.simulation.trajectory import (
    FILAMENT_VARIABLES,
    STORE,
    SWIMMER_VARIABLES,
    GroupSpec,
    TrajectoryWriter,
)

FRAMES = 6
SPHERE = 'kind = "sphere"\nradius = 1.0'
SCENE = """
title = "Rods on a ball"
{extra}
[[filaments]]
name = "sensors"
count = 4
nodes = 9
length = 0.6
stiffness = [1.0, 1.0, 1.0]
intrinsic = [0.0, 1.0, 0.0]
drag = [1.0, 2.0, 0.1]
[[swimmers]]
name = "cell"
count = 2
nodes = 17
bend = 5e-3
twist = 1e-3
[surface]
{surface}
[time]
end = 1.0
save_every = {save_every}
"""


def scene_text(extra: str = "", save_every: float = 0.1, surface: str = SPHERE) -> str:
    """The scene of the run in TOML; extra: more tables."""
    return SCENE.format(extra=extra, save_every=save_every, surface=surface)


def arcs(rods: int, nodes: int, length: float, turn: float) -> np.ndarray:
    """Meridian arcs on the unit sphere, rotated about the axis by ``turn`` [rods, nodes, 3]."""
    along = np.linspace(-0.5, 0.5, nodes) * length
    azimuth = 2 * np.pi * np.arange(rods)[:, None] / rods + turn
    x, y, z = np.cos(azimuth) * np.cos(along), np.sin(azimuth) * np.cos(along), np.sin(along) + 0 * azimuth
    return np.stack([x, y, z], axis=-1)


def freeze(saved: dict[str, np.ndarray], before: dict[str, np.ndarray], rod: int) -> None:
    """Let a rod be lost, as the program saves it: all its variables are those of the frame before, but the status."""
    for name, values in saved.items():
        values[rod] = Status.TOO_BENT if name == "status" else before[name][rod]


def write_run(
    folder,
    extra: str = "",
    fail_at: int | None = None,
    frames: int = FRAMES,
    step: float = 0.1,
    save_every: float = 0.1,
    surface: str = SPHERE,
) -> None:
    """Write frames a ``step`` apart; rod 1 of "sensors" is lost at frame ``fail_at``. extra: tables of the scene."""
    groups = {"sensors": GroupSpec(4, 9, FILAMENT_VARIABLES), "cell": GroupSpec(2, 17, SWIMMER_VARIABLES)}
    attributes = {
        "title": "Rods on a ball",
        "scene": scene_text(extra, save_every, surface),
        "scene_hash": "abc",
    }
    writer = TrajectoryWriter.create(folder / STORE, groups, attributes)
    rng = np.random.default_rng(3)
    before: dict = {}
    for number in range(frames):
        saved = {}
        for group, spec in groups.items():
            saved[group] = {name: np.zeros(spec.shape(v)) for name, v in spec.variables.items()}
            saved[group]["energy_density"] = rng.gamma(2.0, size=(spec.rods, spec.nodes))
        saved["sensors"]["length"][:] = 0.6
        saved["sensors"]["position"] = arcs(4, 9, 0.6, 0.1 * number)
        saved["cell"]["position"] = arcs(2, 17, 1.0, 0.2 * number) + np.array([3.0, 0.0, 0.1 * number])
        if fail_at is not None and number >= fail_at:
            freeze(saved["sensors"], before["sensors"], 1)
        writer.append(step * number, saved)
        before = saved
    writer.close()
