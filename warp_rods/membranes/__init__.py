"""Membranes: surfaces φ(x) = 0, built in, from a formula, a grid or a mesh; at rest or moving.

surfaces                             make a surface: ``make("sphere", {"radius": 1.0})``
surface                              the class: φ, its derivatives, normals and curvature at points
built_in, expression, grid           kinds of surface: their parameters and their fields
catalogue                            the table of all kinds
motion                               surfaces that change with time
inspection                           checks that a φ given by the user defines a surface for rods
mesh, sampling                       triangulation of a surface; random points on it
formula_fields, source_cache         compiled fields of formulas; their sources, kept on disk
symbolic, field_source               from a formula to its source: derivatives by SymPy
images, mesh_file, files             read stacks and meshes
voxels, triangles, bodies            from voxels to triangles; their shape; their bodies
distance, fit, comparison, data      from triangles to a smooth field, and what that changed
kept                                 the field of a file as a run keeps it in its folder
level_set                            the common representation of all kinds
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["surfaces"])
