"""From the shape of filaments to their tension, velocities and rates, and to what is read of them."""

import warp as wp

from warp_rods.kernels.banded import solve_tridiagonal_rod
from warp_rods.kernels.bound import energy, load
from warp_rods.kernels.bound.linear_systems import set_tension_rows
from warp_rods.kernels.bound.rod import (
    find_geodesic_rates,
    find_loads,
    find_moments,
    find_transverse_forces,
    find_velocities,
    find_velocity_coefficients,
)
from warp_rods.kernels.bound.state import Filaments, Systems
from warp_rods.kernels.lanes import Lanes, Lanes2D, Vector, Vectors, store_where, vector_of
from warp_rods.kernels.layout import Quaternions2D, Scalars1D, Vectors2D, real
from warp_rods.kernels.lie import quaternion
from warp_rods.kernels.surface.geometry import gaussian

wp.set_module_options({"enable_backward": False})


@wp.struct
class Output:
    """What is read of an ensemble: [rod], [rod, end], [rod, node], or fields [tile, node]."""

    energy: Scalars1D
    dissipation: Scalars1D
    growth_power: Scalars1D
    force_power: Scalars1D
    membrane_power: Scalars1D
    gauss: Scalars1D
    end_load: Vectors2D
    end_moment: Vectors2D
    orientation: Quaternions2D
    energy_density: Lanes2D
    load: Vectors
    load_moment: Lanes2D
    stretch_force: Lanes2D
    normal_shear: Lanes2D
    tension: Lanes2D
    geodesic_rate: Lanes2D


@wp.func
def evaluate(f: Filaments, tile: int, systems: Systems):
    """Tension, velocities and rates of the rods of a tile; the load in the frames is known."""
    find_moments(f, tile)
    find_transverse_forces(f, tile)
    find_velocity_coefficients(f, tile)
    set_tension_rows(f, tile, systems)
    solve_tridiagonal_rod(tile, systems.lower, systems.diagonal, systems.upper, systems.rhs, systems.work, f.tension)
    find_velocities(f, tile)
    find_geodesic_rates(f, tile)


@wp.kernel
def find_output(f: Filaments, systems: Systems, middle: int, output: Output):
    """Tension, velocities and rates of the state shown, and what follows from them; ``dim = tiles``.

    The drag of contact belongs to steps.
    """
    tile = wp.tid()
    if f.in_contact == 1:
        for i in range(f.geodesic.shape[1]):
            f.contact_drag[tile, i] = Vector()
    find_loads(f, tile)
    evaluate(f, tile, systems)
    powers = output.growth_power
    energy.find_energies(f, tile, output.energy_density, output.energy, output.dissipation, powers, output.force_power)
    load.find_normal_shear(f, tile, output.normal_shear)
    load.find_load(f, tile, output.normal_shear, output.load, output.load_moment)
    load.find_end_loads(f, tile, output.normal_shear, output.end_load, output.end_moment)
    load.find_stretch_force(f, tile, output.stretch_force)
    if f.membrane_moves == 1:
        load.find_membrane_power(f, tile, output.normal_shear, output.membrane_power)
    for i in range(f.geodesic.shape[1]):
        output.tension[tile, i] = f.tension[tile, i]
        output.geodesic_rate[tile, i] = f.geodesic_rate[tile, i]
    store_where(output.gauss, tile, Lanes(real(1.0)), gaussian(f.curvature[tile, middle]))


@wp.kernel
def find_orientations(f: Filaments, quaternions: Quaternions2D):
    """Directors as quaternions x, y, z, w; ``dim = (rods, nodes)``."""
    rod, i = wp.tid()
    q, across, n = vector_of(f.tangent, rod, i), vector_of(f.across, rod, i), vector_of(f.normal, rod, i)
    quaternions[rod, i] = quaternion(wp.matrix_from_cols(q, across, n))
