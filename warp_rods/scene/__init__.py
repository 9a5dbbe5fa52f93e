"""Scenes: what a run simulates, read from TOML or defined in Python, checked and frozen. Builds nothing.

scene                                the whole scene: ``Scene.load(path)``, ``Scene.parse(text)``, ``Scene(...)``
filaments, swimmers, box, tables     the tables of a scene
shapes                               kinds of shape at the start
flagella                             activity laws and profiles of swimmers
ensemble, per_rod                    common parts of the tables of rods
checks                               the base class of tables: every fault in one message
"""

import lazy_loader

__getattr__, _, _ = lazy_loader.attach(__name__, submod_attrs={"scene": ["Scene"]})
