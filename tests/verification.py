"""The verification: tests that compare a number with a reference, and the report of them, ``docs/verification.md``.

A test that asks for the fixture ``verified`` belongs to the verification. Each call gives kind, name, measured value,
reference and tolerance, records them and asserts:

    verified("exact", "decay of a beam mode", measured=rate, expected=exact, relative=5e-3, reference="(b/η) x₀⁴")
    verified.order("order in Δt", measured=slope, reference="successive differences")
    verified.below("conservation", "momentum", measured=error, bound=1e-12, reference="third law")
    verified.same("a restored rod", found, expected, reference="a run without a stop")

Without options these are tests like all others. ``python -m pytest --validate`` runs all of them, the long ones as
well, and nothing else, and writes the report (``verification_report.py``).
"""

from collections import Counter
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pytest
from verification_report import KINDS, Row, written

NOT_LONG = "not long"
"""The selection of ``addopts`` in pyproject.toml."""
PROPERTY = "verified"
NAMES = pytest.StashKey[dict[str, str]]()
REPORT = pytest.StashKey["Collected"]()


class Verified:
    """Compares measured values of one test with references; see the module."""

    def __init__(self, node: pytest.Item, device: str):
        self._node, self._suffix = node, "" if device == "cpu" else f" ({device})"

    def __call__(
        self,
        kind: str,
        name: str,
        *,
        measured: Any,
        expected: Any,
        within: float | None = None,
        relative: float | None = None,
        reference: str,
    ) -> None:
        """|measured − expected| ≤ ``within``, or ``relative`` times |expected|; of arrays the worst entry counts."""
        assert (within is None) != (relative is None), "give either within or relative"
        found, target = np.broadcast_arrays(np.asarray(measured, float), np.asarray(expected, float))
        allowed = np.broadcast_to(within if relative is None else relative * np.abs(target), found.shape)
        apart = np.abs(found - target)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(apart == 0, 0.0, apart / allowed)
        worst = int(np.argmax(np.where(np.isnan(share), np.inf, share)))
        values = [float(part.ravel()[worst]) for part in (found, target, allowed)]
        self._record(kind, name, reference, bool(np.all(apart <= allowed)), found.size, *values)

    def below(self, kind: str, name: str, *, measured: Any, bound: float, reference: str) -> None:
        """An error, which is zero or positive, is at most ``bound``; of arrays the largest."""
        errors = np.atleast_1d(np.asarray(measured, float))
        passed = bool(np.all((errors >= 0) & (errors <= bound)))
        self._record(kind, name, reference, passed, errors.size, float(np.max(errors)), None, float(bound))

    def order(self, name: str, *, measured: Any, expected: float = 2.0, within: float = 0.2, reference: str) -> None:
        """A fitted order of accuracy."""
        self("orders", name, measured=measured, expected=expected, within=within, reference=reference)

    def same(self, name: str, found: Any, expected: Any, *, reference: str) -> None:
        """All bits agree: of two arrays, or of two mappings from names to arrays."""
        pairs = _pairs(found, expected)
        values = sum(np.size(a) for a, _ in pairs)
        assert values > 0, "nothing to compare"
        differing = sum(_differing(a, b) for a, b in pairs if a.size or b.size)
        self._record("determinism", name, f"{reference} ({values} values)", differing == 0, 1, differing, 0.0, 0.0)

    def _record(
        self, kind: str, name: str, reference: str, passed: bool, count: int, measured, expected, allowed
    ) -> None:
        assert kind in KINDS, f"kind = {kind!r}: must be one of {', '.join(KINDS)}"
        name += self._suffix
        names = self._node.config.stash.setdefault(NAMES, {})
        assert name not in names, f"{name!r}: already the name of a check in {names[name]}"
        names[name] = self._node.nodeid
        row = Row(kind, name, reference, measured, expected, allowed, count, passed, self._node.nodeid)
        self._node.user_properties.append((PROPERTY, row._asdict()))
        assert passed, f"{name}: {row.shown}, {row.tolerance}; reference: {reference}"


