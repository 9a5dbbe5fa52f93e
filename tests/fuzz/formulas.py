"""Formulas for membranes from a grammar, most of them with a fault: in x, y, z and parameters, or in t."""

from __future__ import annotations

import random

import tomli_w

from fuzz.hostile import broken_text
from fuzz.scenes import FILAMENTS, SPHERE, TIME

NAMES = ("x", "y", "z", "R", "pi", "t", "__import__", "os", "q", "λ", "None", "e")
NUMBERS = ("0", "1", "2", "0.5", "1e308", "1e-308", "9" * 400, "1j", "0x10", "1_0", "nan", "True", "'a'")
OPERATORS = ("+", "-", "*", "/", "**", "^", "//", "%", "<", "@", " if 1 else ", "and")
FUNCTIONS = ("sqrt", "exp", "log", "sin", "tan", "atan2", "abs", "eval", "__import__", "x")
SURFACE = "x**2 + y**2 + z**2 - R**2"


def formula(rng: random.Random, depth: int, names: tuple[str, ...] = ("x", "y", "z", "R")) -> str:
    """A random formula; one in twenty parts is not allowed."""
    odd = rng.random() < 0.03
    if depth == 0 or rng.random() < 0.2:
        return rng.choice(NAMES + NUMBERS) if odd else rng.choice((*names, "2", "0.5", "pi", "0"))
    inner = (formula(rng, depth - 1, names) for _ in range(2))
    match rng.randrange(6):
        case 0:
            return f"{rng.choice(FUNCTIONS if odd else FUNCTIONS[:5])}({next(inner)})"
        case 1:
            return f"({next(inner)})**{rng.choice(('2', '3', '-1', '0.5', '12', '13', '1e9', next(inner)))}"
        case 2:
            return f"-({next(inner)})"
        case _:
            return f"({next(inner)} {rng.choice(OPERATORS if odd else OPERATORS[:4])} {next(inner)})"


def text(number: int) -> str:
    """The scene with the formula of this number, in TOML."""
    rng = random.Random(f"formula {number}")
    if rng.random() < 0.3:
        surface = SPHERE | {"radius": f"1 + 0*t + {formula(rng, rng.randrange(4), ('t',))}"}
    else:
        depth = rng.choice((1, 2, 3, 4, 5, 40 if rng.random() < 0.05 else 6))
        extra = formula(rng, depth) if depth < 40 else "(" * 200 + "x" + ")" * 200
        phi = SURFACE + rng.choice((f" + 0.001*{extra}", f" + {extra}", "")) if rng.random() < 0.8 else extra
        phi = broken_text(phi, rng) if rng.random() < 0.1 else phi
        size = rng.choice((2.0, 2.0, 2.0, 1e-3, 1e20, 1.0))
        surface = {
            "kind": "expression",
            "phi": phi,
            "box": [[-size, size]] * 3,
            "parameters": {"R": rng.choice((1.0, 1.0, 0.0, -1e20))},
        }
    return tomli_w.dumps({"surface": surface, "filaments": [FILAMENTS], "time": TIME})
