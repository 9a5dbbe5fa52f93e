"""The tables [flow], [gravity] and [[forces]] of a scene, and couples of swimmers."""

import numpy as np
import pytest

import warp_rods as wr
from warp_rods.errors import SceneError
from warp_rods.scene.flows import FLOWS
from warp_rods.simulation.loop import Simulation

SCENE = """
[surface]
kind = "sphere"
radius = 1.0

[flow]
kind = "shear"
rate = 2

[gravity]
force = [0, 0, -1]

[[forces]]
force = ["sin(x)", 0, "t"]
on = ["cells"]

[[forces]]
couple = [0, 0, "0.1*s"]

[[filaments]]
name = "sensors"
count = 1
nodes = 17
length = 0.5
stiffness = [1.0, 1.0, 1.0]
drag = [1.0, 2.0, 0.1]
placement = { position = [[1.0, 0.0, 0.0]], direction = [[0.0, 1.0, 0.0]] }

[[swimmers]]
name = "cells"
count = 2
nodes = 17
bend = 1e-2
twist = 1e-3
couple = "0.1*cos(pi*s)*sin(t)"
placement = { position = [[0.3, 1.0, 0.0], [0.0, -2.0, 0.0]] }

[time]
end = 0.02
step = 1e-3
"""


def test_the_tables_survive_being_written():
    scene = wr.Scene.parse(SCENE)
    assert wr.Scene.parse(scene.to_toml()) == scene
    assert wr.Scene.parse(SCENE.replace("rate = 2", "rate = 2.0")).hash() == scene.hash()
    assert scene.flow.values == {"rate": 2.0, "direction": (1, 0, 0), "gradient": (0, 1, 0), "centre": (0, 0, 0)}


def test_they_act_on_the_ensembles_that_they_name():
    simulation = Simulation(wr.Scene.parse(SCENE), "cpu")
    for _ in simulation.advance():
        pass
    table = {"flow": {"kind": "shear", "rate": 2.0}, "gravity": [0, 0, -1.0]}
    couple = {"couple": [0, 0, "0.1*s"]}
    cells = wr.FreeRods(
        2, 17, bend=1e-2, twist=1e-3, couple="0.1*cos(pi*s)*sin(t)", position=[[0.3, 1.0, 0.0], [0.0, -2.0, 0.0]],
        forces=[{"force": ["sin(x)", 0, "t"]}, couple], shape={"kind": "mode"}, device="cpu", **table,
    )  # fmt: skip
    sensors = wr.BoundRods(
        simulation.surfaces["surface"], [[1.0, 0, 0]], [[0, 1.0, 0]], nodes=17, length=0.5, forces=[couple],
        device="cpu", **table,
    )  # fmt: skip
    for name, alone in (("cells", cells), ("sensors", sensors)):
        alone.step(1e-3, 20)
        for reading in ("position", "orientation"):  # the first steps are divided otherwise
            found = getattr(simulation.ensembles[name], reading)
            np.testing.assert_allclose(found, getattr(alone, reading), rtol=0, atol=1e-4, err_msg=f"{name} {reading}")
    assert simulation.new_warnings() == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('on = ["cells"]', 'on = ["cell"]'), r'forces\[0\].on = \["cell"\]: there is no ensemble "cell"'),
        (("rate = 2", "speed = 2"), "flow.speed: a flow of kind shear has no speed; it has rate"),
        (("force = [0, 0, -1]", "force = [0, 0]"), r"gravity.force = \[0, 0\]: must be three numbers"),
        (('"sin(x)"', '"sin(u)"'), r"forces\[0\].force = .*u is not known here"),
        (('"0.1*s"', '"0.1*s)"'), r"forces\[1\].couple = .*"),
        (("0.1*cos(pi*s)*sin(t)", "x"), r"swimmers\[0\].couple = .*x is not known here"),
        (("count = 2", "count = 2\nsymmetric = true"), r"symmetric = true: not possible with \[gravity\]"),
    ],
)
def test_faults_are_named(change, message):
    with pytest.raises(SceneError, match=message):
        wr.Scene.parse(SCENE.replace(*change))


def test_every_kind_of_flow_has_keys_in_words():
    for name, kind in FLOWS.items():
        assert all(key.words for key in kind.keys.values()), name
        assert set(kind.perpendicular) <= set(kind.keys), name
