"""Rods that fail: the others go on, the run says how many were lost and why, and ends with exit code 3."""

import logging
import re
import subprocess
import sys

import numpy as np
import pytest
import warp as wp
from examples.free import in_space
from examples.losses import DOOMED, SOUND, scene

from warp_rods.errors import RodFailure
from warp_rods.rods.ensemble import Failure
from warp_rods.rods.status import Status
from warp_rods.rods.tiles import Tiled
from warp_rods.scene.scene import Scene
from warp_rods.simulation import losses
from warp_rods.simulation.check import check_run
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.runner import simulate


def test_others_go_on_to_the_same_bits(tmp_path):
    """Beside a rod that fails, and beside one that does not."""
    lossy = simulate(scene(SOUND, DOOMED, SOUND | {"bend": 1e-3}), tmp_path / "lossy", device="cpu")
    sound = simulate(scene(SOUND, SOUND, SOUND | {"bend": 1e-3}), tmp_path / "sound", device="cpu")
    one, other = lossy.data["cells"], sound.data["cells"]
    assert one.status[-1].values.tolist() == [Status.OK, Status.TOO_BENT, Status.OK]
    for name, values in one.data_vars.items():
        if "rod" in values.dims:
            np.testing.assert_array_equal(values.isel(rod=[0, 2]), other[name].isel(rod=[0, 2]), err_msg=str(name))
    assert len(lossy.lost) == 1 and not sound.lost
    (said,) = (line for line in lossy.messages if "lost in all" in line)
    assert "cells: 1 of 3 rods, at t = 0.0" in said and "(rod 1)" in said and "others are not affected" in said


def test_a_run_can_end_at_the_first_loss_and_go_on_later(tmp_path):
    """on_failure = "stop" ends it at the next frame; resumed with "continue" it has the bits of one that went on."""
    stopped = simulate(scene(SOUND, DOOMED, on_failure="stop"), tmp_path / "a", device="cpu")
    assert stopped.data["cells"].sizes["frame"] == 2 and len(stopped.lost) == 1
    assert any('on_failure = "continue"' in line for line in stopped.messages)
    again = simulate(scene(SOUND, DOOMED, on_failure="stop"), tmp_path / "a", device="cpu", resume=True)
    assert again.data["cells"].sizes["frame"] == 2 and len(again.lost) == 1
    assert not any("already finished" in line for line in again.messages)
    on = simulate(scene(SOUND, DOOMED, on_failure="continue"), tmp_path / "a", device="cpu", resume=True)
    whole = simulate(scene(SOUND, DOOMED), tmp_path / "b", device="cpu")
    np.testing.assert_array_equal(on.data["cells"].position, whole.data["cells"].position)
    assert len(on.lost) == 1
    assert sum("lost: cells: rod 1" in line for line in on.data.attrs["messages"]) == 1  # and not after each resume
    assert check_run(tmp_path / "a").endswith("no damage; 1 of cells were lost")


def test_a_run_that_loses_nothing_does_not_stop(tmp_path):
    run = simulate(scene(SOUND, SOUND, on_failure="stop"), tmp_path, device="cpu")
    assert run.data["cells"].sizes["frame"] == 5 and not run.lost


class Failing:
    """The part of an ensemble that is asked about failures; rods fail in their order, every second one differently."""

    count = 100

    def __init__(self) -> None:
        self.frozen = 0

    @property
    def status(self) -> np.ndarray:
        return np.where(np.arange(self.count) < self.frozen, Status.TOO_BENT, Status.OK)

    def failures(self) -> list[Failure]:
        words = (Status.TOO_BENT.words, Status.NOT_FINITE.words)
        return [Failure(rod, 0.1 * rod, words[rod % 2]) for rod in range(self.frozen)]

    def parameters(self, rod: int) -> dict:
        return {"bend": rod}


def test_many_losses_are_summarised():
    """Five get a line each; then the run tells when their number has doubled."""
    rods, said = Failing(), losses.Losses()
    lengths = {}
    for rods.frozen in (0, 2, 5, 6, 9, 10, 19, 20, 20, 90):
        lengths[rods.frozen] = lengths.get(rods.frozen, 0) + len(lines := said.check({"cells": rods}))
    assert lengths == {0: 0, 2: 2, 5: 3, 6: 0, 9: 0, 10: 1, 19: 0, 20: 1, 90: 1}
    assert lines[0].startswith("cells: 90 of 100 rods, between t = 0 and 8.9: 45 bent by more than half a turn")
    assert "; 45 became non-finite (rods 1, 3, 5, 7, 9, 11, 13, 15, …)" in lines[0]
    rods.frozen = 91  # too few more for a line, but all of them are told where no rod is left
    assert said.check({"cells": rods}) == [] and losses.in_all({"cells": rods})[0].startswith("cells: 91 of 100 rods")
    rods.frozen = 5
    assert len(losses.in_all({"cells": rods})) == 5
    rods.frozen = 90
    assert len(losses.lines({"cells": rods})) == losses.frozen({"cells": rods}) == 90


