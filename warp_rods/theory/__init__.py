"""Theory beside the simulation: linear stability, fixed shapes and how they end, buckling of growing filaments.

stability, airy, elements            growth rates and critical stiffnesses of straight swimmers
twisted_stability                    of swimmers that an active moment twists
tension                              the tension as a series (C.1)
symmetry                             the symmetry of rotation by π (C.4)
steady, steady_equations             fixed shapes of swimmers by Newton"s method, and their eigenvalues
continuation                         fixed shapes followed in a parameter: folds, Hopf and branch points
buckling                             clamped filaments at rest, and the length at which they buckle
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, submodules=["buckling", "continuation", "stability", "steady"]
)
