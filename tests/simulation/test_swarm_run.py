"""A dense swarm in a film: no rod passes through another, fails or leaves the film; a resumed run."""

import numpy as np
import pytest
import xarray as xr

from warp_rods.analysis.crossings import crossings
from warp_rods.rods.tiles import Tiled
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner, saver
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.reading import open_run

KIND = {
    "count": 30, "nodes": 17, "twist": 1e-3, "flagella": {"profile": "uniform"}, "shape": {"kind": "straight"},
}  # fmt: skip
FILM = {"kind": "slab", "height": 0.12, "fraction": 0.3}
STERIC = {"strength": 2000.0, "range": 0.02, "core": 0.08}


def film(end=2.0, step=5e-4, every=0.02, strength=2000.0, **changes) -> Scene:
    """Soft and stiff cells that fill 0.3 of a film too low for two layers."""
    tables = {
        "swimmers": [{**KIND, "name": "soft", "bend": 1e-3}, {**KIND, "name": "stiff", "bend": 2e-2}],
        "box": FILM, "steric": {**STERIC, "strength": strength},
        "time": {"end": end, "step": step, "save_every": every},
    }  # fmt: skip
    return Scene.parse(tables | changes)


def followed(scene: Scene) -> tuple[Simulation, xr.Dataset]:
    """A finished simulation, and all of its cells in one group."""
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


def projected(data: xr.Dataset) -> xr.Dataset:
    """The film projected onto its plane, where rods that lie on each other cross."""
    return data.assign(position=data["position"] * np.array([1.0, 1.0, 0.0]))


@pytest.mark.long
def test_cells_of_a_dense_swarm_stay_in_the_film_and_do_not_cross(verified):
    simulation, data = followed(film())
    found = [int(crossings(one)["crossings"].sum()) for one in (data, projected(data))]
    verified(
        "constraint", "dense swarm in a film: crossings, in space and projected", measured=found, expected=0, within=0,
        reference="rods do not pass through each other",
    )  # fmt: skip
    assert not data["status"].any() and not simulation.together.unresolved
    assert np.abs(data["position"][..., 2]).max() < FILM["height"] / 2
    displacement = np.linalg.norm(data["position"][-1, :, 8] - data["position"][0, :, 8], axis=-1)
    assert np.median(displacement) > 0.2  # the cells swim


def test_without_steric_forces_cells_pass_through_each_other():
    _, data = followed(film(end=0.4, strength=0.0))
    assert int(crossings(projected(data))["crossings"].sum()) > 20


def test_an_interrupted_swarm_resumes_with_the_same_bits(tmp_path, monkeypatch):
    """With long steps that contact divides, interrupted between two frames."""
    scene = film(end=0.2, step=4e-3)
    whole = runner.simulate(scene, tmp_path / "whole", device="cpu").data
    monkeypatch.setattr(saver, "CHECKPOINT_EVERY", 0.0)
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
def test_every_combination_of_forces_runs(changes, tmp_path):
    """Steric and wall energies differ from zero only with the corresponding forces."""
    tables = {
        "swimmers": [{**ONE, "name": "soft", "bend": 1e-3}, {**ONE, "name": "stiff", "bend": 2e-2}],
        "box": {"kind": "slab", "height": 0.12, "size": [4.0, 4.0]}, "steric": STERIC,
        "time": {"end": 0.01, "step": 5e-4, "save_every": 5e-3},
    } | changes  # fmt: skip
    tables = {key: value for key, value in tables.items() if value is not None}
    run = runner.simulate(Scene.parse(tables), tmp_path / "run", device="cpu")
    assert not run.lost
    energies = {"steric_energy": 0.0, "wall_energy": 0.0}
    for group in run.data.children.values():
        assert not group["status"].any() and np.isfinite(group["position"]).all()
        energies = {name: total + float(group[name].sum()) for name, total in energies.items()}
    assert (energies["steric_energy"] > 0) == (tables.get("steric", {}).get("strength", 0) > 0)
    assert (energies["wall_energy"] > 0) <= (tables.get("box", {}).get("kind") == "slab")


def test_the_others_continue_without_a_frozen_rod():
    """Whether its parameters or its state were broken."""
    for broken in ("rods", "now"):
        simulation = Simulation(film(end=0.1, every=0.05), "cpu")
        soft = simulation.ensembles["soft"]
        field = soft._arrays.rods.bending_stiffness if broken == "rods" else soft._arrays.now.bending
        array = Tiled(field, soft.count)
        values = array.numpy()
        values[3] = np.nan
        array.assign(values)
        for _ in simulation.to_next_frame():
            pass
        (line,) = simulation.new_failures()
        assert "soft: rod 3 became non-finite" in line
        found = simulation.variables()
        assert found["soft"]["status"].sum() == 1 and not found["stiff"]["status"].any()
        valid = np.arange(30) != 3
        for name, rods in (("soft", valid), ("stiff", slice(None))):
            for variable in ("position", "steric_energy", "strain"):
                assert np.isfinite(found[name][variable][rods]).all()
        assert np.isfinite(found["soft"]["position"][3]).all() == (broken == "rods")
