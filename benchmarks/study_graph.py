"""What a task of a study costs client, scheduler and disk, with tasks that do nothing; for docs/cluster.md. A script.

Usage: study_graph.py WORKERS TASKS. Workers are in processes of 100, on this machine.
"""

import multiprocessing
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil

from warp_rods.scene.scene import Scene
from warp_rods.studies.columns import Column
from warp_rods.studies.new_store import create
from warp_rods.studies.plan import Plan
from warp_rods.studies.store import OWN

EACH_PROCESS = 100
CELL = {"name": "cell", "count": 1, "nodes": 17, "bend": 1e-3, "twist": 1e-3}


def scheduler(addresses: multiprocessing.Queue) -> None:
    """A scheduler, which tells its address and never ends."""
    import asyncio

    from distributed import Scheduler

    async def run() -> None:
        async with Scheduler(port=0, dashboard=False) as made:
            addresses.put(made.address)
            await made.finished()

    asyncio.run(run())


def workers(address: str, count: int) -> None:
    """So many workers with one thread each."""
    import asyncio

    from distributed import Worker

    async def run() -> None:
        made = [Worker(address, nthreads=1, memory_limit=0, dashboard=False) for _ in range(count)]
        await asyncio.gather(*made)
        await asyncio.gather(*(one.finished() for one in made))

    asyncio.run(run())


def nothing(number: int) -> int:
    """A task."""
    return number


def of(process: psutil.Process) -> tuple[float, float]:
    """CPU seconds, and memory in MB."""
    times = process.cpu_times()
    return times.user + times.system, process.memory_info().rss / 1e6


def all_at_once(client, tasks: int) -> float:
    """Submit everything, then wait; returns the seconds until the first task had ended."""
    from distributed import as_completed

    begun, first = time.perf_counter(), 0.0
    for _ in as_completed(client.map(nothing, range(tasks), pure=False)):
        first = first or time.perf_counter() - begun
    return first


def in_windows(client, tasks: int) -> float:
    """As studies do."""
    from warp_rods.studies import dispatch
    from warp_rods.studies.tasks import Outcome, Task

    real, begun, first = dispatch.work, time.perf_counter(), [0.0]
    dispatch.work = _trivial

    def tell(_task: Task, _outcome: Outcome) -> None:
        first[0] = first[0] or time.perf_counter() - begun

    dispatch.run_on(client, "", (Task(0, (i,), ((i,),)) for i in range(tasks)), "cpu", "", tell)
    dispatch.work = real
    return first[0]


def _trivial(_folder, task, _device, _version):
    from warp_rods.studies.tasks import Outcome

    return Outcome(len(task.points), {}, 0.0)


def store(tasks: int) -> tuple[float, float]:
    """CPU and wall seconds of writing the files of a task, with the usual measures."""
    sweep = {"swimmers.cell.moment": {"from": 0.0, "to": 1.0, "num": 50 * tasks}, "measure": ["speed"]}
    plan = Plan(Scene.parse({"swimmers": [CELL], "time": {"end": 1.0}, "sweep": sweep}))
    columns = [Column("class", text=True), Column("speed"), Column("period"), Column("modes", ("c", "m"), (2, 6))]
    with tempfile.TemporaryDirectory() as folder:
        own = [name for name in OWN if name != "trajectory"]
        made = create(Path(folder) / "s", plan.axes, columns, (50, 1), own, {}, {})
        values = {"state": np.ones(50, np.int8), "speed": np.ones(50), "modes": np.ones((50, 2, 6))}
        before, begun = time.process_time(), time.perf_counter()
        for task in range(tasks):
            made.put((task, 0), [(50 * task + i, 0) for i in range(50)], values)
        cpu, wall = time.process_time() - before, time.perf_counter() - begun
        before = time.process_time()
        made.states()
        print(f"reading the states of {tasks} tasks: {1e3 * (time.process_time() - before) / tasks:.2g} ms a task")
        return cpu, wall


def main(count: int, tasks: int) -> None:
    """Print a table."""
    from distributed import Client

    context = multiprocessing.get_context("spawn")
    addresses = context.Queue()
    processes = [context.Process(target=scheduler, args=(addresses,))]
    processes[0].start()
    address = addresses.get()
    for first in range(0, count, EACH_PROCESS):
        part = min(EACH_PROCESS, count - first)
        processes.append(context.Process(target=workers, args=(address, part)))
        processes[-1].start()
    here, there = psutil.Process(), psutil.Process(processes[0].pid)
    with Client(address) as client:
        client.wait_for_workers(count)
        for name, run in (("in windows", in_windows), ("all at once", all_at_once)):
            mine, its, begun = of(here), of(there), time.perf_counter()
            first = run(client, tasks)
            wall, after, its_after = time.perf_counter() - begun, of(here), of(there)
            print(
                f"{count} workers, {tasks} tasks {name}: client {1e3 * (after[0] - mine[0]) / tasks:.2f} ms, scheduler "
                f"{1e3 * (its_after[0] - its[0]) / tasks:.2f} ms of CPU a task, scheduler's memory "
                f"{its_after[1] - its[1]:+.0f} MB, first task after {first:.1f} s, {wall:.0f} s in all",
                flush=True,
            )
    for process in processes:
        process.kill()


if __name__ == "__main__":
    cpu, wall = store(50)
    print(f"store: {1e3 * cpu / 50:.2f} ms of CPU, {1e3 * wall / 50:.1f} ms in all a task, 8 files")
    main(int(sys.argv[1]), int(sys.argv[2]))
