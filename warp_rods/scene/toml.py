"""Scenes as TOML text: the writer (the standard library only reads)."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def literal(value: Any) -> str:
    """One value as TOML on one line; what TOML has no word for is shown as Python shows it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON's escapes are TOML's, but for DEL, which TOML wants escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(literal, value)) + "]"
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_line(key, item) for key, item in value.items()) + " }"
    return repr(value)


def document(tables: Mapping[str, Any]) -> str:
    """TOML text of a mapping of plain values, tables and lists of tables; tables within those are inline."""
    lines = [_line(key, value) for key, value in tables.items() if not _is_table(value)]
    for key, value in tables.items():
        if isinstance(value, Mapping):
            lines += ["", f"[{key}]", *(_line(*item) for item in value.items())]
        elif _is_table(value):
            for table in value:
                lines += ["", f"[[{key}]]", *(_line(*item) for item in table.items())]
    return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:
    is_list_of_tables = isinstance(value, (list, tuple)) and all(isinstance(v, Mapping) for v in value)
    return isinstance(value, Mapping) or is_list_of_tables


def bare_or_quoted(key: str) -> str:
    """A key as TOML wants it."""
    return key if BARE_KEY.fullmatch(key) else literal(key)


def _line(key: str, value: Any) -> str:
    return f"{bare_or_quoted(key)} = {literal(value)}"
