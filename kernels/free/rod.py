"""The active Kirchhoff rod in its twist-free (Bishop) frame: velocities and rates from a shape (model.md §2).

Bending ``k = Ω[1] + i Ω[2]`` is a pair, and multiplication by i is ``turned``. Staggered along the rod:
``k, τ, f, λ, u⊥`` at nodes, ``Λ⊥, u0, ω⊥, ω0`` at half nodes, stored at the node before. Λ⊥ is extended oddly
and u0, f' vanish suitably beyond the free ends, so that power = −dE/dt holds to round-off.

Functions of a rod walk along it and leave their result in ``Flow``; on a CPU those arrays are one rod's
worth of memory shared by all rods, which is why one thread takes a rod through all of a step.
"""

import warp as wp

from warp_rods.kernels.banded import solve_tridiagonal_rod
from warp_rods.kernels.free.flagella import reaction
from warp_rods.kernels.free.state import Flow, Shape, Swimmers, numbers, pairs
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def turned(z: wp.vec2d):
    """i z, which is e0 × z."""
    return wp.vec2d(-z[1], z[0])


@wp.func
def wedge(a: wp.vec2d, b: wp.vec2d):
    """Im(ā b), which is e0·(a × b)."""
    return a[0] * b[1] - a[1] * b[0]


@wp.func
def across(force: wp.vec3d):
    """The part of a body vector that is normal to the rod."""
    return wp.vec2d(force[1], force[2])


@wp.func
def find_transverse_source(rod: int, rods: Swimmers, bending: pairs, twist: numbers, flow: Flow):
    """``(Λ⊥' + f⊥)/η`` at nodes, with ``Λ⊥ = i b k' + c τ k`` at half nodes, odd beyond the ends."""
    last = twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    mobility = real(1.0) / rods.drag_ratio[rod]
    b = rods.bending_stiffness[rod] * per_length
    c = rods.twist_stiffness[rod] * real(0.25)
    before = wp.vec2d()
    k = bending[rod, 0]
    tau = twist[rod, 0]
    for node in range(last):
        k_next = bending[rod, node + 1]
        tau_next = twist[rod, node + 1]
        after = b * turned(k_next - k) + (c * (tau + tau_next)) * (k + k_next)
        if node == 0:
            before = -after
        flow.transverse_source[rod, node] = mobility * (per_length * (after - before) + across(flow.force[rod, node]))
        before = after
        k = k_next
        tau = tau_next
    flow.transverse_source[rod, last] = mobility * (real(-2.0) * per_length * before + across(flow.force[rod, last]))


@wp.func
def find_axial_source(rod: int, rods: Swimmers, shape: Shape, flow: Flow):
    """``(b/2)(|k|²)' + f + f_ext0`` at half nodes."""
    half = real(0.5)
    b = half * rods.bending_stiffness[rod] / rods.spacing
    k = shape.bending[rod, 0]
    square = wp.dot(k, k)
    drive = shape.activity[rod, 0] + flow.force[rod, 0][0]
    for node in range(shape.twist.shape[1] - 1):
        k = shape.bending[rod, node + 1]
        square_next = wp.dot(k, k)
        drive_next = shape.activity[rod, node + 1] + flow.force[rod, node + 1][0]
        flow.axial_source[rod, node] = b * (square_next - square) + half * (drive + drive_next)
        square = square_next
        drive = drive_next


@wp.func
def solve_tension(rod: int, rods: Swimmers, shape: Shape, flow: Flow):
    """λ from ``(∂s u + Ω×u)·e0 = 0``: ``−λ'' + |k|² λ/η = source0' + Im(k̄ source⊥)``, 0 at the ends (4.24)."""
    last = shape.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    mobility = real(1.0) / rods.drag_ratio[rod]
    beside = -per_length * per_length
    source = flow.axial_source[rod, 0]
    for node in range(1, last):
        k = shape.bending[rod, node]
        source_next = flow.axial_source[rod, node]
        flow.lower[rod, node] = beside
        flow.upper[rod, node] = beside
        flow.diagonal[rod, node] = real(-2.0) * beside + mobility * wp.dot(k, k)
        flow.right[rod, node] = per_length * (source_next - source) + wedge(k, flow.transverse_source[rod, node])
        source = source_next
    pin(rod, last, flow)
    solve_tridiagonal_rod(rod, flow.lower, flow.diagonal, flow.upper, flow.right, flow.work, flow.tension)


@wp.func
def pin(rod: int, last: int, flow: Flow):
    """Rows of a tridiagonal system that hold both ends at 0."""
    zero = real(0.0)
    flow.upper[rod, 0] = zero
    flow.lower[rod, last] = zero
    flow.diagonal[rod, 0] = real(1.0)
    flow.diagonal[rod, last] = real(1.0)
    flow.right[rod, 0] = zero
    flow.right[rod, last] = zero


