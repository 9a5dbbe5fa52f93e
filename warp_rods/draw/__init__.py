"""From a trajectory to pictures: ``wr.plot`` draws measures, ``wr.export_usd`` makes an animation.

measured                             the table of plots, one for each measure
over_time, distributions,
correlations, maps                   the functions that draw them
plots, figure, style, tubes          the house style; rods drawn as shaded tubes
swarm                                the measures and plots of swarms alone
exporters, export                    the table of exporters, and the command that takes its options from it
content, rods, sheet, selection      what of a run is drawn: the same for all exporters
colours, scale                       the table of quantities that colour rods, and their ranges
view, picture, lettering             pictures: from where, the drawing, what is written on them
poster, film                         pictures of a run, and films
usd, tube_mesh                       the animation of a run; rods as meshes
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["plots", "swarm"])
