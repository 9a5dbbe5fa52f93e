"""Every benchmark runs to its end; here with few rods and steps, so that its figures mean nothing."""

import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent / "benchmarks"
SMALL = {
    "banded": {"BATCHES": (1, 2), "SECONDS": 1e-3},
    "free_rods": {"STEPS": {1: 2, 3: 2}, "REPEATS": 1},
    "proteins": {},
    "steps": {"TOLERANCES": (0.1,), "STEPS": (2e-2,), "NODES": (17, 33), "FINEST": 33, "PAGE": None},
    "swarm": {"COUNTS": (20, 40), "STEPS": 2, "REPEATS": 1},
}


def test_every_benchmark_is_run_here():
    assert {path.stem for path in FOLDER.glob("*.py")} == set(SMALL)


@pytest.mark.parametrize("name", [n for n in SMALL if n != "proteins"])
def test_a_benchmark_prints_a_table(name, capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", [name])
    main = runpy.run_path(str(FOLDER / f"{name}.py"))["main"]
    main.__globals__.update(SMALL[name])
    main()
    rows = [line.split()[-1] for line in capsys.readouterr().out.splitlines()]
    assert sum(last.replace(".", "").isdigit() for last in rows) >= 2  # two rows that end with a number


@pytest.mark.long
def test_the_protein_benchmark_reaches_the_end_of_the_run(capsys):
    runpy.run_path(str(FOLDER / "proteins.py"))["main"]()
    assert "end of the run: step" in capsys.readouterr().out
