"""A few thousand damaged files: every reader accepts or refuses, and never anything else."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parents[2] / "benchmarks" / "fuzz_readers.py"


@pytest.mark.skipif(not PROGRAM.is_file(), reason="the benchmarks are not installed")
def test_damaged_files_are_read_or_refused(monkeypatch):
    resource = pytest.importorskip("resource")
    monkeypatch.delenv("UNDERSTUDY_CLIPS", raising=False)
    spec = importlib.util.spec_from_file_location("fuzz_readers", PROGRAM)
    assert spec is not None and spec.loader is not None
    program = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(program)
    # The peak is of the process, which other tests may have raised before.
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    counts, _, memory, failures = program.fuzz((7, 0, 3000))
    assert failures == []
    assert sum(counts.values()) == 3000
    assert sum(n for outcome, n in counts.items() if outcome.endswith("read")) > 200
    assert memory <= max(before, program.MEMORY)
