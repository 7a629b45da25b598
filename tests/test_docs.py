"""The programs in the documentation run as they stand; test_package.py runs the README's."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import understudy as us

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)


def programs() -> list[tuple[str, str]]:
    """Every block of Python that begins with an import, and where it stands; others are parts."""
    found = []
    for page in sorted((ROOT / "docs").glob("*.md")):
        for number, match in enumerate(BLOCK.finditer(page.read_text(encoding="utf-8")), 1):
            if match[1].startswith(("import ", "from ")):
                found.append((f"{page.name}:{number}", match[1]))
    return found


def test_the_pages_hold_programs():
    assert {name.split(":")[0] for name, _ in programs()} >= {
        "character.md",
        "motion.md",
        "output.md",
    }


@pytest.mark.parametrize(("name", "program"), programs(), ids=[name for name, _ in programs()])
def test_a_program_in_the_documentation_runs(name, program, tmp_path, monkeypatch):
    # Drawing a video is slow; a short walk does for the page that makes one.
    seconds = 0.8 if "video" in program else 2.85
    us.write(us.sample("walk").trimmed(0.0, seconds).resampled(60.0), tmp_path / "walk.bvh")
    monkeypatch.chdir(tmp_path)
    exec(compile(program, name, "exec"), {"__name__": "__main__"})
