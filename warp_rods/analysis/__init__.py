"""From a trajectory to numbers: ``wr.measure`` computes measures, ``wr.measures`` lists them.

registry, listing                    the table of all measures, and its printed form
shape, motion, balance, writhe       measures of single rods
motion_class                         classification of the motion of swimmers
curvature, settling, load, membrane  measures of filaments on their membrane
kymograph                            distribution of energy along growing filaments
swarm                                order, motion, correlations and shapes of many rods
crossings, segment_sweeps            rods that pass through each other
averages                             means of numbers, commonest words
bootstrap                            confidence intervals of statistics over rods
described                            labels of measures
diagnostics, sensing                 the measures of swimmers and of filaments alone
summary                              the table at the end of a run
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["diagnostics", "kymograph", "sensing"])
