"""Run one function over many items, in this process or in several, one result as each finishes.

A worker that dies, as the system kills one that takes too much memory, costs only its own item:
the others are tried again, each in a process of its own.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

In = TypeVar("In")
Out = TypeVar("Out")


def each(
    function: Callable[[In], Out], items: Sequence[In], *, jobs: int
) -> Generator[tuple[int, Out | None]]:
    """Yield (index of the item, its result) in the order they finish; None where a worker died.

    With `jobs` > 1 the function must be importable by name and must not raise (most exceptions do
    not survive the way back), and items and results must be picklable. `KeyboardInterrupt` ends
    the workers and goes on.
    """
    if jobs <= 1 or len(items) <= 1:
        for index, item in enumerate(items):
            yield index, function(item)
        return
    lost: list[int] = []
    for index, result in _pooled(function, dict(enumerate(items)), jobs):
        if result is None:
            lost.append(index)
        else:
            yield index, result
    for index in lost:
        yield from _pooled(function, {index: items[index]}, 1)


def _pooled(
    function: Callable[[In], Out], items: dict[int, In], jobs: int
) -> Generator[tuple[int, Out | None]]:
    # Fresh processes: a fork of one that has started the engine's or the compiler's threads can
    # hang.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(jobs, len(items)), mp_context=context, initializer=_quiet)
    try:
        with _deaf():
            futures = {pool.submit(_work, function, item): i for i, item in items.items()}
        for future in as_completed(futures):
            died = isinstance(future.exception(), BrokenProcessPool)
            yield futures[future], None if died else future.result()
    except BaseException:
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _deaf() -> Iterator[None]:
    """Start workers that do not hear Ctrl-C, not even while they import."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _work(function: Callable[[In], Out], item: In) -> Out:
    try:
        return function(item)
    except SystemExit:  # told to end; the pool would swallow this and hand out the next item
        os._exit(128 + signal.SIGTERM)


def _quiet() -> None:
    """In a worker: leave Ctrl-C to the parent, and tidy up when it says to end."""
    from tqdm import tqdm

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _end)
    # By default a bar takes a lock of the whole system, which a worker told to end would leave.
    tqdm.set_lock(threading.RLock())


def _end(*_: object) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # once is enough; the rest is tidying up
    sys.exit(128 + signal.SIGTERM)
