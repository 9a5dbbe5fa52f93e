"""The fixture ``verified`` and the report: what is recorded, selected, shown as failed, and written."""

from pathlib import Path

import numpy as np
import pytest
from verification import Verified, _differing
from verification_report import Row

TESTS = Path(__file__).parent
SUITE = """
import pytest

def test_one(verified):
    verified("exact", "a number", measured=[3.0, 3.1], expected=3.0, within=0.2, reference="x | y")
    verified.below("constraint", "an error", measured=1e-15, bound=1e-14, reference="zero")

@pytest.mark.long
def test_two(verified):
    verified.order("an order", measured=1.98, reference="three grids")
    verified.same("some bits", [1.0, 2.0], [1.0, 2.0], reference="themselves")

def test_of_something_else():
    assert True
"""
FAILS = """
def test_three(verified):
    verified("published", "not so", measured=1.0, expected=2.0, relative=0.1, reference="two")

def test_four(verified):
    raise RuntimeError
"""


@pytest.fixture
def suite(pytester, monkeypatch):
    """A folder with tests of its own; ``-m "not long"`` as here."""
    monkeypatch.syspath_prepend(TESTS)
    monkeypatch.setenv("PYTHONPATH", str(TESTS))
    pytester.makeini(
        "[pytest]\ntestpaths = tests\nmarkers =\n    long: slow\naddopts = -m 'not long' -p no:cacheprovider"
    )
    pytester.mkdir("tests")
    pytester.path.joinpath("tests", "conftest.py").write_text('pytest_plugins = ("verification",)\n')

    def run(text, *options):
        pytester.path.joinpath("tests", "test_some.py").write_text(text)
        start = pytester.runpytest_subprocess if "-n" in options else pytester.runpytest_inprocess
        found = start(*options)
        report = pytester.path / "docs" / "verification.md"
        return found, report.read_text(encoding="utf-8") if report.exists() else ""

    return run


@pytest.mark.parametrize(
    "workers", [(), pytest.param(("-n", "2"), marks=pytest.mark.long)], ids=["one process", "workers"]
)
def test_all_checks_are_run_and_reported(suite, workers):
    done, report = suite(SUITE, "--validate", *workers)
    done.assert_outcomes(passed=2, deselected=0 if workers else 1)
    assert "**4 checks, none failed.**" in report and "Made on " in report
    for line in (
        "| [a number](../tests/test_some.py) | x \\| y | 3 ± 0.2 | 3.1 (worst of 2) | passed |",
        "| [an error](../tests/test_some.py) | zero | ≤ 1e-14 | 1e-15 | passed |",
        "| [an order](../tests/test_some.py) | three grids | 2 ± 0.2 | 1.98 | passed |",
        "| [some bits](../tests/test_some.py) | themselves (2 values) | 0, exactly | 0 | passed |",
    ):
        assert line in report
    assert str(TESTS) not in report and "/tmp" not in report


def test_without_the_option_they_are_tests_like_others(suite):
    done, report = suite(SUITE)
    done.assert_outcomes(passed=2, deselected=1)
    assert not report


def test_failures_are_shown_as_failed(suite):
    done, report = suite(SUITE + FAILS, "--validate")
    done.assert_outcomes(passed=2, failed=2, deselected=1)
    assert "**5 checks, 1 failed.** **1 tests failed without a value.**" in report
    row = "| [not so](../tests/test_some.py) | two | 2 ± 0.2 | 1 | **failed** |"
    assert report.count(row) == 2  # first, and beside the others of its kind
    assert report.index("## Checks that failed") < report.index(row) < report.index("## Exact answers")
    assert "- **failed**: `tests/test_some.py::test_four`" in report


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("-k", "one"), "1 of 2 tests were selected"),
        (("tests/test_some.py",), "only a part of the tests was asked for"),
        (("-x",), "1 of 4 tests were run"),
    ],
)
def test_a_part_is_not_written(suite, options, said):
    text = FAILS + SUITE if options == ("-x",) else SUITE
    done, report = suite(text, "--validate", *options)
    assert not report
    done.stdout.fnmatch_lines(f"*docs/verification.md is left as it is: {said}*")


def test_a_name_is_used_once(suite):
    done, _ = suite(SUITE + SUITE.replace("test_one", "test_again"))
    done.assert_outcomes(passed=2, failed=1, deselected=1)
    done.stdout.fnmatch_lines("*'a number': already the name of a check in tests/test_some.py::test_one*")


class Node:
    """A test by itself."""

    def __init__(self):
        self.nodeid, self.user_properties = "tests/test_some.py::test_one", []
        self.config = type("Config", (), {"stash": pytest.Stash()})()


def test_what_passes_and_what_does_not():
    checks, name = Verified(Node(), "cpu"), iter(range(100))

    def passes(check, *kind, **values):
        try:
            check(*kind, str(next(name)), **values, reference="r")
        except AssertionError:
            return False
        return True

    assert passes(checks, "exact", measured=1.1, expected=1.0, within=0.11)
    assert not passes(checks, "exact", measured=0.88, expected=1.0, within=0.11)
    assert passes(checks, "exact", measured=[-2.1, 4.1], expected=[-2.0, 4.0], relative=0.06)
    assert not passes(checks, "exact", measured=[2.0, np.nan], expected=2.0, within=0.1)
    assert not passes(checks, "exact", measured=np.inf, expected=2.0, relative=0.1)
    assert passes(checks, "exact", measured=3, expected=3, within=0)
    assert not passes(checks.below, "exact", measured=np.nan, bound=1.0)
    assert not passes(checks.below, "exact", measured=-1.0, bound=1.0)
    assert not passes(checks.below, "exact", measured=[0.0, 2.0], bound=1.0)
    assert not passes(checks.order, measured=[2.0, 2.3])
    assert not passes(checks, "beauty", measured=1.0, expected=1.0, within=0.1)
    assert not passes(checks, "exact", measured=1.0, expected=1.0)
    assert passes(checks.same, found={"x": np.array([1.0, np.nan])}, expected={"x": np.array([1.0, np.nan])})
    assert not passes(checks.same, found=np.array([1.0]), expected=np.array([np.nextafter(1.0, 2.0)]))
    assert not passes(checks.same, found=np.array([0.0]), expected=np.array([-0.0]))
    assert not passes(checks.same, found=np.zeros(0), expected=np.zeros(0))
    assert _differing(np.array([1, 2, 3]), np.array([1, 0, 0])) == 2


def test_differences_as_large_as_the_tolerance_are_shown():
    row = Row("exact", "n", "r", 0.848651, 0.848642, 8.5e-5, 1, True, "t")
    assert (row.shown, row.tolerance) == ("0.848651", "0.848642 ± 8.5e-05")
