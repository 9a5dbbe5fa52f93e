# Every public name, once: what `wr.NAME` is. The package reads this file and imports a name when it is first used.

from . import errors, frames
from .analysis import diagnostics, kymograph, sensing
from .analysis.registry import measure, measures
from .centrelines.centreline import from_centreline
from .draw import plots, swarm
from .draw.measured import plot
from .draw.usd.export import export_usd
from .errors import RodFailure, RunFolderError, SceneError, WarpRodsError
from .membranes import surfaces
from .membranes.surface import Surface
from .reproductions import reproduce
from .rigid_body import RigidBody
from .rods import modes
from .rods.bound.rods import BoundRods
from .rods.cosserat.rods import CosseratRods
from .rods.ensemble import Ensemble
from .rods.free.flagella import Flagella
from .rods.free.rods import FreeRods
from .rods.status import Status
from .scene.body import drag_of_rod
from .scene.moment import moment_from_flagella
from .scene.scene import Scene
from .simulation.hooks import every
from .simulation.loop import Simulation
from .simulation.reading import open_run
from .simulation.runner import Run
from .simulation.storage import StorageError
from .studies.study import Study
from .studies.sweep import sweep
from .theory import buckling, continuation, stability, steady
from .workflow import run

__version__: str

__all__ = [
    "BoundRods",
    "CosseratRods",
    "Ensemble",
    "Flagella",
    "FreeRods",
    "RigidBody",
    "RodFailure",
    "Run",
    "RunFolderError",
    "Scene",
    "SceneError",
    "Simulation",
    "Status",
    "StorageError",
    "Study",
    "Surface",
    "WarpRodsError",
    "buckling",
    "continuation",
    "diagnostics",
    "drag_of_rod",
    "errors",
    "every",
    "export_usd",
    "frames",
    "from_centreline",
    "kymograph",
    "measure",
    "measures",
    "modes",
    "moment_from_flagella",
    "open_run",
    "plot",
    "plots",
    "reproduce",
    "run",
    "sensing",
    "stability",
    "steady",
    "surfaces",
    "swarm",
    "sweep",
]
