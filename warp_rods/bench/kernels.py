"""Kernels and whole steps in ns a node, beside the bandwidth of the memory, LAPACK and Numba in the same run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from scipy.linalg import solve_banded
from scipy.spatial.transform import Rotation

from warp_rods.bench import crowd, rods
from warp_rods.bench.peers import loops, planar_steps
from warp_rods.bench.peers.optional import missing
from warp_rods.bench.result import Cell, Section, Settings, Table
from warp_rods.bench.swimmer_problem import FULL as FULL_SWIMMER
from warp_rods.bench.swimmer_problem import Problem
from warp_rods.bench.timing import Work, bytes_per_second, copy, in_turns
from warp_rods.kernels import banded, lie
from warp_rods.kernels.lanes import Lanes, Pair
from warp_rods.kernels.layout import per_node, per_rod, real
from warp_rods.rods.tiles import tiled

NODES = 65
DIAGONALS = {3: "tridiagonal", 5: "pentadiagonal"}
BYTES_OF_SOLVE = {3: 40, 5: 56}
"""Bytes a node that a solve must move: coefficients, right-hand side and solution once each."""
BYTES_OF_FRAMES = 24 + 96
"""A strain, a position and a rotation."""


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    batches: Sequence[int] = (1, 100, 1000, 10_000)
    rod_batches: Sequence[int] = (1, 100, 1000)
    bound_batches: Sequence[int] = (1, 100)
    scipy: int = 1000
    numbers: int = 2**24
    crowd: int = 200
    membranes: Sequence[str] = tuple(rods.BOUND)
    repeats: int = 5


FULL = Size()
QUICK = Size((2,), (2,), (2,), 2, 1000, 30, ("dumbbell",), 1)


def run(settings: Settings) -> Section:
    """Solves, path products, pairs, steps."""
    size = QUICK if settings.quick else FULL
    tables = [solves(size, 5, settings), solves(size, 3, settings), products(size, settings)]
    tables += [pairs(size, settings), steps(size, settings, "free"), steps(size, settings, "bound")]
    return Section(tables, {}, [*NOTES, *filter(None, [missing("numba")])])


NOTES = (
    f"ns a node of one core, N = {NODES} (bound rods 33). Copy bound: the least time in which the memory moves what "
    "the work must read and write, at the bandwidth of numpy.copyto of 128 MB measured in turns with it; what fits "
    "into a cache can be quicker.",
    "LAPACK: scipy.linalg.solve_banded for each rod, and for all rods as one long banded matrix. Numba: plain loops.",
    "Steps: own: of each rod by its error; together: equal steps of order 2. Time over all steps taken and repeated.",
    "Contact: sensors as in proteins.toml, at random. Pairs within reach, each counted once. Forces and stiffness: all "
    "that contact does in a step whose lists hold. Numba: the force alone, over a list of exactly these pairs that was "
    "made before; cKDTree: making it.",
)


# --- banded solves ----------------------------------------------------------------------------------------------------


def coefficients(bands: int, count: int) -> np.ndarray:
    """Diagonally dominant coefficients [band, rod, node], lowest diagonal first."""
    values = np.random.default_rng(0).normal(size=(bands, count, NODES))
    values[bands // 2] += 8.0
    return values


def our_solve(bands: int, count: int, pairs: bool) -> Work:
    """A recorded launch, as in a step."""
    dtype = wp.vec2d if pairs else real
    rows = [per_node(count, NODES) for _ in range(bands)]
    for row, values in zip(rows, coefficients(bands, count), strict=True):
        row.assign(values)
    right, solution = per_node(count, NODES, dtype), per_node(count, NODES, dtype)
    right.fill_(dtype(1.0))
    work = per_node(count, NODES, real if bands == 3 else wp.vec2d)
    kernel = banded.solve_tridiagonal if bands == 3 else banded.solve_pentadiagonal
    return recorded(banded, kernel, count, [*rows, right, work, solution])


def our_solve_in_tiles(bands: int, count: int, pairs: bool) -> Work:
    """The same in the lanes of vector instructions, as rods are stepped."""
    rows = [tiled(values) for values in coefficients(bands, count)]
    dtype = Pair if pairs else Lanes
    shape = (count, NODES, 2) if pairs else (count, NODES)
    right, solution = tiled(np.ones(shape), dtype), tiled(np.zeros(shape), dtype)
    work = tiled(np.zeros((count, NODES) if bands == 3 else (count, NODES, 2)), Lanes if bands == 3 else Pair)
    kernel = banded.solve_tridiagonal if bands == 3 else banded.solve_pentadiagonal
    return recorded(banded, kernel, len(right), [*rows, right, work, solution])


def recorded(module: Any, kernel: Any, count: int, inputs: list[Any]) -> Work:
    """A launch as a graph."""
    wp.load_module(module)
    with wp.ScopedCapture() as capture:
        wp.launch(kernel, count, inputs)
    return Work(partial(wp.capture_launch, capture.graph))


def scipy_solve(bands: int, count: int, long: bool) -> Work:
    """LAPACK, rod by rod or on one matrix."""
    rows = coefficients(bands, count)
    if long:
        rows = rows.reshape(bands, 1, -1)
    packed = np.ascontiguousarray(rows.transpose(1, 0, 2)[:, ::-1])
    right, width = np.ones(packed.shape[2]), bands // 2

    def solve() -> None:
        for rod in packed:
            solve_banded((width, width), rod, right, check_finite=False)

    return Work(solve)


def numba_solve(bands: int, count: int) -> Work:
    rows, right, solution = coefficients(bands, count), np.ones((count, NODES)), np.empty((count, NODES))
    solve = loops.tridiagonal if bands == 3 else loops.pentadiagonal
    return Work(partial(solve, rows, right, np.empty(NODES), np.empty(NODES), solution))


def solves(size: Size, bands: int, settings: Settings) -> Table:
    """Solves with variable coefficients."""
    columns = dict[str, dict[str, float]]()
    for count in size.batches:
        settings.tell(f"{DIAGONALS[bands]}, {count} rods")
        works = {"copy": copy(size.numbers)}
        works |= {"ours, numbers": our_solve(bands, count, False), "ours, pairs": our_solve(bands, count, True)}
        works |= {"ours in tiles, numbers": our_solve_in_tiles(bands, count, False)}
        works |= {"ours in tiles, pairs": our_solve_in_tiles(bands, count, True)}
        if count <= size.scipy:
            works["LAPACK, rod by rod"] = scipy_solve(bands, count, False)
        works["LAPACK, one long matrix"] = scipy_solve(bands, count, True)
        if not missing("numba"):
            works["Numba, numbers"] = numba_solve(bands, count)
        columns[f"B = {count}"] = per_node_of(works, size, count * NODES, BYTES_OF_SOLVE[bands])
    return across(f"{DIAGONALS[bands]} solve, ns a node", columns)


def per_node_of(works: Mapping[str, Work], size: Size, nodes: int, moved: int) -> dict[str, float]:
    """ns a node of each work, and the copy bound of ``moved`` bytes a node."""
    times = in_turns(works, size.repeats)
    found = {name: 1e9 * time.median / nodes for name, time in times.items() if name != "copy"}
    return {"copy bound": 1e9 * moved / bytes_per_second(times["copy"].median, size.numbers), **found}


def across(title: str, columns: Mapping[str, Mapping[str, float]]) -> Table:
    """A table of columns {column: {row: value}}."""
    names = dict.fromkeys(name for column in columns.values() for name in column)
    rows: list[list[Cell]] = [[name, *(column.get(name) for column in columns.values())] for name in names]
    return Table(title, ["", *columns], rows)


# --- path products ----------------------------------------------------------------------------------------------------


def products(size: Size, settings: Settings) -> Table:
    """Frames along rods from their strains."""
    columns = dict[str, dict[str, float]]()
    for count in size.batches:
        settings.tell(f"path products, {count} rods")
        strain = np.random.default_rng(1).normal(size=(count, NODES, 3))
        works = {"copy": copy(size.numbers), "ours": our_product(strain)}
        R, r = np.zeros((count, NODES, 3, 3)), np.zeros((count, NODES, 3))
        R[:, 0] = np.eye(3)
        if not missing("numba"):
            works["Numba, sine and cosine"] = Work(partial(loops.frames, strain, 1 / (NODES - 1), R, r))
        if count <= size.scipy:
            works["SciPy Rotation and NumPy, all rods at once"] = Work(partial(numpy_product, strain))
        columns[f"B = {count}"] = per_node_of(works, size, count * NODES, BYTES_OF_FRAMES)
    return across("path-ordered product of SE(3), ns a node", columns)


def our_product(strain: np.ndarray) -> Work:
    count = len(strain)
    arrays = [per_node(count, NODES, wp.vec3d), per_rod(count), per_node(count, NODES, wp.mat33d)]
    arrays.append(per_node(count, NODES, wp.vec3d))
    R = np.zeros((count, NODES, 3, 3))
    R[:, NODES // 2] = np.eye(3)
    for array, value in zip(arrays, (strain, np.full(count, 1 / (NODES - 1)), R), strict=False):
        array.assign(value)
    strains, spacing, rotation, position = arrays
    return recorded(lie, lie.integrate_frames, count, [strains, spacing, NODES // 2, rotation, position])


def numpy_product(strain: np.ndarray) -> np.ndarray:
    """Places to second order: tangents from products of SciPy's rotations, node by node."""
    h = 1 / (NODES - 1)
    turns = Rotation.from_rotvec((h * (strain[:, 1:] + strain[:, :-1]) / 2).reshape(-1, 3)).as_matrix()
    turns = turns.reshape(len(strain), NODES - 1, 3, 3)
    R, tangents = np.broadcast_to(np.eye(3), (len(strain), 3, 3)), []
    for i in range(NODES - 1):
        tangents.append(R[..., 0])
        R = R @ turns[:, i]
    return np.cumsum(tangents, axis=0) * h


