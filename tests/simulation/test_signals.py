"""Signals: a run finishes its step, saves its state and says how to go on; a second signal ends it at once."""

import os
import shlex
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import warp_rods as wr
from warp_rods import cli
from warp_rods.scene.scene import Scene
from warp_rods.simulation import interruption, portions, runner
from warp_rods.simulation.checkpoint import read_checkpoint
from warp_rods.simulation.interruption import Interrupted
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.reading import open_run

CELL = {"name": "cell", "count": 3, "nodes": 33, "bend": 5e-3, "twist": 1e-3}
FILAMENT = {"name": "rods", "count": 3, "nodes": 33, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1],
            "intrinsic": [0.0, 1.5, 0.5]}  # fmt: skip
SPHERE = {"surface": {"kind": "sphere", "radius": 1.0}}
STERIC = {"steric": {"strength": 500, "range": 0.03, "core": 0.07}}
GIVEN = {"time": {"end": 0.04, "step": 1e-3, "save_every": 0.02}}
SCENES = {
    "swimmers, own steps": {"swimmers": [CELL]},
    "filaments, own steps": {"filaments": [FILAMENT], **SPHERE},
    "growing filaments, own steps": {"filaments": [{**FILAMENT, "growth": {"rate": 2.0, "until": 0.7}}], **SPHERE},
    "both kinds, own steps": {"swimmers": [CELL], "filaments": [FILAMENT], **SPHERE},
    "steps together": {"swimmers": [CELL], **STERIC, "box": {"kind": "periodic", "size": [3.0, 3.0, 3.0]}},
    "swimmers, steps of a given length": {"swimmers": [CELL], **GIVEN},
    "filaments, steps of a given length": {"filaments": [FILAMENT], **SPHERE, **GIVEN},
    "steps of a given length together": {"filaments": [FILAMENT], **SPHERE, **STERIC, **GIVEN},
}
LONG = {
    "steps of a given length together",
    "growing filaments, own steps",
    "both kinds, own steps",
    "filaments, steps of a given length",
}


def scene(name: str) -> Scene:
    return Scene.parse({"time": {"end": 0.04, "save_every": 0.02}, **SCENES[name]})


@pytest.fixture(autouse=True)
def short_portions(monkeypatch):
    """Rods in steps of their own are looked at several times between two frames."""
    monkeypatch.setattr(portions, "FIRST", 0.2)
    monkeypatch.setattr(portions, "LONGER", 1.0)
    monkeypatch.setattr(portions, "SHORTER", 1.0)


@pytest.fixture
def signalled(monkeypatch):
    """Sends signals to this process after the nth step between frames, counted over the whole run."""

    def send_at(moments: dict[int, signal.Signals]) -> None:
        real, steps = Simulation.to_next_frame, []

        def to_next_frame(self):
            for done in real(self):
                steps.append(done)
                if len(steps) in moments:
                    os.kill(os.getpid(), moments[len(steps)])
                    time.sleep(0.01)
                yield done

        monkeypatch.setattr(Simulation, "to_next_frame", to_next_frame)

    return send_at


def same(one, other) -> None:
    for name, group in open_run(other).children.items():
        for variable, values in group.data_vars.items():
            np.testing.assert_array_equal(open_run(one)[name][variable], values, err_msg=f"{name}/{variable}")


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.long] * (n in LONG)) for n in SCENES])
def test_a_run_that_is_stopped_between_frames_resumes_with_the_same_bits(tmp_path, signalled, monkeypatch, name):
    """Twice: in the first and in the second time between frames."""
    whole = runner.simulate(scene(name), tmp_path / "whole", device="cpu")
    stopped, count = tmp_path / "stopped", open_run(whole.folder)
    for moments, frames in (({3: signal.SIGINT}, 1), ({2: signal.SIGINT}, None)):
        with monkeypatch.context():
            signalled(moments)
            with pytest.raises(KeyboardInterrupt):
                runner.simulate(scene(name), stopped, device="cpu", resume=True)
        monkeypatch.undo()
        state = read_checkpoint(stopped)
        now = next(values[0] for key, values in state.items() if key.endswith("/clock"))
        assert 0 < now < 0.04 and now not in (0.02, 0.04)
        assert frames in (None, len(open_run(stopped).children[next(iter(count.children))].time))
        said = open_run(stopped).attrs["messages"][-1]
        assert f"stopped at t = {now:g}" in said and f"--resume continues from t = {now:g}: warp-rods run " in said
    again = runner.simulate(scene(name), stopped, device="cpu", resume=True)
    assert not again.lost
    same(stopped, whole.folder)


