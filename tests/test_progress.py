"""The progress bar: all items come once, and it is shown on terminals only."""

import io
import re
import time
from types import SimpleNamespace

import pytest
from rich.console import Console

from warp_rods import progress


@pytest.mark.parametrize(("wait", "terminal", "shown"), [(-1.0, True, True), (-1.0, False, False), (9.0, True, False)])
def test_a_bar_is_shown_on_a_terminal_after_a_while(monkeypatch, capsys, wait, terminal, shown):
    monkeypatch.setattr(progress, "WAIT", wait)
    monkeypatch.setenv("FORCE_COLOR", "1" if terminal else "")  # then rich treats a captured stream as a terminal
    assert list(progress.with_progress(range(5), "counting")) == [0, 1, 2, 3, 4]
    written = capsys.readouterr()
    assert not written.out
    assert ("counting" in written.err) is shown
    assert shown or not written.err


@pytest.fixture
def log(monkeypatch) -> Console:
    """A console that is no terminal, with a line every 0.05 s."""
    monkeypatch.setattr(progress, "LINE_EVERY", 0.05)
    monkeypatch.setattr(progress, "WAIT", 0.05)
    return Console(file=io.StringIO(), markup=False, highlight=False)


def test_without_a_terminal_lines_tell_how_much_is_done_and_left(log):
    with progress.Bar("running", 200, log, done=100) as bar:
        bar.update(150, "3 rod-steps/s")
        time.sleep(0.3)
    lines = log.file.getvalue().splitlines()
    assert 2 <= len(lines) <= 6  # also while nothing is updated, as one step may take longer
    assert all(re.fullmatch(r"running: 75 % done, about \d+ s left, 3 rod-steps/s", line) for line in lines)
    time.sleep(0.2)
    assert log.file.getvalue().splitlines() == lines


def test_waiting_tells_that_something_goes_on(log):
    with progress.waiting("placing rods", log):
        time.sleep(0.2)
    assert re.match(r"(placing rods: 0 s so far\n)+$", log.file.getvalue())
    with progress.waiting("placing rods", log):
        before = log.file.getvalue()
    time.sleep(0.1)
    assert log.file.getvalue() == before


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        *((0.2, "0 s"), (40, "40 s"), (80, "80 s"), (200, "3.3 min"), (600, "10 min"), (9000, "2.5 h"), (10800, "3 h")),
        *((1e5, "28 h"), (3e5, "3.5 days"), (1e10, "320 years")),
    ],
)
def test_durations_in_words(seconds, said):
    assert progress.in_words(seconds) == said


def test_the_bar_starts_within_the_loop(monkeypatch):
    """With seconds 0, 1, 2, 3, … the bar starts at the third item, and every item comes once."""
    seconds = iter(range(100))
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: next(seconds)))
    assert list(progress.with_progress("abcdef", "letters")) == list("abcdef")
    assert list(progress.with_progress([], "nothing")) == []
