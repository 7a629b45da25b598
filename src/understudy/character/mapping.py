"""A mapping file: what a person says about the joints, which overrides what is detected.

[roles]
left_knee = "LeftLeg"

[fold]
joints = ["LeftShoulder"]   # never a link of its own; what hangs on it stays

[drop]
joints = ["Tail"]           # left out with everything outboard of it
"""

from __future__ import annotations

import os
import re
import tomllib
from dataclasses import dataclass, field
from typing import Any

from understudy.errors import ClipError, UnknownName
from understudy.motion.figure import ROLES
from understudy.motion.skeleton import Skeleton
from understudy.motion.source import regular_bytes

_MOST_BYTES = 1 << 20


@dataclass(frozen=True, kw_only=True)
class Mapping:
    """Joints named by a person.

    Attributes:
        roles: Clip joint for each role given.
        fold: Clip joints that never become a link.
        drop: Clip joints left out with everything outboard of them.
        path: The file they were read from, or None.
        lines: Line of that file for each joint that is named in it.
    """

    roles: dict[str, str] = field(default_factory=dict)
    fold: tuple[str, ...] = ()
    drop: tuple[str, ...] = ()
    path: str | None = field(default=None, compare=False)
    lines: dict[str, int] = field(default_factory=dict, compare=False, repr=False)

    def __post_init__(self) -> None:
        for role in self.roles:
            if role not in ROLES:
                raise UnknownName("role", role, ROLES)

    def check(self, skeleton: Skeleton) -> None:
        """Check that the skeleton has every joint named here.

        Raises:
            UnknownName: It lacks one.
            ClipError: It lacks one that a mapping file names; says on which line.
        """
        for name in (*self.roles.values(), *self.fold, *self.drop):
            try:
                skeleton.index(name)
            except UnknownName as error:
                if self.path is None:
                    raise
                raise ClipError(self.path, str(error), self.lines.get(name)) from None


def read_mapping(path: str | os.PathLike[str]) -> Mapping:
    """Read a mapping file (TOML).

    Raises:
        ClipError: Not TOML, or a table or key that does not belong there; names the line.
    """
    try:
        text = regular_bytes(path, what="mapping file", most=_MOST_BYTES).decode()
    except UnicodeDecodeError:
        raise ClipError(path, "is not text; a mapping is a TOML file.") from None
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = re.search(r"line (\d+)", str(error))
        raise ClipError(path, f"is not TOML: {error}", int(line[1]) if line else None) from None
    for table in tables:
        if table not in ("roles", "fold", "drop"):
            _unknown(path, text, "table", table, ("roles", "fold", "drop"))
    for role, joint in _table(path, text, tables, "roles").items():
        if role not in ROLES:
            _unknown(path, text, "role", role, ROLES)
        if not isinstance(joint, str):
            raise ClipError(
                path, f"{role} is {joint!r}; it must be a joint's name.", _line(text, role)
            )
    roles = _table(path, text, tables, "roles")
    fold, drop = (_joints(path, text, tables, name) for name in ("fold", "drop"))
    found = {joint: _line_naming(text, joint) for joint in (*roles.values(), *fold, *drop)}
    return Mapping(
        roles=roles,
        fold=fold,
        drop=drop,
        path=os.fspath(path),
        lines={joint: line for joint, line in found.items() if line is not None},
    )


def _table(path: Any, text: str, tables: dict[str, Any], name: str) -> dict[str, Any]:
    table = tables.get(name, {})
    if not isinstance(table, dict):
        raise ClipError(path, f"{name} must be a table: [{name}].", _line(text, name))
    return table


def _joints(path: Any, text: str, tables: dict[str, Any], name: str) -> tuple[str, ...]:
    table = _table(path, text, tables, name)
    for key in table:
        if key != "joints":
            _unknown(path, text, f"key of [{name}]", key, ("joints",))
    joints = table.get("joints", [])
    if not isinstance(joints, list) or not all(isinstance(j, str) for j in joints):
        raise ClipError(path, 'joints must be a list: joints = ["Tail"].', _line(text, "joints"))
    return tuple(joints)


def _unknown(path: Any, text: str, kind: str, name: str, valid: tuple[str, ...]) -> None:
    raise ClipError(path, str(UnknownName(kind, name, valid)), _line(text, name))


def _line_naming(text: str, joint: str) -> int | None:
    """Line on which a joint's name stands as a value, in quotes and outside a comment."""
    for number, line in enumerate(text.splitlines(), 1):
        key, sign, value = re.split(r"(?:^|\s)#", line)[0].partition("=")
        said = value if sign else key
        if f'"{joint}"' in said or f"'{joint}'" in said:
            return number
    return None


def _line(text: str, key: str) -> int | None:
    """Line on which a key or table stands."""
    pattern = re.compile(rf"""^\s*\[?\s*["']?{re.escape(key)}["']?\s*(=|\])""")
    for number, line in enumerate(text.splitlines(), 1):
        if pattern.match(line):
            return number
    return None
