"""Steps on a GPU: rods a second for batches of different sizes, and how much of the memory's bandwidth they use."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import warp as wp

from warp_rods.bench import rods
from warp_rods.bench.result import Section, Settings, Table
from warp_rods.rods.ensemble import Ensemble
from warp_rods.simulation.estimates import FOOTPRINTS

COUNTS = (1000, 10_000, 100_000, 1_000_000)
BYTES_OF_STEP = 2440
"""Bytes that a step of a free rod in space reads and writes for each node, as its kernel is written: 305 numbers, of
which caches hold many (own steps of second order, without loads)."""
SHARE = 0.8
"""The part of the free memory that rods may take."""


def run(settings: Settings) -> Section:
    """Rod-steps a second; without a CUDA device only a note."""
    if not wp.is_cuda_available():
        return Section((), notes=("No CUDA device here: not run.",))
    device = wp.get_device("cuda:0")
    with wp.ScopedDevice(device):
        copied = copy_bandwidth(16 if settings.quick else 2**28)
        counts = (16,) if settings.quick else COUNTS
        rows = [row(count, device, copied, settings) for count in counts if fits(count, device)]
    title = f"{device.name}: swimmers in space, 65 nodes, float64; copies take {copied / 1e9:.0f} GB/s"
    columns = ["rods", "rod-steps a second", "ns a node and step", "part of the bandwidth of copies"]
    return Section([Table(title, columns, rows)], notes=(NOTES,))


NOTES = (
    f"Wall time of own steps. {BYTES_OF_STEP} bytes a node and step are counted from the "
    "kernel, so the last column may pass 1 where caches serve."
)


def fits(count: int, device: Any) -> bool:
    """Whether so many rods fit."""
    return count * rods.FREE_NODES * FOOTPRINTS["swimmers"].on_gpu < SHARE * device.free_memory


def seconds(work: Callable[[], object]) -> float:
    """Wall time until the device is done."""
    wp.synchronize()
    start = time.perf_counter()
    work()
    wp.synchronize()
    return time.perf_counter() - start


def copy_bandwidth(numbers: int) -> float:
    """Bytes a second that a copy reads and writes."""
    source, target = (wp.zeros(numbers, dtype=wp.float64) for _ in range(2))
    return 16 * numbers / min(seconds(lambda: wp.copy(target, source)) for _ in range(5))


def row(count: int, device: Any, copied: float, settings: Settings) -> list[Any]:
    """Figures of a batch."""
    settings.tell(f"{count} rods on {device.name}")
    ensemble: Ensemble = rods.swimmers(count, True)
    ensemble.advance_to(0.01)  # loads the kernels
    before = taken(ensemble)
    elapsed = seconds(lambda: ensemble.advance_to(0.06))
    steps = taken(ensemble) - before
    each = elapsed / steps / rods.FREE_NODES
    return [float(count), steps / elapsed, 1e9 * each, BYTES_OF_STEP / each / copied]


def taken(ensemble: Ensemble) -> int:
    """Steps of all rods, those that were repeated included."""
    return int((ensemble.steps_taken + ensemble.steps_rejected).sum())
