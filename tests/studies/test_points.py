"""A point has the same bits by itself, as a rod of any batch, and as a run from its own scene."""

from dataclasses import replace

import numpy as np
import pytest
from examples.study import CELL, SENSOR, TIME, cells, sensors

from warp_rods.analysis.registry import MEASURES
from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation
from warp_rods.studies.batches import batch_tables, why_not
from warp_rods.studies.columns import columns_of
from warp_rods.studies.plan import Plan
from warp_rods.studies.points import as_rods, assumes, each_alone, measured, taken
from warp_rods.studies.record import Record, still
from warp_rods.studies.store import COMPUTED, LOST
from warp_rods.studies.tasks import _batch


def same(one: np.ndarray, other: np.ndarray) -> None:
    assert one.dtype == other.dtype
    np.testing.assert_array_equal(one, other)


POINTS = {
    "swimmers": (cells, [(0, 2, 1), (3, 0, 0), (2, 1, 1), (3, 2, 0), (1, 1, 0), (0, 0, 0), (0, 0, 1), (2, 2, 0)]),
    "filaments": (sensors, [(1, 0), (0, 0), (1, 1)]),
}  # fmt: skip


@pytest.mark.parametrize("kind", POINTS)
def test_a_point_has_the_same_bits_alone_and_in_any_batch(kind):
    """Starts at random, measures and what they are made of: the seed belongs to the point, not to its place."""
    scene, points = POINTS[kind]
    plan = Plan(scene())
    together, turned = as_rods(plan, points, "cpu"), as_rods(plan, points[::-1], "cpu")
    assert (together.values["state"] == COMPUTED).all()
    for name, values in together.values.items():
        same(values, turned.values[name][::-1])
    for alone in each_alone(plan, points[-1:], "cpu"):
        for name, values in alone.values.items():
            same(values[0:1], together.values[name][-1:])


@pytest.mark.parametrize("kind", POINTS)
def test_rods_of_a_batch_move_as_in_the_scenes_of_their_points(kind):
    scene, points = POINTS[kind]
    plan, name = Plan(scene()), "cell" if kind == "swimmers" else "sensors"

    def moved(one: Scene, seeds=()) -> np.ndarray:
        simulation = Simulation(one, "cpu", seeds=seeds)
        assert simulation.own_steps
        for _ in simulation.to_next_frame():
            pass
        return simulation.ensembles[name].position

    batch = Scene.parse(batch_tables([plan.tables_at(point) for point in points]))
    whole = moved(batch, [plan.axes[-1].values[point[-1]] for point in points])
    count = len(whole) // len(points)
    for number in (0, len(points) - 1):
        same(whole[number * count : (number + 1) * count], moved(plan.scene_at(points[number])))
    starts = {tuple(whole[i * count].ravel()[:3]) for i in range(len(points))}
    assert len(starts) > 1


def test_what_every_rod_has_for_itself_goes_into_a_batch():
    cell = CELL | {"count": 2, "bend": [1e-3, 2e-3], "placement": {"position": [[0, 0, 0], [1, 0, 0]]}}
    sweep = {"swimmers.cell.flagella.diffusion": [1e-3, 2e-3], "measure": ["speed"]}
    plan = Plan(Scene.parse({"swimmers": [cell], "time": TIME, "sweep": sweep}))
    table = Scene.parse(batch_tables([plan.tables_at((i, 0)) for i in (0, 1)])).swimmers[0]
    assert table.count == 4 and table.bend == (1e-3, 2e-3, 1e-3, 2e-3) and table.twist == CELL["twist"]
    assert table.flagella.diffusion == (1e-3, 1e-3, 2e-3, 2e-3)
    assert table.placement.position == ((0, 0, 0), (1, 0, 0)) * 2
    vectors = Plan(sensors(**{"filaments.sensors.intrinsic.1": [0.0, 1.0], "filaments.sensors.length": [0.4, 0.5]}))
    table = Scene.parse(batch_tables([vectors.tables_at((i, i, 0)) for i in (0, 1)])).filaments[0]
    assert table.intrinsic == ((0, 0, 0), (0, 0, 0), (0, 1, 0), (0, 1, 0)) and table.length == (0.4, 0.4, 0.5, 0.5)
    assert table.stiffness == tuple(SENSOR["stiffness"])


ALONE = {
    "is not a value of single rods": {"sweep": {"time.tolerance": [0.01, 0.02], "measure": ["speed"]}},
    "rods take their steps together": {"time": TIME | {"step": 1e-3}},
    '"auto", depends on the point': {"swimmers": [CELL | {"nodes": "auto"}]},
}


