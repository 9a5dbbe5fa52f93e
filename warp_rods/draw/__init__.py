"""From a trajectory to pictures: ``wr.plot`` draws measures, ``wr.export_usd`` makes an animation.

measured                             the table of plots, one a measure
over_time, distributions,
correlations, maps                   what draws them
plots, figure                        the house style; rods as lit tubes
swarm                                the measures and plots of swarms, by themselves
usd                                  the animation of a run
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["plots", "swarm"])
