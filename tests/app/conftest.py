"""A short clip on disk, performed once for all tests of the commands."""

from __future__ import annotations

from pathlib import Path

import pytest

import understudy as us
from understudy.app.main import main


@pytest.fixture(scope="session")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A BVH file of 0.6 s of the gesture, 60 Hz."""
    path = tmp_path_factory.mktemp("clips") / "wave.bvh"
    us.write(us.sample("gesture").trimmed(1.0, 1.6).resampled(60.0), path)
    return path


@pytest.fixture(scope="session")
def out(short: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder `understudy track` made of it."""
    folder = tmp_path_factory.mktemp("out")
    assert main(["track", str(short), "--out", str(folder)]) == 0
    return folder
