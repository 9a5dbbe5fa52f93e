"""Kill a resumed run at the nth change of a file, for n = 1, 2, …; then resume it again and compare. A script.

Usage: killed_resumes.py FOLDER FIRST STEP, for n from FIRST in steps of STEP. Prints the number of kills.
"""

import os
import shutil
import signal
import sys
from pathlib import Path

import numpy as np

from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner
from warp_rods.simulation.check import check_run
from warp_rods.simulation.trajectory import open_run

FILAMENT = {"name": "one", "count": 3, "nodes": 9, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
CHANGES = {"os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate"}


def scene(end: float) -> Scene:
    time = {"end": end, "step": 1e-3, "save_every": 0.01}
    surface = {"kind": "sphere", "radius": 1.0}
    intrinsic = {"intrinsic": [0.0, 1.5, 0.5]}
    return Scene.parse({"surface": surface, "filaments": [{**FILAMENT, **intrinsic}], "time": time})


def kill_at(moment: int, folder: Path) -> None:
    """Kill this process just before its nth change of a file in a folder."""
    seen = 0

    def watch(event: str, arguments: tuple) -> None:
        nonlocal seen
        writes = event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        if (writes or event in CHANGES) and str(folder) in str(arguments[0]):
            seen += 1
            if seen == moment:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(watch)


def in_child(work) -> int:
    """Do the work in a forked process; returns its exit code, negative for a signal."""
    if (child := os.fork()) == 0:
        code = 1
        try:
            work()
            code = 0
        finally:
            sys.stderr.flush()
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def continue_and_compare(folder: Path, whole: Path) -> None:
    """Resume the run as a user would, from its own scene, and compare it with one that was never stopped."""
    assert open_run(folder)["one"].sizes["frame"] >= 4
    runner.simulate(scene(0.05), folder, device="cpu", resume=True)
    check_run(folder)
    one, other = open_run(folder)["one"], open_run(whole)["one"]
    assert one.sizes["frame"] == 6
    for name in one.data_vars:
        np.testing.assert_array_equal(one[name], other[name], err_msg=str(name))
    assert (folder / "scene.toml").read_bytes() == (whole / "scene.toml").read_bytes()


def main(top: Path, first: int, step: int) -> None:
    runner.CHECKPOINT_EVERY = 0.0
    begun, whole, folder = top / "begun", top / "whole", top / "run"
    assert in_child(lambda: runner.simulate(scene(0.03), begun, device="cpu")) == 0
    assert in_child(lambda: runner.simulate(scene(0.05), whole, device="cpu")) == 0
    kills, moment = 0, first
    while True:
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(begun, folder)

        def resumed(moment: int = moment) -> None:
            kill_at(moment, folder)
            runner.simulate(scene(0.05), folder, device="cpu", resume=True)

        if (code := in_child(resumed)) == 0:
            break
        assert code == -signal.SIGKILL, f"moment {moment}: exit code {code}"
        assert in_child(lambda: continue_and_compare(folder, whole)) == 0, f"after a kill at moment {moment}"
        kills += 1
        moment += step
    print(kills)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
