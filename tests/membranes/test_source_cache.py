"""Sources of formulas that are kept on disk: the same text without SymPy; what is damaged or another is not used."""

import json
import subprocess
import sys

import numpy as np
import pytest

from warp_rods.formula import FormulaError
from warp_rods.membranes import formula_fields, source_cache
from warp_rods.membranes.source_cache import kept_source

PHI = "sqrt(x**2 + y**2 + 0.1) + a*atan2(y, z + 4) + tan(z/5) - R**2*log(x + 9)"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(source_cache, "_folder", lambda: tmp_path / "cache")
    return tmp_path / "cache"


def never() -> str:
    raise AssertionError("a source was written again")


def test_a_source_is_written_once(folder):
    assert kept_source("field", PHI, ("R", "a"), lambda: "one") == "one"
    assert kept_source("field", PHI, ("R", "a"), never) == "one"
    assert [file.suffix for file in folder.iterdir()] == [".json"]


@pytest.mark.parametrize(
    "kind, phi, names", [("rate", PHI, ("R", "a")), ("field", PHI + " + 0", ("R", "a")), ("field", PHI, ("a", "R"))]
)
def test_kind_formula_and_order_of_parameters_tell_sources_apart(folder, kind, phi, names):
    kept_source("field", PHI, ("R", "a"), lambda: "one")
    assert kept_source(kind, phi, names, lambda: "other") == "other"
    assert kept_source("field", PHI, ("R", "a"), never) == "one"


def test_a_source_of_other_programs_is_not_used(folder, monkeypatch):
    kept_source("field", PHI, (), lambda: "one")
    monkeypatch.setattr(source_cache, "_writers", lambda: "a later version")
    assert kept_source("field", PHI, (), lambda: "other") == "other"


def edited(text: str) -> str:
    return json.dumps({**json.loads(text), "source": "exit()"})


DAMAGE = {
    "cut": lambda text: text[: len(text) // 2],
    "empty": lambda text: "",
    "edited": edited,
    "no table": lambda text: "[1, 2]",
    "a part missing": lambda text: json.dumps({k: v for k, v in json.loads(text).items() if k != "sha256"}),
    "of another formula": lambda text: json.dumps({**json.loads(text), "phi": "x"}),
    "nested": lambda text: "[" * 100_000,
    "not text": lambda text: json.dumps({**json.loads(text), "source": 3}),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_source_is_written_again(folder, damage):
    kept_source("field", PHI, (), lambda: "one")
    [file] = folder.iterdir()
    file.write_text(DAMAGE[damage](file.read_text()))
    assert kept_source("field", PHI, (), lambda: "one") == "one"
    assert kept_source("field", PHI, (), never) == "one"


def test_a_cache_that_cannot_be_written_is_no_fault(folder):
    folder.write_text("a file, not a folder")
    assert kept_source("field", PHI, (), lambda: "one") == "one"


def test_refused_formulas_are_not_kept(folder):
    with pytest.raises(FormulaError, match="column"):
        formula_fields.field.__wrapped__("x.y", ())
    assert not folder.exists()


def test_the_second_process_has_the_same_field_without_sympy(tmp_path):
    """And the arguments whose zeros are kinks, and the rate of a moving surface."""
    code = (
        "import sys; from pathlib import Path; import numpy as np\n"
        "from warp_rods.membranes import formula_fields as f, source_cache\n"
        f"source_cache._folder = lambda: Path({str(tmp_path)!r})\n"
        f"a = {PHI!r}, ('R', 'a')\n"
        "print(f.field(*a).key, f.rate(*a).key, f.singular(*a)(np.ones((1, 3)), np.ones(8)))\n"
        "print('sympy' in sys.modules, file=sys.stderr)"
    )
    done = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(2)]
    assert done[0].stdout == done[1].stdout and "field_" in done[0].stdout
    assert [run.stderr.split()[-1] for run in done] == ["True", "False"]


def test_arguments_of_singular_functions_in_numpy(folder):
    """Values and gradients of x² + y² + 0.1, y, y² + (z + 4)², cos(z/5) and x + 9, with parameters in between."""
    x = np.random.default_rng(0).uniform(-1, 1, (5, 3))
    found = formula_fields.singular.__wrapped__(PHI + " + (a*x)**(-1)", ("R", "a"))(x, np.array([2.0, 3.0]))
    (u, v, w), zero = x.T, np.zeros(5)
    expected = [
        (u**2 + v**2 + 0.1, 2 * u, 2 * v, zero),
        (v, zero, zero + 1, zero),
        (v**2 + (w + 4) ** 2, zero, 2 * v, 2 * (w + 4)),
        (np.cos(w / 5), zero, zero, -np.sin(w / 5) / 5),
        (u + 9, zero + 1, zero, zero),
        (u, zero + 1, zero, zero),
    ]
    assert len(found) == len(expected)
    for row in found:
        assert any(np.allclose(row, other, rtol=1e-14, atol=1e-14) for other in expected)