@pytest.mark.parametrize("reason", ALONE)
def test_points_that_cannot_be_rods_of_a_batch_are_simulated_alone(reason):
    sweep = {"swimmers.cell.bend": [1e-3, 2e-3], "measure": ["speed"]}
    plan = Plan(Scene.parse({"swimmers": [CELL], "time": TIME, "sweep": sweep, **ALONE[reason]}))
    assert reason in why_not(plan.scene, plan.paths, Simulation(plan.scene_at((0, 0)), "cpu"))


def test_warnings_of_a_point_are_in_its_message_alone_and_in_a_batch():
    """17 nodes are few for any swimmer, and how many a soft one needs depends on its stiffness."""
    plan = Plan(cells({"swimmers.cell.bend": [1e-5, 1e-4, 1e-3], "swimmers.cell.moment": [0.0], "measure": ["speed"]}))
    points = [(0, 0, 0), (1, 0, 0), (1, 0, 1), (2, 0, 0)]
    said = as_rods(plan, points, "cpu").values["message"]
    assert all(line.startswith("warning: cell: 17 nodes are") for line in said) and said[1] == said[2]
    assert "β⊥ = 1e-05" in said[0] and "β⊥ = 0.0001" in said[1] and "β⊥" not in said[3]
    assert [one.values["message"][0] for one in each_alone(plan, points, "cpu")] == said.tolist()


def with_columns(scene: Scene) -> Plan:
    """The plan of a study whose store has the measures of the first point."""
    plan = Plan(scene)
    simulation = Simulation(plan.scene_at((0,) * len(plan.axes)), "cpu")
    found = measured(plan, still(simulation), 1, simulation.surfaces["surface"])
    return replace(plan, columns=tuple(columns_of(found, assumes(plan, found))))


def lossy(amplitude: list, **tables) -> Plan:
    """Swimmers over the amplitude of their start; one of 500 bends by more than half a turn from node to node."""
    sweep = {
        "swimmers.cell.shape.amplitude": amplitude,
        "measure": ["speed", "class", "modes", "crossings"],
        "seeds": 1,
    }
    cell = CELL | {"count": len(amplitude[0]) if isinstance(amplitude[0], list) else 1}
    return with_columns(Scene.parse({"swimmers": [cell], "time": TIME, "sweep": sweep, **tables}))


LOSSES = {
    "one of two points": ([3.0, 500.0], {}),
    "all": ([500.0, 600.0], {}),
    "a rod of two, and both": ([[3.0, 500.0], [500.0, 600.0]], {}),
    "a rod of two, where a run stops": ([[3.0, 4.0], [3.0, 500.0]], {"on_failure": "stop"}),
}


@pytest.mark.parametrize("which", LOSSES)
def test_a_point_with_lost_rods_has_the_same_values_alone_and_in_a_batch(which):
    amplitude, tables = LOSSES[which]
    plan = lossy(amplitude, **tables)
    both = as_rods(plan, [(0, 0), (1, 0)], "cpu").values
    assert both["state"][1] == LOST and both["lost"][1] > 0 and both["settled"][1] == -1
    assert np.isnan(both["speed"][1]) and both["class"][1] == "failed" and np.isnan(both["modes"][1]).all()
    for point, alone in enumerate(each_alone(plan, [(0, 0), (1, 0)], "cpu")):
        assert alone.values.keys() == both.keys()
        for name, values in alone.values.items():
            same(values[0:1], both[name][point : point + 1])


def test_a_point_whose_measure_has_other_labels_fails_with_the_reason():
    """The bins of speeds are those of the first point; each point, alone or in a batch, is told why it has none."""
    swept = {"swimmers.cell.bend": [1e-3, 2e-3], "measure": ["speed_distribution"]}
    plan = with_columns(Scene.parse({"swimmers": [CELL], "time": TIME, "sweep": swept}))
    found = list(_batch(plan, ((0, 0), (1, 0)), "cpu"))
    assert [list(one.errors) for one in found] == [[(0, 0)], [(1, 0)]]
    assert "speed_distribution: this point has other values of v, and all points" in found[1].errors[1, 0]


def test_lost_rods_are_told_with_reason_and_do_not_change_the_others():
    """A start that bends by more than half a turn between two nodes fails at once."""
    sweep = {"swimmers.cell.shape.amplitude": [3.0, 500.0], "measure": ["speed", "class"], "seeds": 1}
    plan = Plan(Scene.parse({"swimmers": [CELL], "time": TIME, "sweep": sweep}))
    both, one = as_rods(plan, [(0, 0), (1, 0)], "cpu"), as_rods(plan, [(0, 0)], "cpu")
    assert both.values["state"].tolist() == [COMPUTED, LOST] and both.values["lost"].tolist() == [0, 1]
    assert "cell: rod 0" in both.values["message"][1] and "cell: rod 0" not in both.values["message"][0]
    assert np.isnan(both.values["speed"][1]) and both.values["class"][1] == "failed"
    same(both.values["speed"][:1], one.values["speed"])
    (alone,) = each_alone(plan, [(1, 0)], "cpu")
    assert alone.values["state"][0] == LOST and "cell" in alone.values["message"][0]


