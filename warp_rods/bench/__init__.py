"""Benchmarks: what a simulation costs, beside other codes measured in turns with it in the same process.

``warp-rods bench`` runs the table in ``catalogue.py`` and writes ``benchmarks/RESULTS.md``. Figures are CPU time of one
core. Other codes are in ``peers``; each is left out, with the line that installs it, where it is missing.
"""
