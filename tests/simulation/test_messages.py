"""Messages of a run: in order on the run, and in the attributes of the trajectory however the run ends."""

import pytest

from warp_rods.errors import RodFailure, SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.hooks import every
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.runner import simulate
from warp_rods.workflow import run

CELL = {"name": "cell", "count": 2, "nodes": 17, "bend": 5e-3, "twist": 1e-3}
SCENE = Scene(swimmers=[CELL], time={"end": 0.05, "step": 1e-3, "save_every": 0.01})


def kept(folder) -> list[str]:
    return open_run(folder).attrs["messages"]


def test_a_run_that_loses_all_rods_says_so(tmp_path):
    soft = CELL | {"bend": 1e-6, "twist": 1e-5, "moment": 5.0}
    scene = Scene(swimmers=[soft], time={"end": 3.0, "step": 0.05, "save_every": 0.5})
    with pytest.raises(RodFailure):
        simulate(scene, tmp_path, device="cpu")
    assert "error: ended at t = " in kept(tmp_path)[-1] and "cell: rod 1" in kept(tmp_path)[-1]


@pytest.mark.parametrize(
    ("error", "said"), [(KeyboardInterrupt, "stopped at t = 0.025; "), (ZeroDivisionError, "by ZeroDivisionError")]
)
def test_a_run_that_is_interrupted_says_so(tmp_path, error, said):
    """By the user, or by an exception in a hook."""

    def hook(simulation):
        if simulation.now > 0.024:
            raise error

    with pytest.raises(error):
        simulate(SCENE, tmp_path, device="cpu", hooks=[(every(steps=5), hook)])
    assert said in kept(tmp_path)[-1]
    done = simulate(SCENE, tmp_path, device="cpu", resume=True)
    assert kept(tmp_path)[-len(done.messages) :] == done.messages and len(kept(tmp_path)) > len(done.messages)


def test_the_animation_is_among_the_messages(tmp_path):
    done = run(SCENE, tmp_path, device="cpu")
    assert done.messages[-1].startswith(f"animation: {tmp_path / 'animation.usdc'}")
    assert kept(tmp_path) == done.messages


def test_paths_are_checked(tmp_path):
    with pytest.raises(SceneError, match="out = 5: must be a path"):
        run(SCENE, out=5)
    with pytest.raises(SceneError, match="run_dir = 5: must be a path"):
        open_run(5)