@pytest.mark.parametrize("kind", POINTS)
def test_measures_see_all_that_they_see_in_a_run(kind):
    """A study records what its measures need; some take more into account where it is there, as the power of forces."""
    scene = POINTS[kind][0]
    units = {"units": {"length": "1 um", "time": "1 s", "force": "1 pN"}} if kind == "filaments" else {}
    plan = Plan(Scene.parse(scene().model_dump(exclude_none=True) | units))
    simulation = Simulation(plan.scene_at((0,) * len(plan.axes)), "cpu")
    name, ensemble = next(iter(simulation.ensembles.items()))
    whole, parts, compared = Record(simulation, ensemble.saved), {}, 0
    for measure, row in MEASURES.items():
        if row.of in ("rods", kind):
            sweep = plan.sweep.model_copy(update={"measure": (measure,)})
            one = Plan(plan.scene.model_copy(update={"sweep": sweep}))
            parts[measure] = one.wanted[0], Record(simulation, one.needs)
    for _ in simulation.advance():
        pass
    for wanted, record in parts.values():
        surface = simulation.surfaces["surface"]
        try:
            expected = taken(wanted, whole.data(), 1, surface)
        except ValueError:
            with pytest.raises(ValueError):
                taken(wanted, record.data(), 1, surface)
            continue
        for key, values in taken(wanted, record.data(), 1, surface).items():
            np.testing.assert_array_equal(values, expected[key])
            assert values.attrs["units"] == expected[key].attrs["units"]
            compared += 1
    assert compared > 10 and name in ("cell", "sensors")
    assert (
        not units or taken(parts["energy_terms"][0], whole.data(), 1, None)["twist_energy"].attrs["units"] == "1e-12 N"
    )


def test_events_of_a_behaviour_are_those_of_the_scene_of_the_point():
    cell = CELL | {"count": 2, "flagella": {"law": "driven"}, "behaviour": {"reversal": {"rate": 200.0}}}
    table = {"swimmers.cell.bend": [5e-3, 1e-2], "seeds": [4, 9, 12], "measure": ["speed"]}
    plan = Plan(Scene.parse({"swimmers": [cell], "time": TIME, "sweep": table}))
    points = [(bend, seed) for bend in range(2) for seed in range(3)]
    together = as_rods(plan, points, "cpu").values["speed"]
    alone = [next(each_alone(plan, [point], "cpu")).values["speed"][0] for point in points]
    same(together, np.array(alone))
    assert len(set(alone)) == len(alone)


def test_a_simulation_that_was_tried_goes_on_as_if_it_had_not_been():
    """A trial that reaches the end looks at formulas beyond it; the run does not, until it is there."""
    cell = CELL | {"natural_bend": "sin(7*s - t)"}
    scene = Scene.parse({"swimmers": [cell], "time": {"end": 0.3, "save_every": 0.02}, "seed": 3})
    ends = []
    for tried in (False, True):
        simulation = Simulation(scene, "cpu")
        if tried:
            with simulation.trial():
                for _ in simulation.advance():
                    pass
        for _ in simulation.advance():
            pass
        ends.append(simulation.ensembles["cell"].position)
    same(*ends)


def test_measures_have_the_same_values_by_either_of_their_names():
    one, other = (
        as_rods(Plan(cells({"measure": names})), [(0, 0, 0), (3, 2, 1)], "cpu").values
        for names in (["class", "modes"], ["shape_class", "mode_coefficients"])
    )
    same(one["class"], other["shape_class"])
    same(one["modes"], other["mode_coefficients"])


def test_quantities_are_numbers_in_units_of_the_scene():
    units = {"length": "1 um", "time": "1 s", "force": "1 pN"}

    def plan(*values) -> Plan:
        table = {"surface.radius": list(values), "filaments.sensors.length": ["500 nm"], "measure": ["gauss"]}
        scene = sensors().model_dump(exclude_none=True)
        return Plan(Scene.parse(scene | {"units": units, "sweep": table}))

    assert plan("900 nm", "1.1 um", 2.0).axes[0].labels.tolist() == [0.9, 1.1, 2.0]
    assert plan("1 + 0.1*sin(t)", 2.0).axes[0].labels.tolist() == ["1 + 0.1*sin(t)", "2.0"]
    with pytest.raises(SceneError, match=r'sweep."surface.radius": "1000 nm", "1 um" are the same'):
        _ = plan("1000 nm", "1 um").axes