def test_a_run_that_loses_hundreds_of_rods_stays_readable(tmp_path, caplog):
    with caplog.at_level(logging.WARNING, "warp_rods"):
        run = simulate(scene(SOUND, *[DOOMED] * 300), tmp_path, device="cpu")
    assert len(run.lost) == 300 and len(caplog.messages) <= 8
    assert all(len(line) < 500 for line in caplog.messages)


@pytest.mark.parametrize(("cells", "code", "said"), [((SOUND, DOOMED), 3, "1 of 2 rods"), ((SOUND, SOUND), 0, "")])
def test_the_exit_code_says_whether_rods_were_lost(tmp_path, cells, code, said):
    path = tmp_path / "scene.toml"
    path.write_text(scene(*cells, output={"usd": False}).to_toml())
    command = [sys.executable, "-m", "warp_rods", "run", path, "--out", tmp_path / "run", "--device", "cpu"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=300)
    assert done.returncode == code, done.stderr
    assert said in done.stdout and ("lost" in done.stdout) == bool(code)


def test_a_run_that_loses_all_rods_has_that_exit_code_too(tmp_path):
    with pytest.raises(RodFailure, match="No rod is left") as caught:
        simulate(scene(DOOMED, DOOMED), tmp_path, device="cpu")
    assert caught.value.exit_code == 3
    assert "rod 0 bent" in str(caught.value) and "rod 1 bent" in str(caught.value)
    assert open_run(tmp_path)["cells"].status[-1].values.tolist() == [Status.TOO_BENT] * 2


@wp.func
def noise(x: wp.vec3d, tangent: wp.vec3d, t: wp.float64):
    """A huge force that has another value at every time, on rods at x > 5."""
    size = wp.where(x[0] > wp.float64(5.0), wp.float64(1e30), wp.float64(0.0))
    return wp.vec3d(wp.float64(0.0), size * wp.cos(wp.float64(1e31) * t), wp.float64(0.0))


def test_a_rod_that_no_step_can_follow_is_frozen_and_the_others_go_on(device):
    """In steps that rods take together; the error of one stays too large even in the shortest step."""
    rods = in_space(device, nodes=33, count=2, external=noise, position=[[0, 0, 0], [10, 0, 0]])
    alone = in_space(device, nodes=33, count=1, external=noise)
    rods.advance_to(0.01)
    alone.advance_to(0.01)
    assert rods.status.tolist() == [Status.OK, Status.UNRESOLVED]
    assert re.match("changed too fast to be followed", rods.failures()[0].what)
    np.testing.assert_allclose(rods.strain[0], alone.strain[0], rtol=0, atol=1e-4)


def test_a_rod_that_was_frozen_does_not_push_the_others():
    """A cell beside one that fails drifts away as long as that lives; then it moves like a cell alone."""
    place = {"position": [[0, 0, 0], [0, 0.06, 0]], "direction": [[1, 0, 0]] * 2}
    kind = {"name": "c", "count": 2, "nodes": 17, "twist": 1e-3, "flagella": {"profile": "uniform"}}
    kind |= {"shape": {"kind": "straight"}, "placement": place, "bend": [5e-3, 5e-3]}
    steric = {"strength": 1e-3, "range": 0.03, "core": 0.07}
    time = {"end": 0.2, "save_every": 0.1}
    simulation = Simulation(Scene(swimmers=[kind], steric=steric, time=time), "cpu")
    cells = simulation.ensembles["c"]
    first = simulation.variables()["c"]["steric_energy"]
    assert first.min() > 0 and np.linalg.norm(cells.force[0]) > 0
    Tiled(cells._arrays.rods.moment, 2).assign(np.array([0.0, np.nan]))
    for _ in simulation.to_next_frame():
        pass
    found = simulation.variables()["c"]
    assert found["status"].tolist() == [Status.OK, Status.NOT_FINITE]
    assert not found["steric_energy"].any() and not cells.force[0].any()
    before = found["position"][0]
    for _ in simulation.to_next_frame():
        pass
    moved = simulation.variables()["c"]["position"][0] - before
    assert np.abs(moved[:, 1:]).max() < 1e-9  # straight on, along x
