"""The figures and numbers of the dissertation, each reproduced by simulations with this package.

catalogue                            the table of reproductions
reproduce                            runs them, and writes figure, data and table of each
result                               what a reproduction returns
integrate, swimmers, planar          simulations that several reproductions use
sensor_figure, sensor_statistics     figure and tests of Figs 5.4 and 5.5
the others                           one figure, or a few, each
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["reproduce"])
