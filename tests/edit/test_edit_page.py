"""docs/edit_file.md names every key with the default it has."""

from __future__ import annotations

import dataclasses
import math
import re
import tomllib
from pathlib import Path

import pytest

from understudy.control import GiveWay, Push, Task, Throw
from understudy.edit import tables
from understudy.edit.edit import Meeting
from understudy.scene import Ground, Prop, Steps

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "edit_file.md").read_text(encoding="utf-8")
ROWS = {
    "[ground]": Ground,
    "[ground.steps]": Steps,
    "[[meet]]": Meeting,
    "[[push]]": Push,
    "[[throw]]": Throw,
    "[give_way]": GiveWay,
    **{f'"{name}"': kind for name, kind in {**tables.kinds(Task), **tables.kinds(Prop)}.items()},
}
SHARED = {"name", "friction", "stiffness_time", "span", "ease", "steps"}
"""Keys of many tables, said once above or below them."""


@pytest.mark.parametrize("head", ROWS)
def test_the_page_has_every_key_with_its_default(head):
    row = next(line for line in PAGE.splitlines() if line.startswith(f"| `{head}`"))
    if "as `[give_way]`" in row:
        return
    said = dict(re.findall(r"`(\w+)`(?: \([^)]*\))? = `?(\[[^`]*\]|\"\w+\"|[\d.]+)", row))
    for name, field in tables.keys(ROWS[head]).items():
        if name in SHARED and name not in said:
            continue
        assert f"`{name}`" in row, name
        if field.default is dataclasses.MISSING:
            assert name not in said and "needed" in row, name
        elif field.default not in (None, ()) and name in said:
            usual = field.default
            if name in tables.ANGLES and usual:
                usual = tuple(round(math.degrees(angle)) for angle in usual)
            value = tomllib.loads(f"key = {said[name]}")["key"]
            assert value == (list(usual) if isinstance(usual, tuple) else usual), name
        else:
            assert field.default in (None, ()), f"{name} has no default on the page"