def test_the_last_time_between_frames_is_left_only_where_a_longer_run_agrees(tmp_path, signalled):
    """A shorter last interval has steps of its own, which a longer run does not take: a restart begins before it."""
    changes = {"time": {"end": 0.05, "step": 1e-3, "save_every": 0.02}}
    given, longer = (Scene.parse({"swimmers": [CELL], "time": {**changes["time"], "end": end}}) for end in (0.05, 0.06))
    whole = runner.simulate(longer, tmp_path / "whole", device="cpu").folder
    signalled({46: signal.SIGINT})
    with pytest.raises(KeyboardInterrupt):
        runner.simulate(given, tmp_path / "run", device="cpu")
    runner.simulate(longer, tmp_path / "run", device="cpu", resume=True)
    same(tmp_path / "run", whole)


def test_a_shorter_end_than_the_frame_on_the_way_is_refused(tmp_path, signalled):
    signalled({25: signal.SIGINT})
    with pytest.raises(KeyboardInterrupt):
        runner.simulate(scene("swimmers, steps of a given length"), tmp_path / "run", device="cpu")
    for end in (0.02, 0.03):
        shorter = Scene.parse({"swimmers": [CELL], "time": {**GIVEN["time"], "end": end}})
        with pytest.raises(
            wr.RunFolderError, match=rf"stopped at t = 0\.025, on its way to .* beyond time\.end = {end}"
        ):
            runner.simulate(shorter, tmp_path / "run", device="cpu", resume=True)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_other_signals_end_a_python_caller_with_the_code_of_a_shell(tmp_path, signalled, number, code):
    signalled({2: number})
    before = [signal.getsignal(each) for each in interruption.SIGNALS]
    with pytest.raises(SystemExit) as ended:
        runner.simulate(scene("swimmers, own steps"), tmp_path / "run", device="cpu")
    assert ended.value.code == code
    assert [signal.getsignal(each) for each in interruption.SIGNALS] == before
    assert f"by {number.name}" in open_run(tmp_path / "run").attrs["messages"][-1]


def test_signals_that_the_caller_ignores_or_handles_are_left_alone(tmp_path, signalled):
    """As under nohup, and in programs with a handler of their own."""
    got, given = [], scene("swimmers, own steps")
    before = {number: signal.getsignal(number) for number in (signal.SIGHUP, signal.SIGTERM)}
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda number, frame: got.append(number))
    try:
        signalled({2: signal.SIGHUP, 3: signal.SIGTERM})
        assert runner.simulate(given, tmp_path / "run", device="cpu").data["cell"].sizes["frame"] == 3
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert got == [signal.SIGTERM]


def test_a_second_signal_is_not_waited_for(tmp_path, signalled, monkeypatch):
    """In Python it raises KeyboardInterrupt within the step; elsewhere it kills the process (below)."""
    signalled({2: signal.SIGINT})

    def slow(*_arguments) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(30)

    monkeypatch.setattr(runner, "leave", slow)
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        runner.simulate(scene("swimmers, own steps"), tmp_path / "run", device="cpu")
    assert time.monotonic() - begun < 20


def test_another_thread_runs_without_handlers(tmp_path):
    done = []
    thread = threading.Thread(
        target=lambda: done.append(runner.simulate(scene("swimmers, own steps"), tmp_path / "run", device="cpu"))
    )
    thread.start()
    thread.join()
    assert done and signal.getsignal(signal.SIGINT) is signal.default_int_handler


# --- the command line -------------------------------------------------------------------------------------------------

TEXT = """
[[swimmers]]
name = "cell"
count = 3
nodes = 33
bend = 5e-3
twist = 1e-3
[time]
end = 0.2
step = 1e-4
save_every = 0.1
"""


def forked(work) -> int:
    """The number of a process that does this work, with the exit code that Python would give it."""
    if (child := os.fork()) == 0:
        code = 99
        try:
            work()
            code = 0
        except SystemExit as ended:
            code = ended.code or 0
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    return child


