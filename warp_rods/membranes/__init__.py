"""Membranes: surfaces φ(x) = 0, built in, from a formula, a grid or a mesh; at rest or moving.

surfaces                             make a surface: ``make("sphere", {"radius": 1.0})``
surface                              the class: φ, its derivatives, normals, curvature, at points
built_in, expression, grid           kinds of surface: how their values are read, the field that they make
catalogue                            the table of all kinds
motion                               surfaces that change with time
inspection                           whether a φ of a user gives a surface for rods
mesh, sampling                       a surface as triangles; random points on it
symbolic, field_source               from a formula to a compiled field
files, distance, spline              from a file to a field
level_set                            what all kinds come down to
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["surfaces"])
