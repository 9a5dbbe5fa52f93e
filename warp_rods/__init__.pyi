# Every public name, once: what `wr.NAME` is. The package reads this file and imports a name when it is first used.

from . import errors
from .analysis import diagnostics, kymograph, sensing
from .analysis.registry import measure, measures
from .draw import plots, swarm
from .draw.measured import plot
from .draw.usd.export import export_usd
from .errors import RodFailure, RunFolderError, SceneError, WarpRodsError
from .membranes import surfaces
from .membranes.surface import Surface
from .reproductions import reproduce
from .rods import modes
from .rods.bound.rods import BoundRods
from .rods.cosserat.rods import CosseratRods
from .rods.ensemble import Ensemble
from .rods.free.flagella import Flagella
from .rods.free.rods import FreeRods
from .rods.status import Status
from .scene.scene import Scene
from .simulation.hooks import every
from .simulation.loop import Simulation
from .simulation.reading import open_run
from .simulation.runner import Run
from .simulation.storage import StorageError
from .theory import buckling, continuation, stability, steady
from .workflow import run

__version__: str

__all__ = [
    "BoundRods",
    "CosseratRods",
    "Ensemble",
    "Flagella",
    "FreeRods",
    "RodFailure",
    "Run",
    "RunFolderError",
    "Scene",
    "SceneError",
    "Simulation",
    "Status",
    "StorageError",
    "Surface",
    "WarpRodsError",
    "buckling",
    "continuation",
    "diagnostics",
    "errors",
    "every",
    "export_usd",
    "kymograph",
    "measure",
    "measures",
    "modes",
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
]
