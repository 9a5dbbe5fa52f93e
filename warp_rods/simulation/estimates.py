"""What a scene needs of memory and disk, before any of it is taken: told, warned of, or refused with what would fit.

Bytes of memory were measured (tests/simulation/test_estimates.py holds them to what is allocated); bytes of a
trajectory follow from its variables.
"""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.kernels.contact.cutoff import CUTOFF
from warp_rods.scene.ensemble import AUTO
from warp_rods.scene.scene import Scene
from warp_rods.simulation.files import nearest_existing


class Footprint(NamedTuple):
    """Bytes of an ensemble for each node, and for each rod besides."""

    arrays: int
    """Arrays of a node on the CPU."""
    on_gpu: int
    """The same on CUDA, where rods do not share their workspace."""
    contact: int
    """More of them with steric forces."""
    host: int
    """Copies for frames and checkpoints, and what the start needs; with contact twice as much."""
    rod: int


FOOTPRINTS = {
    "swimmers": Footprint(960, 1550, 600, 450, 2500),
    "filaments": Footprint(410, 530, 470, 240, 3000),
    "cosserat": Footprint(1310, 1620, 370, 320, 3500),
}
"""By the kind of rods."""
PROCESS = 400e6
"""Bytes of the program itself."""
PLACES, BYTES_OF_A_PAIR = 32, 8
"""Neighbours of a node for which there is always room, and bytes of each one more."""
OUTPUT_OF_A_NODE = 40
"""Bytes of a node in a frame of the animation; about."""
WHOLE_ANIMATION, MEMORY_OF_ANIMATION = 0.5e9, 1.25
"""Bytes above which an animation is made in parts, and bytes of memory for each byte of one that is made as a whole."""
HALF = 0.5
"""The part of the free space above which a run warns."""


def memory_of_machine() -> float:
    """Bytes that this process may use: of the machine, and of its container; infinite where neither is known."""
    found = [np.inf]
    with contextlib.suppress(AttributeError, ValueError, OSError):
        found.append(float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))
    for path in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            found.append(float(Path(path).read_text()))
        except (OSError, ValueError):  # absent, or the word "max"
            continue
    return min(found)


# --- memory -----------------------------------------------------------------------------------------------------------


class Need(NamedTuple):
    """What a table of a scene needs."""

    key: str
    table: Any
    nodes: int
    rod: float
    """Bytes of memory of the host for each rod."""
    rod_on_device: float
    """Bytes on a CUDA device for each rod."""
    near: float
    """Neighbours of a node along its own rod within the reach of the steric force."""


def needs(scene: Scene) -> Iterator[Need]:
    """What each table needs; nodes that are still to be chosen count as few."""
    for kind, footprint in FOOTPRINTS.items():
        for index, table in enumerate(getattr(scene, kind)):
            nodes, near, steric = nodes_at_end(table), 0.0, scene.steric
            device, host = footprint.on_gpu, footprint.host
            arrays = footprint.arrays
            if steric is not None and steric.strength > 0:
                reach = 2 * (CUTOFF * steric.range + steric.core)
                near = min(nodes, reach * (nodes - 1) / float(np.max(getattr(table, "length", None) or 1.0)))
                more = footprint.contact + BYTES_OF_A_PAIR * max(near - PLACES, 0.0)
                arrays, device, host = arrays + more, device + more, 2 * host
            rod = nodes * (arrays + host) + footprint.rod
            yield Need(f"{kind}[{index}]", table, nodes, rod, nodes * device + footprint.rod, near)


def nodes_at_end(table: Any) -> int:
    """The number of nodes of each rod once it is grown; the fewest where it is still to be chosen."""
    nodes = type(table).FEWEST_NODES if table.nodes == AUTO else table.nodes
    growth = getattr(table, "growth", None)
    if growth is None or growth.spacing is None:
        return nodes
    longest = max(float(np.max(v)) for v in (table.length, growth.until, growth.length) if v is not None)
    while longest / (nodes - 1) > growth.spacing:
        nodes = 2 * nodes - 1
    return nodes


def memory(scene: Scene) -> float:
    """Bytes of memory that a run on the CPU needs, membranes from files left out."""
    return PROCESS + sum(need.table.count * need.rod for need in needs(scene)) + memory_of_animation(scene)


def memory_of_animation(scene: Scene) -> float:
    """Bytes of memory that the animation at the end of a run takes besides, at most; a part takes less than a whole."""
    return MEMORY_OF_ANIMATION * min(animation_bytes(scene), WHOLE_ANIMATION)


def check_memory(scene: Scene, device: Any = None) -> None:
    """Raises SceneError naming the largest table of a scene that needs too much memory, and how many rods would fit.

    device: where the rods will be; the memory of a CUDA device is checked besides that of the machine.
    """
    _check(list(needs(scene)), "rod", PROCESS + memory_of_animation(scene), memory_of_machine(), "this machine")
    if device is None:
        return
    from warp_rods.device import device as device_of  # imports Warp

    if (device := device_of(device)).is_cuda:
        _check(list(needs(scene)), "rod_on_device", 0.0, float(device.free_memory), f"{device.alias} (free)")


