"""Signals that end a run: after the first a run finishes its step and saves its state; a second ends it at once.

SIGINT (Ctrl-C), SIGTERM (sent by ``kill`` and by batch systems before a time limit) and SIGHUP (a closed terminal).
"""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType
from typing import Any, NoReturn

__all__ = ["Interrupted", "Interruption", "end_process", "signals_end_the_process"]

SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Interrupted(SystemExit):
    """A signal that ends the process, with the exit code of a shell: 128 and its number."""

    def __init__(self, number: int):
        super().__init__(128 + number)
        self.name, self.told = signal.Signals(number).name, False


class _Handlers:
    """Handlers of the signals that would end the process, and what they replaced; used in the main thread only."""

    def __init__(self) -> None:
        self._before: dict[int, Any] = {}
        self._installed = False

    def install(self, handler: Any) -> None:
        """Handle signals, but not those that the caller ignores, as under ``nohup``, or handles himself."""
        if threading.current_thread() is not threading.main_thread():
            return
        self._installed = True
        for number in SIGNALS:
            if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler, end_process):
                self._before[number] = signal.signal(number, handler)

    def let_the_next_one_end(self) -> None:
        """The next signal ends the process at once; SIGINT raises KeyboardInterrupt if it did so before."""
        for number, before in self._before.items():
            signal.signal(number, before if before is signal.default_int_handler else signal.SIG_DFL)

    def remove(self) -> None:
        """Put the handlers back that were there before."""
        if self._installed:
            self._installed = False
            for number, before in self._before.items():
                signal.signal(number, before)

    def raises_keyboard_interrupt(self, number: int) -> bool:
        """Whether a caller in Python expects KeyboardInterrupt."""
        return number == signal.SIGINT and self._before.get(number) is signal.default_int_handler


class Interruption:
    """A context in which the first signal is noted in ``number``, so that a loop can end where its state is whole.

    The next signal ends the process at once. On leaving, the handlers from before are back.
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self._handlers = _Handlers()

    def __enter__(self) -> Interruption:
        self._handlers.install(self._note)
        return self

    def __exit__(self, *_exception: object) -> None:
        self._handlers.remove()

    def _note(self, number: int, _frame: FrameType | None) -> None:
        self.number = number
        self._handlers.let_the_next_one_end()

    def over(self) -> None:
        """Leave the context early, as there is nothing more to be kept whole; a signal noted meanwhile acts now."""
        self._handlers.remove()
        if self.number is not None:
            self.end()

    def end(self) -> NoReturn:
        """Raises what the signal noted means: KeyboardInterrupt for SIGINT in Python, else Interrupted."""
        assert self.number is not None
        if self._handlers.raises_keyboard_interrupt(self.number):
            raise KeyboardInterrupt
        raise Interrupted(self.number)


def end_process(number: int, _frame: FrameType | None) -> NoReturn:
    """A handler that ends what the process does by an exception, so that files are closed; the next signal is final."""
    for each in SIGNALS:
        if signal.getsignal(each) is end_process:
            signal.signal(each, signal.SIG_DFL)
    raise Interrupted(number)


@contextlib.contextmanager
def signals_end_the_process() -> Iterator[None]:
    """A context in which a signal raises Interrupted wherever the process is."""
    handlers = _Handlers()
    handlers.install(end_process)
    try:
        yield
    finally:
        handlers.remove()
