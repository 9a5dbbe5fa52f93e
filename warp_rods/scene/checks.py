"""The base class of the tables of a scene: pydantic checks each value, and one message names every fault."""

from __future__ import annotations

from collections import Counter
from inspect import Parameter, Signature, cleandoc
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from warp_rods.errors import SceneError
from warp_rods.scene.parameters import known_within, unused
from warp_rods.scene.per_rod import TAGS
from warp_rods.values import hint, key_path, must_be, nearest, plain

__all__ = ["Faults", "Table", "fault", "meant", "read_table"]

Faults = list[InitErrorDetails]

MOST_VALUES_NAMED = 5
"""Largest number of wrong values of one list that are named; the others are counted."""


def fault(loc: tuple, value: Any, text: str) -> InitErrorDetails:
    """A fault; its line in the message is the key path ``loc`` followed by ``text``."""
    return InitErrorDetails(type=PydanticCustomError("fault", "{text}", {"text": text}), loc=loc, input=value)


def _own_members(table: type[BaseModel]) -> list[str]:
    """The members that classes of this package define; ``help`` shows these without those of pydantic."""
    ours = [vars(base) for base in table.__mro__ if issubclass(base, Table)]
    return sorted({name for members in ours for name in members if not name.startswith(("_", "model_"))})


_Described: Any = type("_Described", (type(BaseModel),), {"__dir__": _own_members})
"""The metaclass of tables; limits ``dir`` and thus ``help`` to their own members."""


def meant(field: FieldInfo) -> str:
    """What a key means, where its field says so, and what is allowed: "twist stiffness …: a positive number"."""
    return ": ".join(filter(None, (field.title, field.description)))


class Table(BaseModel, metaclass=_Described):  # type: ignore[misc]
    """A table of a scene: frozen, without unknown keys.

    The title of a field says in a few words what it means, with its symbol or dimension; its description, which is also
    part of error messages, what is allowed.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    @classmethod
    def __pydantic_init_subclass__(cls, **_kwargs: Any) -> None:
        """Add what keys mean, and what is allowed, to the docstring; remove types of pydantic from the signature."""
        fields = cls.model_fields
        keys = [f"{name}: {meant(field)}" for name, field in fields.items()]
        cls.__doc__ = "\n".join([f"{cleandoc(cls.__doc__ or '')}\n", *keys])
        cls.__signature__ = Signature(
            [Parameter(name, Parameter.KEYWORD_ONLY, default=_default(field)) for name, field in fields.items()]
        )

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The table with the defaults that depend on other keys."""
        return data

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        """Faults of several keys together: ``raw`` is the table as given, ``good`` the keys without own faults."""
        return []

    @model_validator(mode="wrap")
    @classmethod
    def _checked(cls, data: Any, handler: Any) -> Any:
        raw = plain(data)
        if "parameters" not in cls.model_fields:
            return cls._every_fault(raw, handler)
        with known_within(raw):
            return cls._every_fault(raw, handler)

    @classmethod
    def _every_fault(cls, raw: Any, handler: Any) -> Any:
        faults, made = list[InitErrorDetails](), None
        if isinstance(raw, dict):
            raw = cls.filled(raw)
        try:
            made = handler(raw)
        except ValidationError as error:
            faults = cls._worded_faults(error.errors(include_url=False))
        if isinstance(raw, dict):
            bad = {line["loc"][0] for line in faults}
            faults += cls.cross_faults(raw, {key: raw[key] for key in raw if key not in bad})
        if not faults and "parameters" in cls.model_fields:
            faults += [fault(("parameters", name), raw, ": occurs in none of the formulas here") for name in unused()]
        if faults:
            raise ValidationError.from_exception_data(cls.__name__, faults)
        return made

    @classmethod
    def _worded_faults(cls, errors: list[ErrorDetails]) -> Faults:
        """Faults for the errors of this table, a limited number for each key; nested tables have theirs already."""
        found, named = dict[Any, InitErrorDetails](), Counter[Any]()
        for error in errors:
            worded = cls._worded_fault(error)
            key = worded["loc"][:1]
            named[key] += error["type"] != "fault"
            if named[key] <= MOST_VALUES_NAMED:
                found.setdefault((worded["loc"], str(worded["type"])), worded)
        faults = list(found.values())
        for key, count in named.items():
            if count > MOST_VALUES_NAMED:
                text = f": {count - MOST_VALUES_NAMED} more of its values are wrong"
                faults.append(fault(key, None, text))
        return faults

    @classmethod
    def _worded_fault(cls, error: ErrorDetails) -> InitErrorDetails:
        kind, value = error["type"], error["input"]
        loc = tuple(part for part in error["loc"] if part not in TAGS)
        if kind == "fault":
            return fault(loc, value, error["msg"])
        if not loc:
            return InitErrorDetails(type=PydanticCustomError("no_table", ""), loc=loc, input=value)
        known = cls.model_fields
        if kind == "extra_forbidden":
            return fault(loc, value, f": unknown key{nearest(loc[0], known)}; known here: {', '.join(known)}")
        if kind == "missing" and len(loc) == 1:
            value = None
        elif kind == "missing":  # the last numbers of a list that is too short
            loc = loc[:-1]
        allowed = known[str(loc[0])].description or ""
        note = error["msg"] if kind == "note" else hint(kind, value)
        return fault(loc, value, must_be(allowed, value, note))


T = TypeVar("T", bound=Table)


def _default(field: FieldInfo) -> Any:
    return Parameter.empty if field.is_required() else field.get_default(call_default_factory=True)


def read_table(table: type[T], given: Any, *path: str | int) -> T:
    """A table from a mapping in Python; raises SceneError with one line for each fault, after ``path``."""
    try:
        return table.model_validate(plain(given))
    except ValidationError as error:
        lines = [key_path((*path, *line["loc"])) + line["msg"] for line in error.errors(include_url=False)]
        raise SceneError("\n".join(lines)) from None
