"""Moving membranes (docs/moving_membranes.md): exact solutions, comparison with a membrane at rest, power, orders.

References are closed forms and conservation laws, orders are fitted slopes. Every tolerance is round-off or follows
from the order.
"""

from itertools import pairwise

import numpy as np
import pytest
from examples.bound import read

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods

ORDER = pytest.approx(2.0, abs=0.2)
PARAMETERS = {
    "length": 1.2,
    "stiffness": (1.0, 1.2, 0.8),
    "intrinsic": (0.7, 1.0, 0.3),
    "drag": (1.0, 2.0, 0.3),
}
MOVING_TORUS = "(sqrt((x - c)**2 + y**2) - 1)**2 + z**2 - 0.16"


def arc(nodes: int) -> np.ndarray:
    return np.linspace(-0.5, 0.5, nodes)


def on_torus(nodes: int, surface: surfaces.Surface, device: str = "cpu") -> BoundRods:
    """A bent filament across a torus, with all coefficients different from zero."""
    s = arc(nodes)
    turn = 0.3 + 2 * np.cos(np.pi * s) ** 4 * np.sin(5 * s + 1)
    place = ([[1.3, 0.1, 0.25]], [[0.3, 1.0, 0.4]])
    return BoundRods(surface, *place, nodes=nodes, geodesic_curvature=turn, device=device, **PARAMETERS)


def breathing(amplitude: float = 0.08, frequency: float = 3.0) -> surfaces.Surface:
    """A torus whose tube swells and shrinks."""
    return surfaces.make("torus", {"major": 1.0, "minor": f"0.4 + {amplitude}*sin({frequency}*t)"})


def slope(differences) -> float:
    """Order from successive differences of solutions, each with half the step of the previous one."""
    return float(np.polyfit(np.arange(len(differences)), -np.log2(differences), 1)[0])


def test_a_great_circle_remains_one_on_a_growing_sphere(device):
    """At constant length and direction of the middle: r = R(t) (cos s/R, sin s/R, 0), exactly."""
    sphere = surfaces.make("sphere", {"radius": "1.0 + 0.2*t"})
    rods = BoundRods(sphere, [[1, 0, 0]], [[0, 1, 0]], nodes=33, length=1.5, device=device)
    rods.step(1e-3, 1000)
    s, R = 1.5 * arc(33), 1.2
    exact = R * np.stack([np.cos(s / R), np.sin(s / R), 0 * s], axis=-1)
    np.testing.assert_allclose(rods.position[0], exact, atol=1e-12)
    values = rods.variables()
    assert values["constraint"][0] < 1e-15 and values["orthogonality"][0] < 1e-15 and values["arc_length"][0] < 1e-13
    # E = ½ B2 L/R²; membrane power dE/dt + ζ∥ ∫(s Ṙ/R)² ds + ζ⊥ L Ṙ²
    rates = -1.5 * 0.2 / R**3 + (0.2 / R) ** 2 * 1.5**3 / 12 + 2.0 * 1.5 * 0.2**2
    assert values["membrane_power"][0] == pytest.approx(rates, rel=0.01)


def test_a_growing_great_circle_remains_one_on_a_growing_sphere_during_refinement():
    sphere = surfaces.make("sphere", {"radius": "1.0 + 0.2*t"})
    growth = {"rate": 0.3, "until": 9.0, "spacing": 0.05}
    rods = BoundRods(sphere, [[1, 0, 0]], [[0, 1, 0]], nodes=33, length=1.5, growth=growth)
    rods.step(1e-3, 1000)
    assert rods.nodes == 65
    s, R = 1.8 * arc(65), 1.2
    exact = R * np.stack([np.cos(s / R), np.sin(s / R), 0 * s], axis=-1)
    np.testing.assert_allclose(rods.position[0], exact, atol=1e-12)


def test_the_geodesic_curvature_of_a_latitude_circle_decreases_on_a_growing_sphere():
    """Without motion across, Ω = cot θ/R at constant θ: ∂tΩ = −Ω Ṙ/R."""
    sphere = surfaces.make("sphere", {"radius": "0.9 + 0.3*t"})
    turn = 0.8
    rods = BoundRods(
        sphere, [[0.9, 0, 0]], [[0, 1, 0]], nodes=33, stiffness=(1e-6,) * 3, intrinsic=(0.0, 0.0, turn),
        geodesic_curvature=turn, drag=(1.0, 1e9, 0.0),
    )  # fmt: skip
    rods.evaluate()
    np.testing.assert_allclose(read(rods, "geodesic_rate")[0, 1:-1], -turn * 0.3 / 0.9, rtol=1e-8)


def test_a_filament_rolls_under_a_sphere_that_moves_sideways():
    """On the equator of a sphere with velocity c along its axis: ω0 = (c − u2)/R, u2 = c (ζr/R²)/(ζ⊥ + ζr/R²)."""
    radius, velocity, drag = 0.8, 0.5, (1.0, 2.0, 0.7)
    text = f"x**2 + y**2 + (z - c)**2 - {radius**2}"
    sphere = surfaces.make("expression", {"phi": text, "box": [[-1, 1]] * 3, "parameters": {"c": f"{velocity}*t"}})
    rods = BoundRods(sphere, [[radius, 0, 0]], [[0, 1, 0]], nodes=33, drag=drag)
    rods.evaluate()
    up = rods.rotation[0, :, 2, 1]
    roll = drag[2] / radius**2
    np.testing.assert_allclose(read(rods, "velocity_across")[0] * up, velocity * roll / (drag[1] + roll), rtol=1e-8)


