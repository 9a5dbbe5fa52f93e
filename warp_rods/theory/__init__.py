"""Theory: linear stability, fixed shapes and their bifurcations, buckling of growing filaments.

stability, airy, elements            growth rates and critical stiffnesses of straight swimmers
twisted_stability                    growth rates of straight swimmers twisted by an active moment
tension                              the tension as a series (C.1)
symmetry                             the symmetry under rotation by π (C.4)
steady, steady_equations             fixed shapes of swimmers by Newton's method, and their eigenvalues
floquet                              growth of what breaks the symmetry of a periodic motion
continuation                         branches of fixed shapes: folds, Hopf bifurcations and branch points
buckling                             equilibria of clamped filaments, and the length at which they buckle
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, submodules=["buckling", "continuation", "stability", "steady"]
)
