"""The dissertation"s figures and numbers, each made anew by a run of this code.

catalogue                            the table of reproductions
reproduce                            runs them, and writes figure, data and table of each
result                               what a reproduction gives
the others                           a figure or a few each
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["reproduce"])
