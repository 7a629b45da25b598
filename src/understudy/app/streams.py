"""Standard streams that never fail: closed, full, gone, or unable to spell a file's name.

A command's exit status must not hang on whether its messages could be shown.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from understudy.app.outcome import Interrupted

TERMINATED = 128 + signal.SIGTERM


class Stream:
    """A text stream that goes quiet when it cannot be written.

    Attributes:
        problem: Why it went quiet, or None.
    """

    def __init__(self, inner: Any):
        self.inner = inner
        self.problem: OSError | None = None

    def write(self, text: str) -> int:
        """Write what can be written; characters the encoding lacks are spelled as escapes."""
        if self.problem is None:
            try:
                return self.inner.write(text)
            except UnicodeEncodeError:
                code = getattr(self.inner, "encoding", None) or "ascii"
                return self.write(text.encode(code, "backslashreplace").decode(code))
            except OSError as error:
                self._quiet(error)
        return len(text)

    def flush(self) -> None:
        """Write what is held back."""
        if self.problem is None:
            try:
                self.inner.flush()
            except OSError as error:
                self._quiet(error)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)

    def _quiet(self, error: OSError) -> None:
        """Lead the stream nowhere, so that what it still holds does not fail again at the end."""
        self.problem = error
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.inner.fileno())
            os.close(nowhere)
            self.inner.flush()


@contextmanager
def lasting() -> Iterator[tuple[Stream, Stream]]:
    """Within: standard output and error never raise, also where the caller closed them."""
    before = sys.stdout, sys.stderr
    for number, name in ((0, "stdin"), (1, "stdout"), (2, "stderr")):
        if getattr(sys, name) is None:
            _open_nowhere(number, name)
    out, err = Stream(sys.stdout), Stream(sys.stderr)
    sys.stdout, sys.stderr = out, err  # type: ignore[assignment]
    try:
        yield out, err
    finally:
        out.flush()
        err.flush()
        if all(stream is not None for stream in before):
            sys.stdout, sys.stderr = before


def _open_nowhere(number: int, name: str) -> None:
    """A closed stream leads nowhere; its number is taken, so that no file of ours gets it."""
    with suppress(OSError):
        handle = os.open(os.devnull, os.O_RDWR)
        if handle < number:  # a lower one is closed too: it would be taken next
            os.dup2(handle, number)
            os.close(handle)
        elif handle > number:
            os.close(handle)  # the number is in use after all
    mode = "r" if name == "stdin" else "w"
    setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115, PTH123


@contextmanager
def stoppable() -> Iterator[None]:
    """Within: a request to end (SIGTERM) stops the work as Ctrl-C does."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.getsignal(signal.SIGTERM)
    if before is not signal.SIG_DFL:
        yield
        return

    def stop(*_: object) -> None:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)  # once is enough; the rest is tidying up
        raise Interrupted(status=TERMINATED)

    signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