def _pairs(found: Any, expected: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    if isinstance(expected, Mapping):
        assert found.keys() == expected.keys()
        return [(np.asarray(found[key]), np.asarray(expected[key])) for key in expected]
    return [(np.asarray(found), np.asarray(expected))]


def _differing(a: np.ndarray, b: np.ndarray) -> int:
    """Number of values that differ in a bit."""
    assert a.shape == b.shape and a.dtype == b.dtype, (a.shape, b.shape, a.dtype, b.dtype)
    one, other = (np.frombuffer(values.tobytes(), np.uint8).reshape(values.size, -1) for values in (a, b))
    return int(np.any(one != other, axis=1).sum())


@pytest.fixture
def verified(request) -> Verified:
    """Records and asserts comparisons with references; tests that use it are those of ``--validate``."""
    device = request.getfixturevalue("device") if "device" in request.fixturenames else "cpu"
    return Verified(request.node, device)


# --- selection and report -------------------------------------------------------------------------------------------


class Selection(NamedTuple):
    """Tests of the verification that were found, and that were selected."""

    found: int = 0
    selected: int = 0


class Collected:
    """What the controlling process learns of the checks while tests run."""

    def __init__(self, config: pytest.Config):
        self.config, self.selection = config, Selection()
        self.rows: list[Row] = []
        self.broken: list[str] = []
        self.seen: set[str] = set()

    def add(self, report: pytest.TestReport) -> None:
        """The rows of a test, or its name if it failed without a row that says why."""
        self.seen.add(report.nodeid)
        if report.when == "call":
            rows = [Row(**row) for name, row in report.user_properties if name == PROPERTY]
            self.rows += rows
            if report.failed and all(row.passed for row in rows):
                self.broken.append(report.nodeid)
        elif report.failed:
            self.broken.append(report.nodeid)

    @property
    def twice(self) -> list[str]:
        """Names that several checks have."""
        return [name for name, count in Counter(row.name for row in self.rows).items() if count > 1]

    @property
    def missing(self) -> str:
        """Why this was not the whole verification, if it was not."""
        if self.config.args_source is not pytest.Config.ArgsSource.TESTPATHS:
            return "only a part of the tests was asked for"
        if self.selection.selected < self.selection.found:
            return f"{self.selection.selected} of {self.selection.found} tests were selected"
        if len(self.seen) < self.selection.selected:
            return f"{len(self.seen)} of {self.selection.selected} tests were run"
        return ""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--validate", action="store_true", help="run the verification and write docs/verification.md")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[REPORT] = Collected(config)
    if config.getoption("validate") and config.option.markexpr == NOT_LONG:
        config.option.markexpr = ""


@pytest.hookimpl(wrapper=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]):
    """Leave out the tests that do not belong to the verification, before options leave out others."""
    if not config.getoption("validate"):
        return (yield)
    kept = [item for item in items if PROPERTY in getattr(item, "fixturenames", ())]
    config.hook.pytest_deselected(items=[item for item in items if item not in set(kept)])
    items[:] = kept
    result = yield
    selection = Selection(len(kept), len(items))
    config.stash[REPORT].selection = selection
    if hasattr(config, "workeroutput"):
        config.workeroutput[PROPERTY] = tuple(selection)
    return result


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node) -> None:
    """All workers find the same tests."""
    if given := getattr(node, "workeroutput", {}).get(PROPERTY):
        node.config.stash[REPORT].selection = Selection(*given)


class Listener:
    """Passes reports of tests on; registered in the controlling process only."""

    def __init__(self, collected: Collected):
        self._collected = collected

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._collected.add(report)


def pytest_sessionstart(session: pytest.Session) -> None:
    if not hasattr(session.config, "workerinput"):
        session.config.pluginmanager.register(Listener(session.config.stash[REPORT]), "verification-listener")


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    if not hasattr(session.config, "workerinput") and session.config.stash[REPORT].twice:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter, config: pytest.Config) -> None:
    collected = config.stash[REPORT]
    for name in collected.twice:
        terminalreporter.write_line(f"verification: {name!r} is the name of more than one check", red=True)
    if not config.getoption("validate"):
        return
    path = config.rootpath / "docs" / "verification.md"
    shown, failed = path.relative_to(config.rootpath), sum(not row.passed for row in collected.rows)
    said = f"verification: {len(collected.rows)} checks, {failed} failed, {len(collected.broken)} tests without a value"
    if collected.missing:
        terminalreporter.write_line(f"{said}; {shown} is left as it is: {collected.missing}", yellow=True)
        return
    path.parent.mkdir(exist_ok=True)
    path.write_text(written(collected.rows, collected.broken, config.rootpath), encoding="utf-8")
    terminalreporter.write_line(f"{said}: {shown}")
