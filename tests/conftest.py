"""Shared fixtures. Tests marked `clips` need the folder named by UNDERSTUDY_CLIPS."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

CLIPS = os.environ.get("UNDERSTUDY_CLIPS", "")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Without the folder, deselect the tests that need it and say so in one line."""
    if CLIPS and Path(CLIPS).is_dir():
        return
    needing = [item for item in items if item.get_closest_marker("clips")]
    if needing:
        config.hook.pytest_deselected(items=needing)
        items[:] = [item for item in items if not item.get_closest_marker("clips")]
        print(f"\n{len(needing)} tests deselected: UNDERSTUDY_CLIPS names no folder of clips.")


@pytest.fixture(scope="session")
def clips() -> Path:
    """The folder of real clips."""
    return Path(CLIPS)
