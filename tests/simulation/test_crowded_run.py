"""A dense swarm in a film: nothing passes through anything, nothing is lost, nothing leaves; and a run resumed."""

import numpy as np
import pytest
import xarray as xr

from warp_rods.analysis.crossings import crossings
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.trajectory import open_run

KIND = {
    "count": 30, "nodes": 17, "twist": 1e-3, "flagella": {"profile": "uniform"}, "shape": {"kind": "straight"},
}  # fmt: skip
FILM = {"kind": "slab", "height": 0.12, "fraction": 0.3}
STERIC = {"strength": 2000.0, "range": 0.02, "core": 0.08}


def film(end=2.0, step=5e-4, every=0.02, strength=2000.0, **changes) -> Scene:
    """Soft and stiff cells that fill 0.3 of a film too low for two to lie on each other."""
    tables = {
        "swimmers": [{**KIND, "name": "soft", "bend": 1e-3}, {**KIND, "name": "stiff", "bend": 2e-2}],
        "box": FILM, "steric": {**STERIC, "strength": strength},
        "time": {"end": end, "step": step, "save_every": every},
    }  # fmt: skip
    return Scene.parse(tables | changes)


def followed(scene: Scene) -> tuple[Simulation, xr.Dataset]:
    """All cells of a run in one group."""
    simulation, frames = Simulation(scene, "cpu"), []
    while True:
        values = simulation.variables().values()
        frames.append({name: np.concatenate([v[name] for v in values]) for name in ("position", "status")})
        if simulation.frame == len(simulation.frames.times) - 1:
            break
        for _ in simulation.to_next_frame():
            pass
    position, status = (np.array([f[name] for f in frames]) for name in ("position", "status"))
    rods, period = position.shape[1], np.array(scene.period)
    return simulation, xr.Dataset(
        {
            "position": (("frame", "rod", "node", "axis"), position), "status": (("frame", "rod"), status),
            "length": ("rod", np.ones(rods)), "period": ("axis", np.where(period > 0, period, np.inf)),
        },
        coords={"time": ("frame", simulation.frames.times), "rod": np.arange(rods)},
    )  # fmt: skip


def seen_from_above(data: xr.Dataset) -> xr.Dataset:
    """The film as a plane: there rods that lie on each other cross."""
    return data.assign(position=data["position"] * np.array([1.0, 1.0, 0.0]))


def test_a_dense_swarm_stays_in_its_film_and_out_of_each_other():
    simulation, data = followed(film())
    assert int(crossings(data)["crossings"].sum()) == 0
    assert int(crossings(seen_from_above(data))["crossings"].sum()) == 0
    assert not data["status"].any() and not simulation.contact.unresolved
    assert np.abs(data["position"][..., 2]).max() < FILM["height"] / 2
    way = np.linalg.norm(data["position"][-1, :, 8] - data["position"][0, :, 8], axis=-1)
    assert np.median(way) > 0.2  # they do swim


def test_without_sterics_they_pass_through_each_other():
    _, data = followed(film(end=0.4, strength=0.0))
    assert int(crossings(seen_from_above(data))["crossings"].sum()) > 20


def test_a_swarm_that_was_stopped_goes_on_to_the_same_bits(tmp_path, monkeypatch):
    """With long steps, cut by contact, and interrupted within the steps from one frame to the next."""
    scene = film(end=0.2, step=4e-3)
    whole = runner.simulate(scene, tmp_path / "whole", device="cpu").data
    monkeypatch.setattr(runner, "CHECKPOINT_EVERY", 0.0)
    real, calls = Simulation.to_next_frame, []

    def interrupted(self):
        calls.append(self.frame)
        for done in real(self):
            if len(calls) == 4:
                raise KeyboardInterrupt
            yield done

    with monkeypatch.context() as m:
        m.setattr(Simulation, "to_next_frame", interrupted)
        with pytest.raises(KeyboardInterrupt):
            runner.simulate(scene, tmp_path / "stopped", device="cpu")
    assert open_run(tmp_path / "stopped")["soft"].sizes["frame"] == 4
    assert int(np.load(tmp_path / "stopped" / "checkpoint.npz")["parts"]) > 1
    again = runner.simulate(scene, tmp_path / "stopped", device="cpu", resume=True).data
    for name in ("soft", "stiff"):
        for variable in ("position", "activity", "steric_energy", "wall_energy"):
            np.testing.assert_array_equal(again[name][variable], whole[name][variable])


VOLUME = {"kind": "periodic", "size": [2.0, 2.0, 2.0]}
ONE = {**KIND, "name": "one", "bend": 1e-2}


@pytest.mark.parametrize(
    "changes",
    [
        {"steric": None},
        {"steric": {**STERIC, "strength": 0.0}},
        {"box": VOLUME},
        {"box": VOLUME, "steric": None},
        {"box": {**VOLUME, "size": [0.9, 0.9, 0.9]}, "swimmers": [{**ONE, "count": 3}]},
        {"time": {"end": 0.01, "step": 5e-4, "save_every": 5e-4}},
        {"box": VOLUME, "steric": None, "swimmers": [{**ONE, "symmetric": True, "flagella": {}}]},
        {"box": None, "steric": None},
        {"swimmers": [ONE, {**ONE, "name": "fine", "nodes": 33}]},
    ],
    ids=["walls", "no strength", "volume", "no forces", "short periods", "every step", "symmetric", "open", "nodes"],
)
def test_every_mixture_runs(changes, tmp_path):
    """Energies are there where there are forces to have them, and nowhere else."""
    tables = {
        "swimmers": [{**ONE, "name": "soft", "bend": 1e-3}, {**ONE, "name": "stiff", "bend": 2e-2}],
        "box": {"kind": "slab", "height": 0.12, "size": [4.0, 4.0]}, "steric": STERIC,
        "time": {"end": 0.01, "step": 5e-4, "save_every": 5e-3},
    } | changes  # fmt: skip
    tables = {key: value for key, value in tables.items() if value is not None}
    run = runner.simulate(Scene.parse(tables), tmp_path / "run", device="cpu")
    assert not run.lost
    felt = {"steric_energy": 0.0, "wall_energy": 0.0}
    for group in run.data.children.values():
        assert not group["status"].any() and np.isfinite(group["position"]).all()
        felt = {name: so_far + float(group[name].sum()) for name, so_far in felt.items()}
    assert (felt["steric_energy"] > 0) == (tables.get("steric", {}).get("strength", 0) > 0)
    assert (felt["wall_energy"] > 0) <= (tables.get("box", {}).get("kind") == "slab")


def test_a_rod_that_is_lost_stands_in_the_way_and_others_go_on():
    """It keeps its last sound place, and is felt there; one whose place is no number is felt by none."""
    for broken in ("rods", "now"):
        simulation = Simulation(film(end=0.1, every=0.05), "cpu")
        soft = simulation.ensembles["soft"]
        array = soft._arrays.rods.bending_stiffness if broken == "rods" else soft._arrays.now.bending
        values = array.numpy()
        values[3] = np.nan
        array.assign(values)
        for _ in simulation.to_next_frame():
            pass
        (line,) = simulation.new_failures()
        assert "soft: rod 3 became non-finite" in line
        found = simulation.variables()
        assert found["soft"]["status"].sum() == 1 and not found["stiff"]["status"].any()
        sound = np.arange(30) != 3
        for name, rods in (("soft", sound), ("stiff", slice(None))):
            for variable in ("position", "steric_energy", "strain"):
                assert np.isfinite(found[name][variable][rods]).all()
        assert np.isfinite(found["soft"]["position"][3]).all() == (broken == "rods")