def test_a_filament_follows_a_rising_plane(device):
    rising = surfaces.make("expression", {"phi": "z - h", "box": [[-2, 2]] * 3, "parameters": {"h": "0.3*sin(2*t)"}})
    lines = []
    for surface in (rising, surfaces.make("plane", {})):
        rods = BoundRods(
            surface, [[0, 0, 0]], [[1, 0.3, 0]], nodes=33, geodesic_curvature=3 * np.cos(np.pi * arc(33)) ** 2,
            device=device,
        )  # fmt: skip
        rods.step(1e-3, 200)
        lines.append(rods.position[0])
    lines[0][:, 2] -= 0.3 * np.sin(0.4)
    np.testing.assert_allclose(lines[0], lines[1], atol=1e-11)


def differences_from_torus_at_rest(nodes: int) -> tuple[float, float]:
    """Largest differences in position and load between filaments on a torus that moves at (c, 0, 0) and on one at rest.

    On the torus at rest the fluid flows past: the drag −ζ∥ c∥ − ζ⊥ c⊥ is an external force; ω is the same for both.
    """
    velocity, dt, steps = 0.8, 4e-4 * 32 / (nodes - 1), 2 * (nodes - 1)
    box = [[-1.6, 1.6], [-1.6, 1.6], [-0.6, 0.6]]
    values = {"phi": MOVING_TORUS, "box": box, "parameters": {"c": f"{velocity}*t"}}
    moving = on_torus(nodes, surfaces.make("expression", values))
    resting = on_torus(nodes, surfaces.make("torus", {"major": 1.0, "minor": 0.4}))

    def apply_flow() -> None:
        q, c = resting.rotation[..., 0], np.array([velocity, 0.0, 0.0])
        along = q * (q @ c)[..., None]
        resting.force = -1.0 * along - 2.0 * (c - along)

    for _ in range(steps):
        apply_flow()
        resting.step(dt)
    moving.step(dt, steps)
    apply_flow()
    difference = moving.position - resting.position - [velocity * moving.time, 0.0, 0.0]
    loads = [rods.variables()["load"] for rods in (moving, resting)]
    return np.abs(difference).max(), np.abs(loads[0] - loads[1])[:, 3:-3].max() / np.abs(loads[1]).max()


def test_a_moving_membrane_is_equivalent_to_one_at_rest_in_a_flow():
    position, load = np.transpose([differences_from_torus_at_rest(nodes) for nodes in (17, 33, 65)])
    assert position[-1] < 2e-6
    assert slope(position) == ORDER
    assert load[-1] < 1e-4


def test_second_order_in_space_on_a_breathing_torus(device):
    lines = []
    for nodes in (17, 33, 65, 129):
        rods = on_torus(nodes, breathing(), device)
        rods.step(1e-4, 200)
        lines.append(rods.position[0, :: (nodes - 1) // 16])
    assert slope([np.abs(a - b).max() for a, b in pairwise(lines)]) == ORDER


def test_second_order_in_time_on_a_breathing_torus(device):
    lines = []
    for step in (2e-3, 1e-3, 5e-4, 2.5e-4):
        rods = on_torus(33, breathing(), device)
        rods.step(2.5e-5, 2000)  # the fast initial relaxation, with the same steps in every run
        rods.step(step, round(0.1 / step))
        lines.append(rods.position[0])
    assert slope([np.abs(a - b).max() for a, b in pairwise(lines)]) == ORDER


def power_residual(nodes: int) -> float:
    """|dE/dt + D − P|/|P| on a torus whose tube swells fast; dE/dt by central differences of small steps."""
    rods, dt = on_torus(nodes, breathing(0.2, 5.0)), 2e-5
    rods.step(dt, 500)
    seen = []
    for _ in range(3):
        seen.append({k: v[0] for k, v in rods.variables().items() if v.ndim == 1})
        rods.step(dt)
    change = (seen[2]["energy"] - seen[0]["energy"]) / (2 * dt)
    return abs(change + seen[1]["dissipation"] - seen[1]["membrane_power"]) / abs(seen[1]["membrane_power"])


def test_the_energy_balance_includes_the_power_of_the_membrane():
    residuals = [power_residual(nodes) for nodes in (17, 33, 65)]
    assert residuals[0] / residuals[1] > 4 * 0.85 and residuals[1] / residuals[2] > 4 * 0.85
    assert residuals[2] < 1e-3


def test_a_filament_stays_on_the_moving_membrane_and_keeps_its_length(device):
    rods = on_torus(49, breathing(), device)
    for _ in range(10):
        rods.step(1e-3, 100)
        values = rods.variables()
        assert values["constraint"][0] < 1e-9
        assert values["orthogonality"][0] < 1e-15
        assert values["arc_length"][0] < 1e-9


def test_a_restored_state_continues_with_the_same_bits(device):
    rods = on_torus(33, breathing(), device)
    rods.step(1e-3, 20)
    state = rods.state()
    rods.step(1e-3, 30)
    other = on_torus(33, breathing(), device)
    other.restore(state)
    other.step(1e-3, 30)
    np.testing.assert_array_equal(other.position, rods.position)


def test_a_membrane_with_zero_velocity_gives_the_bits_of_one_at_rest():
    """The terms of a moving membrane vanish exactly for V = 0."""
    lines = []
    for minor in ("0.4 + 0*t", 0.4):
        rods = on_torus(33, surfaces.make("torus", {"major": 1.0, "minor": minor}))
        rods.step(1e-3, 50)
        lines.append(rods.variables())
    for name, values in lines[0].items():
        np.testing.assert_array_equal(values, lines[1][name], err_msg=name)