def command_line(arguments, output: Path, before=lambda: None) -> int:
    """``warp-rods`` in a process of its own, from here, where kernels are loaded; output and errors go to one file."""

    def work() -> None:
        descriptor = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(descriptor, 1)
        os.dup2(descriptor, 2)
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
        sys.argv = ["warp-rods", *map(str, arguments)]
        before()
        cli.main()

    return forked(work)


def ended(child: int) -> int:
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def wait_for(condition) -> None:
    end = time.monotonic() + 120
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


@pytest.fixture
def small(tmp_path) -> Path:
    path = tmp_path / "small.toml"
    path.write_text(TEXT)
    return path


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)], ids=["INT", "TERM", "HUP"]
)
def test_a_run_of_the_command_line_is_stopped_and_continued_as_it_says(small, tmp_path, number, code):
    folder, output = tmp_path / "a run", tmp_path / "output"
    child = command_line(["run", small, "--out", folder, "--device", "cpu", "--resume"], output)
    wait_for((folder / "checkpoint.npz").exists)
    os.kill(child, number)
    assert ended(child) == code
    said = output.read_text()
    assert f"nothing to continue from in {folder}: starting anew\n" in said
    assert "Traceback" not in said and "stopped at t = " in said and not (folder / "animation.usdc").exists()
    if number != signal.SIGTERM:
        return
    command = shlex.split(said[said.index("warp-rods run") : said.index("--resume", said.index("warp-rods run")) + 8])
    assert ended(command_line(command[1:], output)) == 0, output.read_text()
    assert (folder / "animation.usdc").is_file()
    assert ended(command_line(["run", small, "--out", tmp_path / "whole", "--device", "cpu"], output)) == 0
    same(folder, tmp_path / "whole")


def test_a_second_signal_kills_the_command_line_at_once(small, tmp_path):
    def slow() -> None:
        runner.leave = lambda *_: time.sleep(60)

    child = command_line(["run", small, "--out", tmp_path / "run", "--device", "cpu"], tmp_path / "output", slow)
    wait_for((tmp_path / "run" / "checkpoint.npz").exists)
    os.kill(child, signal.SIGTERM)
    time.sleep(0.3)
    begun = time.monotonic()
    os.kill(child, signal.SIGTERM)
    assert ended(child) == -signal.SIGTERM and time.monotonic() - begun < 10


@pytest.mark.parametrize("phase", ["placing", "exporting"])
def test_a_signal_outside_the_steps_ends_with_one_line(small, tmp_path, phase):
    """Nothing is written while rods are placed; a run whose animation is not made is complete."""
    output, folder = tmp_path / "output", tmp_path / "run"

    def slow(*_arguments, **_named) -> None:
        try:
            (folder / ".animation.partial.usdc").touch() if phase == "exporting" else None
            (tmp_path / "there").touch()
            time.sleep(60)
        finally:
            (folder / ".animation.partial.usdc").unlink(missing_ok=True)

    def before() -> None:
        from warp_rods import workflow

        if phase == "placing":
            Simulation.warm_up = slow
        else:
            workflow.export_usd = slow

    small.write_text(TEXT.replace("0.2", "0.01").replace("0.1", "0.01"))
    child = command_line(["run", small, "--out", folder, "--device", "cpu"], output, before)
    wait_for((tmp_path / "there").exists)
    os.kill(child, signal.SIGTERM)
    assert ended(child) == 143
    said = output.read_text()
    assert "Traceback" not in said and said.splitlines()[-1] == "stopped by SIGTERM"
    if phase == "placing":
        assert not folder.exists()
    else:
        assert f"warp-rods export {folder} --usd\n" in said
        assert {file.name for file in folder.iterdir()} - {".lock"} == {
            "scene.toml",
            "checkpoint.npz",
            "trajectory.zarr",
        }


@pytest.mark.long
def test_an_installed_command_is_stopped_by_a_signal(small, tmp_path):
    """Everything real: another interpreter, its start, and a signal from outside."""
    command = [sys.executable, "-m", "warp_rods", "run", small, "--out", tmp_path / "run", "--device", "cpu"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for((tmp_path / "run" / "checkpoint.npz").exists)
    process.terminate()
    out, error = process.communicate(timeout=120)
    assert process.returncode == 143 and "Traceback" not in out + error and "--resume continues from t = " in out


def test_interrupted_is_no_error_that_others_catch():
    assert not issubclass(Interrupted, Exception) and Interrupted(signal.SIGTERM).code == 143
