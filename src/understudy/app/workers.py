"""Run one function over many items, in this process or in several, one result as each finishes.

A worker that dies, as the system kills one that takes too much memory, costs only its own item:
the others are tried again, each in a process of its own.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import TypeVar

In = TypeVar("In")
Out = TypeVar("Out")


def each(
    function: Callable[[In], Out], items: Sequence[In], *, jobs: int
) -> Iterator[tuple[int, Out | None]]:
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
) -> Iterator[tuple[int, Out | None]]:
    # Fresh processes: a fork of one that has started the engine's or the compiler's threads can
    # hang.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(jobs, len(items)), mp_context=context, initializer=_quiet)
    try:
        futures = {pool.submit(_work, function, item): i for i, item in items.items()}
        for future in as_completed(futures):
            died = isinstance(future.exception(), BrokenProcessPool)
            yield futures[future], None if died else future.result()
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    pool.shutdown()


def _work(function: Callable[[In], Out], item: In) -> Out:
    try:
        return function(item)
    except SystemExit:  # told to end; the pool would swallow this and hand out the next item
        os._exit(128 + signal.SIGTERM)


def _quiet() -> None:
    """In a worker: leave Ctrl-C to the parent, and tidy up when it says to end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
