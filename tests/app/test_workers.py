"""Many items in several processes: one that dies costs only its own."""

from __future__ import annotations

import os
import signal

from understudy.app.workers import each


def squared(x: int) -> int:
    if x < 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return x * x


def test_one_process_keeps_the_order():
    assert list(each(squared, [3, 1, 2], jobs=1)) == [(0, 9), (1, 1), (2, 4)]


def test_several_processes_return_every_item_once():
    assert sorted(each(squared, list(range(6)), jobs=2)) == [(i, i * i) for i in range(6)]


def test_a_worker_that_dies_costs_only_its_own_item():
    results = dict(each(squared, [2, -1, 3], jobs=2))
    assert results == {0: 4, 1: None, 2: 9}