def _check(tables: list[Need], of: str, start: float, available: float, where: str) -> None:
    sizes = [need.table.count * getattr(need, of) for need in tables]
    if start + sum(sizes) <= available or not sizes:
        return
    largest = int(np.argmax(sizes))
    need, left = tables[largest], available - start - (sum(sizes) - max(sizes))
    each = f"nodes = {need.nodes}" if need.table.nodes != AUTO else "nodes = auto"
    crowded = f", with {need.near:.3g} neighbours of each node on its own rod within the reach of the steric force,"
    most = int(float(f"{max(left, 0) / getattr(need, of):.2g}"))
    fits = f"at most about {shown_count(most)} rods of {need.nodes} nodes fit here" if most else "not one fits here"
    raise SceneError(
        f"{need.key}.count = {need.table.count}, {each}{crowded if need.near > PLACES else ''} need about "
        f"{shown_bytes(max(sizes))} of memory, and {where} has {shown_bytes(available)}: {fits}; use fewer rods or "
        f"nodes, or divide the scene"
    )


# --- disk -------------------------------------------------------------------------------------------------------------


def frames_of(scene: Scene) -> int:
    """The number of frames of a run."""
    from warp_rods.simulation.frames import Frames

    return len(Frames.plan(scene.time.end, scene.time.save_every, scene.time.step or scene.time.save_every).times)


def trajectory_bytes(scene: Scene) -> float:
    """Bytes of the trajectory of a whole run, without the few kilobytes of its metadata."""
    from warp_rods.rods.variables import (
        COSSERAT_VARIABLES,
        FILAMENT_VARIABLES,
        STATIC,
        SWIMMER_VARIABLES,
        variables_of_behaviours,
    )
    from warp_rods.simulation.output import chosen
    from warp_rods.simulation.store import GroupSpec, stored_bytes

    frames, output = frames_of(scene), scene.output
    total = 0
    of_kind = {"filaments": FILAMENT_VARIABLES, "swimmers": SWIMMER_VARIABLES, "cosserat": COSSERAT_VARIABLES}
    for kind, variables in of_kind.items():
        for table in getattr(scene, kind):
            nodes = type(table).FEWEST_NODES if table.nodes == AUTO else table.nodes
            most = output.frames_per_file if output else None
            random = getattr(table, "behaviour", None)
            events = variables_of_behaviours(random.behaviours if random else ())
            spec = GroupSpec(table.count, nodes, chosen(output, variables | events), {}, most)
            total += stored_bytes(spec, frames) + 8 * table.count * len(STATIC)
    return total


def disk_bytes(scene: Scene) -> float:
    """Bytes on disk of a run: trajectory, checkpoint and animation."""
    found = trajectory_bytes(scene) + animation_bytes(scene)
    for need in needs(scene):
        found += need.table.count * need.nodes * FOOTPRINTS[need.key.partition("[")[0]].host
    return found


def animation_bytes(scene: Scene) -> float:
    """Bytes of the animation, about; 0 where none is made."""
    if scene.output is not None and not scene.output.usd:
        return 0.0
    nodes = sum(need.table.count * need.nodes for need in needs(scene))
    return float(nodes * OUTPUT_OF_A_NODE * frames_of(scene))


def check_disk(scene: Scene, folder: Path, there: float = 0.0) -> list[str]:
    """Warnings where a run fills more than half of the space that is free where its ``folder`` is.

    there: bytes of a run in the folder that is continued, or replaced, so that they are not needed again. Raises
    SceneError where it does not fit.
    """
    free = shutil.disk_usage(nearest_existing(folder)).free
    needed, frames = disk_bytes(scene) - there, frames_of(scene)
    said = f"{frames} frames need about {shown_bytes(needed)} in {folder}, where {shown_bytes(free)} are free"
    if needed > free:
        most = int(frames * free / needed)
        fits = f"about {most} frames fit, time.save_every = {scene.time.end / most:.3g}" if most > 1 else "none fits"
        raise SceneError(
            f"time.save_every = {scene.time.save_every:g}: {said}: {fits}; save less often, fewer variables "
            f"(output.variables), or in another folder"
        )
    return [f"{said}: save less often, or fewer variables (output.variables)"] if needed > HALF * free else []


# --- words ------------------------------------------------------------------------------------------------------------


def shown_bytes(size: float) -> str:
    """A number of bytes such as 29 GB, with two digits."""
    for unit, one in (("PB", 1e15), ("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if size >= 0.995 * one:
            return f"{float(f'{size / one:.2g}'):,g} {unit}"
    return f"{max(round(size / 1e3), 1)} kB"


def shown_count(count: float) -> str:
    """A number with spaces between thousands."""
    return f"{count:,}".replace(",", " ")
