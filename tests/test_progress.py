"""The progress bar: all items come once, and it is shown on terminals only."""

from types import SimpleNamespace

import pytest

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


def test_the_bar_starts_within_the_loop(monkeypatch):
    """With seconds 0, 1, 2, 3, … the bar starts at the third item, and every item comes once."""
    seconds = iter(range(100))
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: next(seconds)))
    assert list(progress.with_progress("abcdef", "letters")) == list("abcdef")
    assert list(progress.with_progress([], "nothing")) == []
