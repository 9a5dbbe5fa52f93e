"""Output of extensible and shearable rods: frames, strains, stress, energy and powers at a time of the last step."""

import warp as wp

from warp_rods.kernels.cosserat.blocks import unless_held
from warp_rods.kernels.cosserat.equal_steps import show
from warp_rods.kernels.cosserat.outcome import extrapolated, sum_of
from warp_rods.kernels.cosserat.rod import (
    by_component,
    changes_of,
    drag_of,
    length_at,
    load_at,
    screw_after,
    stress_of,
)
from warp_rods.kernels.cosserat.state import Frames, Past, Rods
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Lanes1D,
    Lanes2D,
    Screw,
    Screws,
    add,
    div,
    mul,
    rods_in,
    rows,
    store,
)
from warp_rods.kernels.layout import Matrices2D, Quaternions2D, Scalars1D, Vectors2D, real
from warp_rods.kernels.lie import quaternion
from warp_rods.kernels.multistep import Pace, Weights, times_of, weights_at
from warp_rods.kernels.screws import angular, carried, carried_on, linear, minus, moved_frame, plus, scaled

wp.set_module_options({"enable_backward": False})


@wp.struct
class Output:
    """Strains and stress at nodes, energies and powers."""

    strain: Vectors2D  # Ω [rod, node]
    stretch: Vectors2D  # U
    internal_moment: Vectors2D  # m
    internal_force: Vectors2D  # n
    energy_density: Lanes2D
    segments: Screws  # (Ω, U), workspace
    force: Screws  # of the stress on a node, workspace
    energy: Lanes1D
    dissipation: Lanes1D
    power: Lanes1D


@wp.kernel
def show_frames(
    rods: Rods,
    now: Frames,
    past: Past,
    pace: Pace,
    target: Scalars1D,
    shown: Frames,
    rotation: Matrices2D,
    position: Vectors2D,
):
    """Frames and stress at the time ``target[0]`` within the last step; ``dim = tiles``."""
    tile = wp.tid()
    w = Weights()
    share = Lanes()
    for lane in range(rods_in(tile, rods.status.shape[0])):
        rod = tile * WIDTH + lane
        t = target[0]
        if pace.levels[rod] < 2 or rods.status[rod] != 0:
            t = pace.at[rod, 0]
        e = weights_at(times_of(pace, rod), wp.min(pace.levels[rod], 3), t)
        for j in range(3):
            w[j, lane] = e[j]
        if pace.levels[rod] > 1:
            share[lane] = (t - pace.at[rod, 0]) / (pace.at[rod, 0] - pace.at[rod, 1])
    for node in range(now.rotation.shape[1]):
        x = extrapolated(tile, node, w, past)
        R, r = moved_frame(now.rotation[tile, node], now.position[tile, node], x)
        shown.rotation[tile, node] = R
        shown.position[tile, node] = r
        P = now.stress[tile, node]
        shown.stress[tile, node] = plus(P, scaled(share, minus(P, past.stress_before[tile, node])))
    show(tile, shown, rotation, position)


@wp.func
def at_node(values: Screws, tile: int, node: int) -> Screw:
    """A value of segments at a node: the mean of both, at an end from the nearest two."""
    last = values.shape[1] - 1
    half = Lanes(real(0.5))
    if node == 0:
        return plus(values[tile, 0], scaled(half, minus(values[tile, 0], values[tile, 1])))
    if node == last:
        near = values[tile, last - 1]
        return plus(near, scaled(half, minus(near, values[tile, last - 2])))
    return scaled(half, plus(values[tile, node - 1], values[tile, node]))


@wp.func_native(rows("Screw", "ad", "for (int i = 0; i < 6; ++i) R[i] = D[i] > 0.0 ? A[i] / D[i] : (V)(0.0);"))
def over_drag(a: Screw, d: Screw) -> Screw:
    """a/d, and zero where there is no drag."""


