"""Kill runs with SIGKILL at moments of many kinds; resume each, and compare it with one that was not stopped. A script.

Usage: killed.py FOLDER COUNT SEED [SCENE …], with COUNT kills, in turn of each kind. Prints a table: kind of moment,
kills, how many of these runs were resumed to the same bits.

A kill is either just before the nth change of a file, the half of a write included, or after a random time. The run
tells in shared memory what it is doing, so that each kill is counted where it was.
"""

import contextlib
import itertools
import logging
import mmap
import os
import pathlib
import shutil
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from half_writes import Halves, opening

from warp_rods import workflow
from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.simulation import run_folder, runner, saver
from warp_rods.simulation.check import check_run
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.run_folder import RunFolder

CHANGES = {"os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate"}
START, FIRST, STEP, FRAME, CHECKPOINT, SCENE, RESUME, EXPORT = KINDS = (
    "start, no store yet", "before the first checkpoint", "step", "frame", "checkpoint", "scene.toml", "resume",
    "export",
)  # fmt: skip
MADE = {"animation.usdc", "poster.png"}
LEFT = {".lock", "scene.toml", "checkpoint.npz", "trajectory.zarr", "membrane.npz"} | MADE
SHORT, LONG = 0.03, 0.05
FILAMENT = {"name": "one", "count": 40, "nodes": 17, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1],
            "intrinsic": [0.0, 1.5, 0.5]}  # fmt: skip
CELL = {"name": "cell", "count": 40, "nodes": 17, "bend": 1e-3, "twist": 1e-3}
STEPS = {"step": 1e-3, "save_every": 0.01}
BOXED = {"box": {"kind": "periodic", "size": [3.0, 3.0, 3.0]}, "steric": {"strength": 500, "range": 0.03, "core": 0.07}}


def scene(kind: str, end: float, folder: Path) -> Scene:
    """Filaments on a membrane from a file, in steps of a given length; swimmers in steps by error, alone or not."""
    if kind == "given steps":
        surface = {"kind": "grid", "file": folder / "ball.npy", "spacing": 0.2}
        return Scene.parse({"surface": surface, "filaments": [FILAMENT], "time": {"end": end, **STEPS}})
    other = BOXED if kind == "steps together" else {}
    cells = {**CELL, "placement": "random"} if other else CELL
    return Scene.parse({"swimmers": [cells], "time": {"end": end, "save_every": 0.01}, **other})


SCENES = ("given steps", "own steps", "steps together")


def write_ball(folder: Path) -> None:
    """A level set of a ball."""
    x = np.arange(-8, 9) * 0.2
    np.save(folder / "ball.npy", np.sqrt(sum(a**2 for a in np.meshgrid(x, x, x, indexing="ij"))) - 1.0)


