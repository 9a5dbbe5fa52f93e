"""Ensembles of rods: parameters, state and step; one folder for each kind of rod.

ensemble, readings                   the contract that every kind of rod fulfils
free, bound, cosserat                the kinds: active rods in space, filaments on a membrane, extensible rods
status, clock, variables             why a rod was frozen; time; the variables of a trajectory
recorded, slices                     recorded kernel launches; slices of an ensemble, one for each thread
per_rod                              parameters: one value for all rods or one for each
together, control, pace              steps of several ensembles, and their lengths by error
modes                                modes of a beam with free ends
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["modes"])