# --- pairs and steps --------------------------------------------------------------------------------------------------


def pairs(size: Size, settings: Settings) -> Table:
    """Steric forces between sensors on a dumbbell."""
    settings.tell(f"pairs of {size.crowd} rods")
    found = crowd.Packed(size.crowd)
    listed = found.pairs()
    works = {"ours, forces and stiffness": Work(found.apply), "ours, the lists": Work(found.list)}
    if not missing("numba"):
        works["Numba, forces over a given list"] = Work(partial(found.numba_forces, listed))
    works["cKDTree, the list"] = Work(found.pairs)
    times = in_turns(works, size.repeats)
    rows: list[list[Cell]] = [
        [name, 1e9 * t.median / len(listed), 1e9 * t.median / found.nodes] for name, t in times.items()
    ]
    title = f"contact, {size.crowd} rods of {found.rods.nodes} nodes, {len(listed) / found.nodes:.1f} pairs a node"
    return Table(title, ["", "ns a pair", "ns a node"], rows)


def steps(size: Size, settings: Settings, kind: str) -> Table:
    """Whole steps of rods that do not feel each other."""
    columns = dict[str, dict[str, float]]()
    makers = rods.FREE if kind == "free" else {name: rods.BOUND[name] for name in size.membranes}
    for count in size.rod_batches if kind == "free" else size.bound_batches:
        settings.tell(f"{kind} rods, {count}")
        works, counters = dict[str, Work](), dict[str, rods.Stepped]()
        for name, make in makers.items():
            for how in rods.WAYS:
                stepped = counters[f"{name}, {how}"] = rods.Stepped(make(count), how)
                works[f"{name}, {how}"] = Work(stepped.run, stepped.restore)
        node_steps = {name: stepped.node_steps for name, stepped in counters.items()}
        if kind == "free" and not missing("numba"):
            works[LOOPS], node_steps[LOOPS] = numba_steps(count)
        times = in_turns(works, size.repeats)
        columns[f"B = {count}"] = {name: 1e9 * t.median / node_steps[name] for name, t in times.items()}
    return across(f"whole steps of {kind} rods, ns a node", columns)


LOOPS = "Numba loops, in a plane, half a rod, together"


def numba_steps(count: int) -> tuple[Work, int]:
    """Equal steps of ours in plain loops, one rod after another; and nodes times steps."""
    problem, steps = Problem(1e-3, FULL_SWIMMER), 100
    y, before = problem.half.copy(), problem.half.copy()
    planar_steps.advance(y, before, 1e-3, steps, *problem.swimmer)
    works = [(y.copy(), before.copy()) for _ in range(count)]

    def run() -> None:
        for now, last in works:
            planar_steps.advance(now, last, 1e-3, steps, *problem.swimmer)

    return Work(run), count * steps * (len(y) // 2)