@wp.func
def find_segments(tile: int, rods: Rods, shown: Frames, output: Output) -> Lanes:
    """Strains of the segments and forces of their stress on nodes; returns the energy."""
    last = shown.rotation.shape[1] - 1
    energy = Lanes()
    output.force[tile, 0] = Screw()
    for node in range(last):
        X = screw_after(tile, node, shown)
        A, C = changes_of(X)
        P = shown.stress[tile, node]
        strain = scaled(Lanes(real(1.0) / rods.spacing), X)
        excess = minus(strain, rods.natural[tile, node])
        energy += sum_of(by_component(excess, stress_of(tile, node, rods, X)))
        output.segments[tile, node] = strain
        output.force[tile, node] = plus(output.force[tile, node], carried(A, C, P))
        output.force[tile, node + 1] = scaled(Lanes(real(-1.0)), carried_on(A, C, P))
    return real(0.5) * rods.spacing * energy


@wp.func
def held_at(tile: int, node: int, last: int, rods: Rods) -> Screw:
    """1 for what a node may not do."""
    if node == 0 or node == last:
        return rods.held[tile, node // last]
    return Screw()


@wp.kernel
def find_output(rods: Rods, shown: Frames, rates: Screws, output: Output):
    """Strains, stress, energy and powers of the frames that are shown; ``dim = tiles``.

    Velocities with drag follow from the balance; ω across, which has none, is that of the last step (``rates``).
    """
    tile = wp.tid()
    last = shown.rotation.shape[1] - 1
    output.energy[tile] = find_segments(tile, rods, shown, output)
    zeta = drag_of(tile, rods)
    dissipation, power = Lanes(), Lanes()
    for node in range(last + 1):
        length = length_at(node, last, rods)
        load = load_at(tile, node, rods, shown)
        total = plus(scaled(real(1.0) / length, output.force[tile, node]), load)
        v = unless_held(over_drag(total, zeta), held_at(tile, node, last, rods))
        dissipation += length * sum_of(by_component(by_component(zeta, v), v))
        power += length * (sum_of(by_component(load, v)) + sum_of(by_component(load, across(rates[tile, node]))))
        store_node(tile, node, rods, shown, output)
    output.dissipation[tile] = dissipation
    output.power[tile] = power


@wp.func_native(rows("Screw", "a", "for (int i = 0; i < 6; ++i) R[i] = i == 1 || i == 2 ? A[i] : (V)(0.0);"))
def across(a: Screw) -> Screw:
    """The components of ω across."""


@wp.func
def store_node(tile: int, node: int, rods: Rods, shown: Frames, output: Output):
    """Strains, stress and energy per length of a node."""
    strain, P = at_node(output.segments, tile, node), at_node(shown.stress, tile, node)
    natural = at_node(rods.natural, tile, node)
    output.energy_density[tile, node] = real(0.5) * sum_of(by_component(minus(strain, natural), P))
    store(output.strain, tile, node, angular(strain))
    store(output.stretch, tile, node, linear(strain))
    store(output.internal_moment, tile, node, angular(P))
    store(output.internal_force, tile, node, linear(P))


@wp.kernel
def find_quaternions(rotation: Matrices2D, orientation: Quaternions2D):
    """Frames as quaternions; ``dim = (rods, nodes)``."""
    rod, node = wp.tid()
    orientation[rod, node] = quaternion(rotation[rod, node])


@wp.kernel
def find_rates(rods: Rods, past: Past, pace: Pace, rates: Screws):
    """Velocities at the end of the last step, from its screws; ``dim = tiles``."""
    tile = wp.tid()
    w = Weights()
    for lane in range(rods_in(tile, rods.status.shape[0])):
        rod = tile * WIDTH + lane
        if pace.levels[rod] > 1:
            last = pace.at[rod, 0] - pace.at[rod, 1]
            w[0, lane] = real(1.0) / last
            if pace.levels[rod] > 2:
                before = pace.at[rod, 1] - pace.at[rod, 2]
                w[0, lane] = real(1.0) / last + real(1.0) / (last + before)
                w[1, lane] = -last / (before * (last + before))
    for node in range(rates.shape[1]):
        rates[tile, node] = plus(scaled(w[0], past.screw[tile, node]), scaled(w[1], past.screw_before[tile, node]))
