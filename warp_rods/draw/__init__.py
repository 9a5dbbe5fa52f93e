"""From a trajectory to pictures: ``wr.plot`` draws measures, ``wr.export_usd`` makes an animation.

measured                             the table of plots, one for each measure
over_time, distributions,
correlations, maps                   the functions that draw them
plots, figure, style, tubes          the house style; rods drawn as shaded tubes
swarm                                the measures and plots of swarms alone
exporters                            the table of exporters: files for other programs
usd                                  the animation of a run
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["plots", "swarm"])
