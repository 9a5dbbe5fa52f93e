"""Scenes: what a run simulates, read from TOML or given in Python, checked and frozen. Nothing is built here.

scene                                the whole: ``Scene.load(path)``, ``Scene.parse(text)``, ``Scene(...)``
filaments, swimmers, box, tables     the tables of a scene
ensemble, per_rod                    what the tables of rods have in common
checks                               the base class of tables: every fault in one message
"""

import lazy_loader

__getattr__, _, _ = lazy_loader.attach(__name__, submod_attrs={"scene": ["Scene"]})
