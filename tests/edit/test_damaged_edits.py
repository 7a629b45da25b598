"""Damaged edit files are refused in one line; benchmarks/fuzz_edits.py does it at length."""

from __future__ import annotations

import random
import sys
from functools import lru_cache
from pathlib import Path

import pytest

from understudy.edit import motions

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

from fuzz_edits import SEEDS, damaged, outcome


@pytest.mark.parametrize("seed", range(4))
def test_a_damaged_edit_is_performed_or_refused(seed, monkeypatch):
    monkeypatch.setattr(motions, "sample", lru_cache(motions.sample))
    rng = random.Random(1000 + seed)
    found = [outcome(damaged(rng.choice(SEEDS), rng)) for _ in range(30)]
    assert set(found) == {"performance", "refused"}
