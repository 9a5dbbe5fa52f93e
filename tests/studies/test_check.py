"""What ``warp-rods check`` and the beginning of a sweep say of a study, before any point is simulated."""

import re
import tomllib
from types import SimpleNamespace

import pytest
from examples.study import CELL, cells, sensors
from pages.blocks import ROOT, blocks_of
from typer.testing import CliRunner

import warp_rods as wr
from warp_rods import cli
from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation
from warp_rods.studies import begin
from warp_rods.studies.check import check_study
from warp_rods.studies.plan import Plan
from warp_rods.studies.probes import IDLE_SEEDS, probe, seeds_are_idle


def checked(scene: Scene, folder) -> tuple[str, list[str]]:
    (folder / "scene.toml").write_text(scene.to_toml())
    return check_study(folder / "scene.toml")


@pytest.mark.parametrize(
    ("measure", "swept", "end", "warned"),
    [
        (["speed", "modes"], {"swimmers.cell.bend": [1e-3]}, 0.5, True),
        (["speed"], {"time.end": [1.0, 0.3, 2.0]}, 1.0, True),
        (["speed"], {"swimmers.cell.bend": [1e-3]}, 1.2, False),
    ],
)
def test_the_check_warns_of_too_few_frames(tmp_path, measure, swept, end, warned):
    scene = Scene.parse({"swimmers": [CELL], "time": {"end": end, "save_every": 0.1},
                         "sweep": {**swept, "measure": measure}})  # fmt: skip
    about, said = checked(scene, tmp_path)
    few = [line for line in said if "give time.save_every = time.end/12 or less" in line]
    assert bool(few) == warned and "a study of" in about
    if warned:
        assert few[0].startswith(f"{', '.join(measure)} assume")


def test_the_example_of_the_page_begins_and_is_warned_of_nothing(tmp_path):
    block = next(block for block in blocks_of(ROOT / "docs" / "studies.md") if block.language == "toml")
    scene = Scene.parse(tomllib.loads(block.text))
    _, warnings = checked(scene, tmp_path)
    assert warnings == [] and Simulation(Plan(scene).scene_at((0, 0, 0)), "cpu").warnings == []


def test_too_few_frames_for_a_measure_name_it_and_the_key(tmp_path):
    scene = cells(time={"end": 4.0, "save_every": 0.5})
    why = (
        'sweep.measure[1] = "class": needs 6 frames or more, equally spaced in time, after 2; there are 5; '
        "time.save_every = 0.5 gives 9 in all: give a smaller one"
    )
    with pytest.raises(SceneError, match=re.escape(why)):
        checked(scene, tmp_path)
    with pytest.raises(SceneError, match=re.escape(why)):
        wr.sweep(scene, tmp_path / "study", device="cpu", part=(1, 1))


STRAIGHT = CELL | {"shape": {"mode": 0, "amplitude": 3.0}}
IDLE = [
    ({"swimmers": [STRAIGHT]}, {}, True),
    ({"swimmers": [STRAIGHT]}, {"seeds": 1}, False),
    ({}, {}, False),
    ({"swimmers": [STRAIGHT]}, {"swimmers.cell.shape.perturbation": [0.0, 0.1]}, False),
    ({"swimmers": [STRAIGHT | {"flagella": {"law": "driven"}, "behaviour": {"reversal": {"rate": 1.0}}}]}, {}, False),
]


@pytest.mark.parametrize(("tables", "swept", "idle"), IDLE)
def test_seeds_that_change_nothing_are_told(tables, swept, idle):
    plan = Plan(cells(swept, **{"swimmers": [CELL]} | tables))
    assert seeds_are_idle(plan, Simulation(plan.scene_at((0,) * len(plan.axes)), "cpu")) == idle


def test_seeds_that_place_filaments_change_something_and_a_sweep_tells_of_others(tmp_path):
    plan = Plan(sensors())
    assert not seeds_are_idle(plan, Simulation(plan.scene_at((0, 0)), "cpu"))
    scene = cells({"swimmers.cell.moment": [0.0]}, swimmers=[STRAIGHT])
    study = wr.sweep(scene, tmp_path / "study", device="cpu", part=(1, 1))
    assert f"warning: {IDLE_SEEDS}" in study.messages and IDLE_SEEDS in checked(scene, tmp_path)[1]


def test_too_few_nodes_at_an_end_of_the_grid_are_told_with_the_point(tmp_path):
    """Once, at the point that asks for most, and not where the scene itself has the same warning."""
    bend = {"swimmers.cell.bend": {"from": 1e-4, "to": 1e-2, "num": 5}, "swimmers.cell.moment": [0.0, 1e-3]}
    _, said = checked(cells(bend), tmp_path)
    (line,) = [line for line in said if "nodes" in line]
    assert "swimmers.cell.bend = 0.0001" in line.partition(": ")[0] and "use 153 nodes" in line
    assert not [line for line in checked(cells({"swimmers.cell.bend": [CELL["bend"]]}), tmp_path)[1] if "nodes" in line]


def test_the_command_shows_faults_before_anything_and_counts_warnings_of_the_study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.toml").write_text(cells({"measure": ["sped"]}).to_toml())
    done = CliRunner().invoke(cli.app, ["check", "bad.toml"])
    assert isinstance(done.exception, SceneError) and not done.output
    (tmp_path / "idle.toml").write_text(cells({"measure": ["period"]}, swimmers=[STRAIGHT]).to_toml())
    said = CliRunner().invoke(cli.app, ["check", "idle.toml"]).output
    assert f"warning: {IDLE_SEEDS}" in said and "no problems" not in said
    assert "a study of 24 points (3 swimmers.cell.moment × 4 swimmers.cell.bend × 2 seeds), for" in said


def test_a_probe_finds_the_dimensions_of_all_measures():
    plan = Plan(cells())
    found = probe(plan, Simulation(plan.scene_at((0, 0, 0)), "cpu"))
    assert {name: values.dims[1:] for name, values in found.items()} == {
        "speed": (), "class": (), "modes": ("component", "mode")
    }  # fmt: skip


def test_numbers_in_place_of_a_list_may_be_meant_for_one_of_its_components():
    swept = {"filaments.sensors.intrinsic": [0.0, 1.0], "measure": ["gauss"]}
    tables = tomllib.loads(sensors().to_toml())
    scene = Scene.parse(tables | {"sweep": swept})
    with pytest.raises(SceneError, match=r"did you mean filaments\.sensors\.intrinsic\.1\?"):
        Plan(scene).check()


def test_the_time_left_follows_from_the_last_steps_that_were_tried(monkeypatch):
    """Of steps of a second each that become longer: half-way to the end an average would be twice too slow."""

    class Growing:
        now, steps = 0.0, 0
        scene = SimpleNamespace(time=SimpleNamespace(end=100.0**2))

        def advance(self):
            while self.now < self.scene.time.end:
                self.steps += 1
                self.now = float(self.steps**2)
                yield

    simulation = Growing()
    monkeypatch.setattr(begin, "Record", lambda *_: None)
    monkeypatch.setattr(begin, "BUDGET", 50.0)
    monkeypatch.setattr(begin.time, "perf_counter", lambda: float(simulation.steps))
    assert begin._tried(simulation) == pytest.approx(51 + (100**2 - 51**2) / (51 + 46), rel=0.02)
