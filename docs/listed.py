"""The reference shows what ``dir`` of a public class shows (``warp_rods/documented.py``): an extension of Griffe."""

from __future__ import annotations

import ast
from importlib import import_module
from typing import Any

import griffe

from warp_rods.documented import Documented


class Listed(griffe.Extension):
    """Leaves out the members of documented classes that serve other parts of the package."""

    def on_class_members(self, *, node: ast.AST, cls: griffe.Class, **_: Any) -> None:
        shown = getattr(import_module(cls.module.path), cls.name, None)
        if not isinstance(shown, Documented):
            return
        for name in set(cls.members) - set(dir(shown)) - {"__init__"}:
            cls.del_member(name)
