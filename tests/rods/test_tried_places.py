"""Centre lines for trying places are those of the filaments that are then made."""

import numpy as np
import pytest

from warp_rods.membranes import sampling, surfaces
from warp_rods.rods.bound.centre_lines import centre_lines
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.status import Status


@pytest.mark.parametrize("ends", [("free", "free"), ("clamped", "free"), ("free", "clamped")])
@pytest.mark.parametrize("kind", ["cassini", "patch", "undulated"])
def test_centre_lines_are_those_of_an_ensemble(kind, ends):
    """On the patch some leave the box of its formula."""
    made = {
        "cassini": lambda: surfaces.make("cassini", {"a": 1.0, "b": 1.1}),
        "patch": lambda: surfaces.make("expression", {"phi": "z - 0.2*sin(3*x)", "box": [[-1, 1]] * 3}),
        "undulated": lambda: surfaces.make("undulated", {}),
    }
    surface, rng, count = made[kind](), np.random.default_rng(2), 21
    x = sampling.uniform_points(surface, count, rng)
    q = sampling.isotropic_directions(surface, x, rng)
    parameters = {
        "length": rng.uniform(0.2, 0.6, count),
        "stiffness": np.ones((count, 3)),
        "intrinsic": rng.normal(size=(count, 3)),
        "drag": np.ones((count, 3)),
    }
    lines, status = centre_lines(surface, x, q, 17, parameters, (ends[0] == "clamped", ends[1] == "clamped"))
    rods = BoundRods(surface, x, q, nodes=17, ends=ends, **parameters)
    assert status.tolist() == rods.status.tolist() and (Status.LEFT_DATA in status) == (kind == "patch")
    fine = status == Status.OK
    np.testing.assert_allclose(lines[fine], rods.position[fine], rtol=0, atol=1e-14)