class Moments:
    """What a run is doing, in memory that it shares with this process, and kills when it has done enough of it."""

    def __init__(self) -> None:
        self._shared = mmap.mmap(-1, 8 * (len(KINDS) + 1))
        self._numbers = np.frombuffer(self._shared, np.int64)
        self.kill: tuple[str, int] | None = None

    @property
    def now(self) -> str:
        return KINDS[self._numbers[-1]]

    @property
    def changes(self) -> dict[str, int]:
        """Changes of files so far, by what the run was doing."""
        return dict(zip(KINDS, self._numbers[:-1].tolist(), strict=True))

    def reset(self, kill: tuple[str, int] | None) -> None:
        """A new run, to be killed before the nth change of a file while it does something; None: not here."""
        self._numbers[:], self.kill = 0, kill

    def change(self) -> None:
        """A file is about to change."""
        index = int(self._numbers[-1])
        self._numbers[index] += 1
        if self.kill == (KINDS[index], self._numbers[index]):
            os.kill(os.getpid(), signal.SIGKILL)

    @contextlib.contextmanager
    def doing(self, kind: str):
        before, self._numbers[-1] = self._numbers[-1], KINDS.index(kind)
        yield
        self._numbers[-1] = before

    def watch(self, folder: Path) -> None:
        """In the process of a run: count changes of files in a folder, and note what is done."""

        def seen(event: str, arguments: tuple) -> None:
            writes = event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
            if (writes or event in CHANGES) and str(folder) in str(arguments[0]):
                self.change()

        sys.addaudithook(seen)
        pathlib.Path.open = opening(folder, lambda file: Halves(file, self.change))
        early = lambda kind: kind if (folder / "checkpoint.npz").exists() else FIRST  # noqa: E731
        self._wrap(RunFolder, "append", lambda: early(FRAME))
        self._wrap(RunFolder, "checkpoint", lambda: early(CHECKPOINT))
        self._wrap(run_folder, "_keep_scene", lambda: SCENE)
        self._wrap(RunFolder, "resume", lambda: RESUME)
        self._wrap(runner, "_loop", lambda: early(STEP))
        self._wrap(Simulation, "to_next_frame", lambda: STEP, generator=True)
        self._wrap(workflow, "_animate", lambda: EXPORT)
        self._numbers[-1] = KINDS.index(START)

    def _wrap(self, owner, name: str, kind: Callable[[], str], generator: bool = False) -> None:
        real = getattr(owner, name)

        def noted(*arguments, **named):
            with self.doing(kind()):
                return real(*arguments, **named)

        def steps(*arguments):
            with self.doing(kind()):
                for done in real(*arguments):
                    self.change()  # so that kills can fall on steps, however short they are
                    yield done

        setattr(owner, name, steps if generator else noted)


def fork(work: Callable[[], object]) -> int:
    """Do the work in a forked process; returns the number of the process."""
    if (child := os.fork()) == 0:
        code = 1
        try:
            work()
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    return child


def code_of(child: int) -> int:
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def compare(folder: Path, whole: Path) -> None:
    """A resumed run has the bits and the files of one that was never stopped."""
    assert "no damage" in check_run(folder)
    left = {file.name for file in folder.iterdir()}
    assert left <= LEFT and left | MADE == {file.name for file in whole.iterdir()} | MADE, left
    one, other = open_run(folder), open_run(whole)
    for name, group in other.children.items():
        for variable, values in group.data_vars.items():
            np.testing.assert_array_equal(one[name][variable], values, err_msg=str(variable))
    for file in ("scene.toml", "membrane.npz"):
        assert not (whole / file).exists() or (folder / file).read_bytes() == (whole / file).read_bytes()


