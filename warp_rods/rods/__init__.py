"""Ensembles of rods: parameters, state and step; one folder a kind of rod.

ensemble                             what every kind is to its users, to contact, to the loop and to measures
free, bound                          the two kinds: swimmers in space, filaments on a membrane
status, clock, variables             why a rod was frozen; time; what a trajectory keeps
recorded, views                      graphs of launches; slices of an ensemble, one a thread
per_rod                              parameters: one value for all rods or one for each
step_limits                          how long a step may be
modes                                modes of a beam with free ends
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["modes"])
