"""warp_rods: geometrically exact Kirchhoff rods at low Reynolds number, in batches, on NVIDIA Warp.

Scenes and runs   run, Scene, Simulation, every, Run, open_run, export_usd
Parameter studies sweep, Study
Your own loop     FreeRods, BoundRods, CosseratRods, Flagella, surfaces, Surface, Status
Real cells        moment_from_flagella, drag_of_rod
Measured shapes   from_centreline
Measures, plots   measure, measures, plot, plots, sensing, kymograph, swarm, diagnostics
Geometry          frames, RigidBody
Theory            steady, continuation, stability, buckling, modes, reproduce
Errors            WarpRodsError, SceneError, RunFolderError, StorageError, RodFailure

Begin with ``wr.run("scenes/swimmer.toml")`` and ``wr.open_run("runs/swimmer")``. ``help(wr.run)`` explains a name.
Names are imported when they are first used; ``__init__.pyi`` lists them.
"""

import lazy_loader

__version__ = "0.1.0"

# Without __all__, help() is the text above; with it, the help of every class follows.
__getattr__, __dir__, _ = lazy_loader.attach_stub(__name__, __file__)
