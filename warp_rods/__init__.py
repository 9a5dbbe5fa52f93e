"""warp_rods: geometrically exact Kirchhoff rods at low Reynolds number, in batches, on NVIDIA Warp.

Begin with ``wr.run("scenes/swimmer.toml")`` and ``wr.open_run("runs/swimmer")``. Names are imported when they are
first used; ``__init__.pyi`` lists them.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
