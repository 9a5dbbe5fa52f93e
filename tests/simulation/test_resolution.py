"""The number of nodes: criteria, what "auto" chooses, warnings of too few, and the error with that number."""

import re
import tomllib

import numpy as np
import pytest

from warp_rods import workflow
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.free.rods import FreeRods
from warp_rods.scene.scene import Scene
from warp_rods.simulation import criteria
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.resolution import MOST_CHOSEN
from warp_rods.simulation.samples import samples_of
from warp_rods.theory.steady import Swimmer, settled

MODE = {"kind": "mode", "mode": 0, "amplitude": 3.0}
SWIMMER = {"name": "c", "count": 1, "nodes": "auto", "bend": 5e-3, "twist": 1e-3, "shape": MODE}
FILAMENT = {
    "name": "f", "count": 2, "nodes": "auto", "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1],
}  # fmt: skip
SPHERE = {"kind": "sphere", "radius": 1.0}
TIME = {"end": 0.01, "save_every": 0.01}


def swimmers(steric: dict | None = None, **values) -> Simulation:
    tables = {"swimmers": [SWIMMER | values], "time": TIME} | ({"steric": steric} if steric else {})
    return Simulation(Scene.parse(tables), "cpu")


def filaments(surface: dict | None = None, steric: dict | None = None, end: float = 0.01, **values) -> Simulation:
    tables = {"surface": surface or SPHERE, "filaments": [FILAMENT | values], "time": {"end": end}}
    return Simulation(Scene.parse(tables | ({"steric": steric} if steric else {})), "cpu")


def nodes(simulation: Simulation) -> int:
    (ensemble,) = simulation.ensembles.values()
    return ensemble.nodes


def odd(length: float, spacing: float) -> int:
    """The smallest odd number of nodes at most ``spacing`` apart."""
    return 2 * int(np.ceil(length / (2 * spacing))) + 1


