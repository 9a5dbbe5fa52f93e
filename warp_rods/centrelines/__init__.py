"""Measured centre lines: files → points → a smooth line → strains of a rod, free or on a membrane.

readers                the table of file formats: one row of ``READERS`` for each
table, wcon, swc       readers of one format each
track                  what a reader returns, and what readers share
points                 cleaning: missing and repeated points, gaps
curve                  a smoothing spline of stated width, and its arc length
rod                    Bishop strains along a curve, and the rod that has them
centreline             ``from_centreline``: the strains and the place of a free rod
on_membrane            the same for a filament on a membrane
"""
