"""Edit files that are quick to perform."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from understudy.edit.edit import Edit, edit_of
from understudy.edit.source import parsed


@pytest.fixture(scope="session")
def said() -> Callable[[str], Edit]:
    """What a text says, as if it were `edit.toml`."""
    return lambda text: edit_of(parsed(text, "edit.toml"))


@pytest.fixture(scope="session")
def examples() -> list[Path]:
    """The edit files that come with the package."""
    return sorted((Path(__file__).resolve().parents[2] / "examples" / "edits").glob("*.toml"))
