"""From a trajectory to numbers: ``wr.measure`` takes measures, ``wr.measures`` lists them.

registry, listing                    the table of all measures, and how it is printed
shape, motion, balance, writhe       measures of single rods
motion_class                         which of the known motions of swimmers a rod shows
curvature, settling, membrane        measures of filaments on their membrane
kymograph                            growing filaments: where their energy sits
swarm                                order, motion, correlations and shapes of many rods
crossings, segment_sweeps            rods that passed through each other
bootstrap                            intervals of statistics over rods
described                            how a measure is labelled
diagnostics, sensing                 the measures of swimmers and of filaments, by themselves
summary                              the table that ends a run
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["diagnostics", "kymograph", "sensing"])