@wp.func
def find_axial_velocity(rod: int, rods: Swimmers, flow: Flow):
    """``u0 = λ' + source0`` at half nodes."""
    per_length = real(1.0) / rods.spacing
    for node in range(flow.tension.shape[1] - 1):
        slope = per_length * (flow.tension[rod, node + 1] - flow.tension[rod, node])
        flow.axial[rod, node] = slope + flow.axial_source[rod, node]


@wp.func
def find_transverse_velocity(rod: int, rods: Swimmers, bending: pairs, flow: Flow):
    """``u⊥ = source⊥ − i λ k/η`` at nodes, then ``ω⊥ = i u⊥' + u0 k`` and ``Im(k̄ ω⊥)`` at half nodes."""
    per_length = real(1.0) / rods.spacing
    mobility = real(1.0) / rods.drag_ratio[rod]
    k = bending[rod, 0]
    u = flow.transverse_source[rod, 0] - (mobility * flow.tension[rod, 0]) * turned(k)
    flow.transverse[rod, 0] = u
    for node in range(flow.tension.shape[1] - 1):
        k_next = bending[rod, node + 1]
        u_next = flow.transverse_source[rod, node + 1] - (mobility * flow.tension[rod, node + 1]) * turned(k_next)
        k_middle = real(0.5) * (k + k_next)
        spin = per_length * turned(u_next - u) + flow.axial[rod, node] * k_middle
        flow.transverse[rod, node + 1] = u_next
        flow.spin[rod, node] = spin
        flow.twist_source[rod, node] = wedge(k_middle, spin)
        k = k_next
        u = u_next


@wp.func
def integrate_bishop_spin(rod: int, rods: Swimmers, flow: Flow):
    """``ω0' = −Im(k̄ ω⊥)`` integrated outwards from the midpoint, where the gauge makes it 0."""
    nodes = flow.twist_source.shape[1]
    middle = nodes // 2
    total = real(0.0)
    flow.bishop_spin[rod, middle] = total
    for node in range(middle, nodes - 1):
        total -= rods.spacing * flow.twist_source[rod, node]
        flow.bishop_spin[rod, node + 1] = total
    total = real(0.0)
    for back in range(middle):
        node = middle - 1 - back
        total += rods.spacing * flow.twist_source[rod, node]
        flow.bishop_spin[rod, node] = total


@wp.func
def balance(rod: int, rods: Swimmers, shape: Shape, flow: Flow):
    """Tension and velocities of one rod: forces and moments balance, and its length stays (4.16), (4.17)."""
    find_transverse_source(rod, rods, shape.bending, shape.twist, flow)
    find_axial_source(rod, rods, shape, flow)
    solve_tension(rod, rods, shape, flow)
    find_axial_velocity(rod, rods, flow)
    find_transverse_velocity(rod, rods, shape.bending, flow)
    integrate_bishop_spin(rod, rods, flow)


@wp.func
def axial_at(rod: int, node: int, flow: Flow):
    """u0 at a node; even beyond the ends, where ``u0' = −Im(k̄ u⊥) = 0``."""
    last = flow.axial.shape[1] - 1
    return real(0.5) * (flow.axial[rod, wp.max(node - 1, 0)] + flow.axial[rod, wp.min(node, last - 1)])


@wp.func
def roll_at(rod: int, node: int, rods: Swimmers, shape: Shape):
    """``ω0 = (c τ' + M f)/ηr`` of the material at the half node after ``node`` (4.21)."""
    slope = (shape.twist[rod, node + 1] - shape.twist[rod, node]) / rods.spacing
    f = real(0.5) * (shape.activity[rod, node] + shape.activity[rod, node + 1])
    return (rods.twist_stiffness[rod] * slope + rods.moment[rod] * f) / rods.rotational_drag[rod]


@wp.func
def bending_rate(rod: int, node: int, rods: Swimmers, k: wp.vec2d, flow: Flow):
    """``dk/dt = ω⊥' − i ω0 k`` at an interior node (4.10)."""
    slope = (flow.spin[rod, node] - flow.spin[rod, node - 1]) / rods.spacing
    return slope - flow.bishop_spin[rod, node] * turned(k)


@wp.func
def spread_at(rod: int, node: int, rods: Swimmers, activity: numbers):
    """``D f''`` with ``f' = 0`` at the ends."""
    last = activity.shape[1] - 1
    left = activity[rod, wp.abs(node - 1)]
    right = activity[rod, last - wp.abs(last - node - 1)]
    scale = rods.diffusion[rod] / (rods.spacing * rods.spacing)
    return scale * (left - real(2.0) * activity[rod, node] + right)


@wp.func
def activity_drive(rod: int, node: int, rods: Swimmers, shape: Shape, flow: Flow):
    """``(source − sink f + D f'', sink)`` of the flagellar law at a node (4.12)."""
    f = shape.activity[rod, node]
    source, sink = reaction(rods.law[rod], f, axial_at(rod, node, flow), rods.law_numbers[rod])
    return source - sink * f + spread_at(rod, node, rods, shape.activity), sink