class Killer:
    """Runs of the scenes that were never stopped, and kills of others like them."""

    def __init__(self, top: Path, seed: int):
        self.top, self.rng, self.moments = top, np.random.default_rng(seed), Moments()
        self.tried, self.survived = Counter[str](), Counter[str]()
        self.changes: dict[tuple[str, str], dict[str, int]] = {}
        self.seconds: dict[tuple[str, str], float] = {}

    def run(self, kind: str, how: str, folder: Path, doing: str = EXPORT) -> None:
        """The run that is killed: a fresh one, one that continues a shorter one, or one that replaces another."""
        run = workflow.run if doing == EXPORT else runner.simulate  # without an animation
        run(scene(kind, LONG, self.top), folder, device="cpu", resume=how != "replaced", overwrite=how == "replaced")

    def prepare(self, kind: str, how: str, folder: Path) -> None:
        shutil.rmtree(folder, ignore_errors=True)
        if how != "fresh":
            shutil.copytree(self.top / f"{'short' if how == 'resumed' else 'other'} {kind}", folder)

    def begin(self, kind: str) -> None:
        """Make the runs that are never stopped, and count the changes of files of one like those that are killed."""
        given = scene(kind, SHORT, self.top)
        runner.simulate(given, self.top / f"short {kind}", device="cpu")  # here, so that forks have the kernels
        other = given.model_copy(update={"seed": 7})
        assert code_of(fork(lambda: workflow.run(other, self.top / f"other {kind}", device="cpu"))) == 0
        assert code_of(fork(lambda: self.run(kind, "fresh", self.top / f"whole {kind}"))) == 0
        for how in ("fresh", "resumed", "replaced"):
            self.moments.reset(None)
            begun = time.perf_counter()
            assert code_of(self.start(kind, how)) == 0
            self.seconds[kind, how] = time.perf_counter() - begun
            self.changes[kind, how] = self.moments.changes

    def start(self, kind: str, how: str, doing: str = EXPORT) -> int:
        folder = self.top / "run"
        self.prepare(kind, how, folder)

        def work() -> None:
            self.moments.watch(folder)
            self.run(kind, how, folder, doing)

        return fork(work)

    def kill(self, kind: str, how: str, doing: str, at_change: bool) -> bool:
        """Kill a run while it does something; returns whether that happened. Counts it by what the run was doing."""
        number = self.changes[kind, how][doing]
        if at_change and not number:
            return False
        self.moments.reset((doing, int(self.rng.integers(1, number + 1))) if at_change else None)
        child = self.start(kind, how, doing)
        if not at_change:
            end = time.perf_counter() + 60
            while self.moments.now != doing and time.perf_counter() < end and not exited(child):
                time.sleep(1e-4)
            time.sleep(self.rng.uniform(0, 0.1 if doing in (STEP, EXPORT) else 0.01))
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
        if code_of(child) != -signal.SIGKILL:
            return False
        where = f"{self.moments.now}{' (replacing a run)' if how == 'replaced' else ''}"
        self.tried[where] += 1
        survived = code_of(fork(lambda: self.go_on(kind, how, doing))) == 0
        self.survived[where] += survived
        print(f"{kind}, {how}: {where}, {'change of a file' if at_change else 'time'}: {survived}", file=sys.stderr)
        return True

    def go_on(self, kind: str, how: str, doing: str) -> None:
        """Resume a killed run as a job script would. A run that has not been replaced yet is refused, and whole."""
        folder, whole = self.top / "run", self.top / f"whole {kind}"
        try:
            self.run(kind, "resumed", folder, doing)
        except RunFolderError as error:
            assert how == "replaced" and "differs from the scene given in seed" in str(error), error
            compare(folder, self.top / f"other {kind}")
            return
        compare(folder, whole)
        assert doing != EXPORT or (folder / "animation.usdc").stat().st_size > 0


def each_second_frame_waits() -> None:
    """Frames with odd numbers wait, and are written with the next one; a checkpoint follows each write."""
    append = RunFolder.append

    def held(self: RunFolder, *arguments) -> None:
        odd = (self.writer.frames + len(self.writer._held)) % 2 == 1
        run_folder.FRAMES_EVERY = saver.CHECKPOINT_EVERY = np.inf if odd else 0.0
        append(self, *arguments)

    RunFolder.append = held


def exited(child: int) -> bool:
    return os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


PLAN = (
    (START, "fresh", True), (FIRST, "fresh", True), (START, "replaced", True), (STEP, "fresh", True),
    (FRAME, "fresh", True), (CHECKPOINT, "resumed", True), (SCENE, "fresh", True), (SCENE, "resumed", True),
    (RESUME, "resumed", True), (FRAME, "resumed", False), (STEP, "resumed", False), (EXPORT, "fresh", True),
    (EXPORT, "resumed", False),
)  # fmt: skip
"""What a run does when it is killed, which run it is, and whether it is killed at a change of a file or at a time."""


def main(top: Path, count: int, seed: int, kinds: list[str]) -> None:
    from pxr import Usd  # noqa: F401  here, so that forks have it

    logging.getLogger("warp_rods").setLevel(logging.ERROR)
    each_second_frame_waits()
    write_ball(top)
    killer, kinds = Killer(top, seed), kinds or list(SCENES)
    for kind in kinds:
        killer.begin(kind)
    for number, (doing, how, at_change) in enumerate(itertools.cycle(PLAN)):
        killer.kill(kinds[(number + number // len(PLAN)) % len(kinds)], how, doing, at_change)
        if killer.tried.total() == count:
            break
    for where in sorted(killer.tried):
        print(f"{where:45} {killer.tried[where]:5} {killer.survived[where]:5}")
    print(f"{'all':45} {killer.tried.total():5} {killer.survived.total():5}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:])