SWIMMERS = {
    "the start, 18 cells in a half-wave": ({}, 29),
    "the start, a higher mode": ({"shape": MODE | {"mode": 4}}, 101),
    "the start, strongly bent": ({"shape": MODE | {"amplitude": 60.0}}, odd(1, 1 / (60 * 1.58815))),
    "the least": ({"shape": {"kind": "straight"}, "bend": 2e-2}, 17),
    "steady": ({"bend": 3e-4}, odd(1, 0.5 * np.cbrt(1.5e-4))),
    "the softest of two": ({"bend": [1e-2, 3e-4], "count": 2}, odd(1, 0.5 * np.cbrt(1.5e-4))),
    "the drag across": ({"bend": 6e-4, "drag_ratio": 4.0}, odd(1, 0.5 * np.cbrt(1.5e-4))),
    "waving": ({"bend": 1.3e-4}, odd(1, 0.18 * np.cbrt(6.5e-5))),
    "waving, a wider reversal of the flagella": (
        {"bend": 3e-4, "flagella": {"diffusion": 4e-3}}, odd(1, 0.18 * np.cbrt(1.5e-4))
    ),
    "held flagella that reverse too sharply to wave": (
        {"bend": 1e-4, "flagella": {"law": "held", "sharpness": 40.0}}, odd(1, 0.5 * np.cbrt(5e-5))
    ),
    "thrust that stretches": ({"bend": 1.3e-4, "flagella": {"profile": "uniform"}}, odd(1, 0.5 * np.cbrt(6.5e-5))),
    "coils": ({"bend": 1e-3, "moment": 0.1}, odd(1, 1e-3 / 0.05)),
    "coils, little stiffness of twist": ({"bend": 1e-3, "moment": 0.1, "twist": 1.25e-4}, odd(1, 0.5e-3 / 0.05)),
    "a wound start": (
        {"bend": 1e-3, "moment": 0.1, "shape": {"kind": "writhe", "amplitude": 1.0}}, odd(1, 0.5e-3 / 0.05)
    ),
    "a start wound ten times": (
        {"bend": 1e-3, "moment": -0.01, "shape": {"kind": "writhe", "amplitude": 1.0, "balanced": False}},
        odd(1, 0.5e-3 / 0.05),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SWIMMERS)
def test_the_number_chosen_for_swimmers(name):
    values, expected = SWIMMERS[name]
    simulation = swimmers(**values)
    assert nodes(simulation) == expected and not simulation.warnings
    assert any(re.match(rf"c: {expected} nodes chosen, .* apart: ", note) for note in simulation.notes)
    if expected > 17:
        (line,) = swimmers(**values, nodes=expected - 2).warnings
        assert f"{expected - 2} nodes are" in line and line.endswith(f"use {expected} nodes or more")
    assert not swimmers(**values, nodes=expected).warnings


BRIDGE = {"kind": "bridge", "neck": 0.1, "body": 0.5, "width": 1.0, "length": 3.0}
CYLINDER = {"kind": "cylinder", "radius": 0.5, "length": 6.0}
CLOSING = {"kind": "sphere", "radius": "1.0 - 0.08*t"}
GROWS = {"rate": 0.5, "until": 3.0}
BENT = {"position": [[0, 0, 0]], "direction": [[1, 0, 0]], "geodesic_curvature": [-12.0]}
FILAMENTS = {
    "the least": ({}, 17),
    "a sharper membrane": ({"surface": CYLINDER, "length": 3.0}, odd(3.0, 0.25 / 2)),
    "a neck": ({"surface": BRIDGE, "length": 0.6}, odd(0.6, 0.25 / 10)),
    "a neck that closes": ({"surface": CLOSING, "length": 1.0, "end": 10.0}, odd(1.0, 0.25 * 0.2)),
    "intrinsic strains": ({"intrinsic": [0, 12, 0]}, odd(0.5, 0.25 / 12)),
    "a bent start": ({"surface": {"kind": "plane"}, "count": 1, "placement": BENT}, odd(0.5, 0.25 / 12)),
    "growth": ({"surface": CYLINDER, "growth": GROWS}, odd(3.0, 0.25 / 2)),
    "growth to lengths": ({"surface": CYLINDER, "growth": {"time": [0, 1], "length": [0.5, 3.0]}}, odd(3.0, 0.25 / 2)),
    "growth with more nodes": ({"surface": CYLINDER, "growth": GROWS | {"spacing": 0.04}}, 17),
    "growth with more nodes soon": ({"surface": CYLINDER, "growth": GROWS | {"spacing": 0.02}}, odd(0.5, 0.02)),
    "growth with more nodes too late": ({"surface": CYLINDER, "growth": GROWS | {"spacing": 0.5}}, odd(3.0, 0.25 / 2)),
    # For B = (1, 1, B3) on this cylinder e'' = 4 cos 2α.
    "ends that turn in the membrane": ({"surface": CYLINDER, "stiffness": [1, 1, 0.0016]}, odd(0.5, 0.02)),
}


@pytest.mark.parametrize("name", FILAMENTS)
def test_the_number_chosen_for_filaments(name):
    values, expected = FILAMENTS[name]
    simulation = filaments(**values)
    assert nodes(simulation) == expected and not simulation.warnings
    assert any(re.match(rf"f: {expected} nodes chosen, .* apart: ", note) for note in simulation.notes)
    if name != "growth with more nodes soon":  # which is refused with fewer nodes
        (line,) = filaments(**values, nodes=expected - 2).warnings
        assert f"{expected - 2} nodes are" in line and line.endswith(f"use {expected} nodes or more")
    assert not filaments(**values, nodes=expected).warnings


def test_the_length_over_which_the_curvature_of_a_membrane_varies():
    """A sheet z = a sin kx with small ak has the curvature a k² sin kx; that of spheres and cylinders does not vary."""
    for kind, values, varies in (
        ("expression", {"phi": "z - 0.01*sin(4*x)", "box": [[-1, 1], [-1, 1], [-1, 1]]}, 4.0),
        ("expression", {"phi": "z - 0.001*sin(8*x)", "box": [[-1, 1], [-1, 1], [-1, 1]]}, 8.0),
        ("sphere", {"radius": 1.0}, 0.0),
        ("cylinder", {"radius": 0.5, "length": 6.0}, 0.0),
        ("plane", {"size": 2.0}, 0.0),
    ):
        (sample,) = samples_of(surfaces.make(kind, values), 1.0, None)
        assert np.sqrt(sample.variation) == pytest.approx(varies, rel=0.04, abs=1e-3)
    sheet = {"kind": "expression", "phi": "z - 0.01*sin(8*x)", "box": [[-1, 1], [-1, 1], [-1, 1]]}
    simulation = filaments(surface=sheet)
    assert nodes(simulation) == pytest.approx(odd(0.5, 0.1 / 8), abs=2)
    assert any("curvatures of the membrane vary over a length" in note for note in simulation.notes)


@pytest.mark.parametrize(("range", "spacing"), [(0.02, 0.03), (0.002, 1.5 * np.sqrt(0.002 * 0.03))])
def test_nodes_are_close_against_the_steric_core_and_the_width_of_contact(range, spacing):
    steric = {"strength": 1000.0, "range": range, "core": 0.03}
    for made, length in ((swimmers, 1.0), (filaments, 0.5)):
        simulation = made(steric=steric, count=1)
        assert nodes(simulation) == odd(length, spacing)
        (line,) = [w for w in made(steric=steric, count=1, nodes=17).warnings if "17 nodes are" in w]
        assert f"use {odd(length, spacing)} nodes or more" in line
        assert not [w for w in simulation.warnings if "nodes" in w]
    assert nodes(filaments(steric=steric | {"strength": 0.0})) == 17


def test_no_more_nodes_are_chosen_than_a_maximum_and_more_are_told():
    simulation = swimmers(bend=1e-7)
    needed = odd(1, 0.18 * np.cbrt(5e-8))
    assert nodes(simulation) == MOST_CHOSEN < needed
    (line,) = simulation.warnings
    assert f'{MOST_CHOSEN} nodes, the most that "auto" chooses, are' in line and f"use {needed} nodes or more" in line


def test_a_number_that_is_none_is_refused_with_its_key():
    for kind, table, allowed in (
        ("swimmers", SWIMMER, "an odd whole number, 17 or more, at most 100 000"),
        ("filaments", FILAMENT, "a whole number, 9 or more, at most 100 000"),
    ):
        with pytest.raises(SceneError, match=rf'{kind}\[0\].nodes = "many": must be {allowed}, or "auto"'):
            Scene.parse({"surface": SPHERE, kind: [table | {"nodes": "many"}], "time": TIME})
    each = {"position": [[0, 0, 1]], "direction": [[1, 0, 0]], "geodesic_curvature": [[0.0] * 33]}
    with pytest.raises(SceneError, match=r"geodesic_curvature\[0\] = .* needs their number in place of nodes"):
        Scene.parse({"surface": SPHERE, "filaments": [FILAMENT | {"count": 1, "placement": each}], "time": TIME})
    with pytest.raises(SceneError, match=r'nodes = "auto": must be a number here'):
        Swimmer.of(Scene.parse({"swimmers": [SWIMMER], "time": TIME}).swimmers[0])
    with pytest.raises(SceneError, match="nodes"):
        FreeRods(1, "auto", bend=1e-3, twist=1e-3)


def test_each_ensemble_chooses_its_own_and_the_scene_as_run_has_the_numbers(tmp_path):
    tables = {
        "swimmers": [SWIMMER, SWIMMER | {"name": "soft", "bend": 3e-4}, SWIMMER | {"name": "given", "nodes": 33}],
        "surface": SPHERE, "filaments": [FILAMENT], "time": TIME | {"step": 1e-4}, "output": {"usd": False},
    }  # fmt: skip
    scene, out = Scene.parse(tables), tmp_path / "run"
    run = workflow.run(scene, out)
    chosen = {"c": 29, "soft": odd(1, 0.5 * np.cbrt(1.5e-4)), "given": 33, "f": 17}
    kept = tomllib.loads((out / "scene.toml").read_text())
    assert {t["name"]: t["nodes"] for t in kept["swimmers"] + kept["filaments"]} == chosen
    assert run.scene == Scene.load(out / "scene.toml")
    assert {name: run.data[name].sizes["node"] for name in chosen} == chosen
    assert sum("nodes chosen" in message for message in run.messages) == 3
    longer = Scene.parse(tables | {"time": tables["time"] | {"end": 0.02}})
    for scene in (Scene.load(out / "scene.toml"), longer):
        workflow.run(scene, out, resume=True)
    with pytest.raises(RunFolderError, match=r"swimmers\[2\].nodes: 33 in the run, 35 in the scene"):
        other = [*tables["swimmers"][:2], SWIMMER | {"name": "given", "nodes": 35}]
        workflow.run(Scene.parse(tables | {"swimmers": other}), out, resume=True)


def test_check_shows_the_number_chosen_with_its_reason(tmp_path, capsys):
    from warp_rods import cli

    (tmp_path / "scene.toml").write_text(Scene.parse({"swimmers": [SWIMMER], "time": TIME}).to_toml())
    cli.check(tmp_path / "scene.toml")
    said = capsys.readouterr().out
    assert "c: 1 rod of 29 nodes" in said
    assert "c: 29 nodes chosen, 0.0357 apart: the 1.5 half-waves of the mode 0 at the start" in said


# --- one per cent -----------------------------------------------------------------------------------------------------


def waving(count: int) -> np.ndarray:
    """Mean bending, period and mean speed of a waving U after its transient."""
    rods = FreeRods(1, count, bend=1.3e-4, twist=1e-3, symmetric=True, shape=MODE)
    rods.advance_to(6.0, 1e-6 / rods.step_tolerance)
    times, bending, middle = np.arange(6.0, 10.0, 0.02), [], []
    for time in times:
        rods.advance_to(time, 1e-6 / rods.step_tolerance)
        bending.append(np.sqrt((rods.strain[0, :, 2] ** 2).mean()))
        middle.append(rods.position[0, count // 2])
    x = np.array(bending) - np.mean(bending)
    before = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    crossings = times[before] - x[before] * 0.02 / (x[before + 1] - x[before])
    speed = np.linalg.norm(np.diff(middle, axis=0), axis=1).mean() / 0.02
    return np.array([np.mean(bending), np.diff(crossings).mean(), speed])


@pytest.mark.long
def test_a_waving_swimmer_is_right_to_one_per_cent(verified):
    chosen = nodes(swimmers(bend=1.3e-4, symmetric=True))
    found, exact = waving(chosen), waving(4 * chosen - 3)
    verified(
        "independent", f"waving swimmer with {chosen} nodes, the number chosen: bending, period, speed", measured=found,
        expected=exact, relative=0.01, reference=f"{4 * chosen - 3} nodes",
    )  # fmt: skip
    assert abs(waving(65)[1] / exact[1] - 1) > 0.015


def test_a_steady_swimmer_needs_far_fewer_nodes_and_is_right_to_one_per_cent(verified):
    chosen = nodes(swimmers())
    assert chosen < 33
    found = FreeRods(1, chosen, bend=5e-3, twist=1e-3, symmetric=True, shape=MODE)
    found.advance_to(7.0, 1e-6 / found.step_tolerance)
    before = found.position[0, chosen // 2]
    found.advance_to(8.0, 1e-6 / found.step_tolerance)
    speed = np.linalg.norm(found.position[0, chosen // 2] - before)
    bending = np.sqrt((found.strain[0, :-1, 2] ** 2).mean())
    fine = settled(Swimmer(129, {"bend": 5e-3, "twist": 1e-3}, symmetric=True), MODE)
    verified(
        "independent", f"steady swimmer with {chosen} nodes, the number chosen: speed and bending",
        measured=[speed, bending], expected=[fine.speed, np.sqrt((fine.curvature[:-1] ** 2).mean())], relative=0.01,
        reference="Newton's method, 129 nodes",
    )  # fmt: skip


def test_a_filament_is_right_to_one_per_cent(verified):
    """On a torus, where it moves by more than its length."""
    torus = {"kind": "torus", "major": 1.0, "minor": 0.4}
    given = {"length": 1.2, "stiffness": [0.6, 0.9, 1.1], "intrinsic": [0.5, 0.8, 0.0], "drag": [1.0, 2.0, 0.3]}
    chosen = nodes(filaments(surface=torus, **given))
    found = {}
    for count in (chosen, 4 * chosen - 3):
        surface = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
        rods = BoundRods(surface, [[1.4, 0, 0]], [[0, 1, 0.6]], nodes=count, **given)
        rods.advance_to(3.0, 1e-6 / rods.step_tolerance)
        found[count] = rods.position[0, :: (count - 1) // (chosen - 1)]
    verified.below(
        "independent", f"filament with {chosen} nodes, the number chosen: error of places over the length",
        measured=np.linalg.norm(found[chosen] - found[4 * chosen - 3], axis=-1) / 1.2, bound=0.01,
        reference=f"{4 * chosen - 3} nodes",
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(12))
def test_the_orientation_stiffness_of_many_filaments_is_the_largest_of_all(seed):
    """The same number as from every filament at every sample; bounds leave most of them out."""
    rng = np.random.default_rng(seed)
    principal = np.sort(rng.normal(size=(40, 2)), axis=1) * rng.choice([0, 1e-3, 1, 10])
    stiffness, intrinsic = np.exp(rng.normal(size=(30, 3)) * (seed % 2)), rng.normal(size=(30, 3)) * (seed % 3)
    each = zip(stiffness, intrinsic, strict=True)
    largest = max(criteria._orientation_stiffness(principal, B, s) / B[2] for B, s in each)
    found = criteria._turning(principal, stiffness[:, None], intrinsic[:, None])
    assert [c.spacing for c in found] == ([pytest.approx(largest**-0.5, rel=1e-12)] if largest > 0 else [])
