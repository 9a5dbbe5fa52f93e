"""The metaclass of public classes, for short help texts."""

from __future__ import annotations

from abc import ABCMeta
from typing import ClassVar


class Documented(ABCMeta):
    """``help`` and ``dir`` of a class show the public members that this package defines, without those of Python.

    Fields of data classes are in the signature. A class may leave out more: ``_unlisted`` names members that serve
    other parts of this package.
    """

    _unlisted: ClassVar[frozenset[str]] = frozenset()

    def __dir__(cls) -> list[str]:
        own = [vars(base) for base in cls.__mro__ if base.__module__.startswith("warp_rods")]
        names = {name for members in own for name in members if not name.startswith("_")}
        return sorted(names - cls._unlisted - getattr(cls, "__dataclass_fields__", {}).keys())
