"""Arrays of extensible and shearable rods (docs/model.md §10), [tile, node] of fields, and [tile], [rod]."""

import warp as wp

from warp_rods.kernels.cosserat.blocks import Blocks
from warp_rods.kernels.lanes import Lanes1D, Matrices, Screws, Squares1D, Vectors
from warp_rods.kernels.layout import Integers1D, Matrices2D, Scalars1D, Vectors2D, real

wp.set_module_options({"enable_backward": False})


@wp.struct
class Rods:
    """Parameters, what acts from outside, and status."""

    stiffness: Squares1D  # K [tile]
    drag_ratio: Lanes1D  # η
    rotational_drag: Lanes1D  # ηr
    natural: Screws  # (Ω0, U0) between a node and the next
    held: Screws  # 1 for what the first and the last node may not do [tile, 2]
    force: Vectors2D  # per length, in space [rod, node]
    couple: Vectors2D
    contact_stiffness: Matrices2D  # per length, in space [rod, node]
    touched: int  # 1 if there is contact
    status: Integers1D
    spacing: real


@wp.struct
class Frames:
    """Frames at nodes, and (m, n) between a node and the next."""

    rotation: Matrices
    position: Vectors
    stress: Screws


@wp.struct
class Past:
    """Screws of the last step and of the one before, and the stress before the last step."""

    screw: Screws
    screw_before: Screws
    stress_before: Screws


@wp.struct
class Trial:
    """The step that is tried [rod], and its screws."""

    end: Scalars1D
    order: Integers1D
    status: Integers1D
    error: Scalars1D
    screw: Screws


@wp.struct
class Work:
    """Workspace of a step."""

    angle: Matrices  # A between a node and the next
    place: Matrices  # C
    stress: Screws  # K (ξ* − ξ0)
    blocks: Blocks
