"""Reads Acclaim skeleton files (ASF): bones with a direction, a length, an axis and freedoms."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from understudy.errors import ClipError
from understudy.motion.source import MAX_JOINTS, decoded, quoted
from understudy.motion.values import LARGEST

_DOFS = ("tx", "ty", "tz", "rx", "ry", "rz", "l")


@dataclass(frozen=True, kw_only=True)
class Bone:
    """A bone of an Acclaim skeleton; the first of a figure is the root.

    Attributes:
        name: Its name.
        parent: Index of the bone it hangs from, -1 for the root.
        vector: From its start to its end at rest, in file units along file axes.
        axis: Angles of its rest axis in file angle units.
        order: Order of `axis`, the first letter applied first.
        dofs: What its values mean, in order: "tx" to "rz", "l" for length.
    """

    name: str
    parent: int
    vector: tuple[float, ...] = (0.0, 0.0, 0.0)
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    order: str = "XYZ"
    dofs: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Figure:
    """An Acclaim skeleton.

    Attributes:
        bones: Parents before children, the root first.
        unit: Meters per file unit: lengths are stated as inches divided by `length`.
        radians: Radians per file angle unit.
        position: Rest position of the root in file units.
        orientation: Rest orientation of the root in file angle units, in the order of its axis.
    """

    bones: tuple[Bone, ...]
    unit: float
    radians: float
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    orientation: tuple[float, ...] = (0.0, 0.0, 0.0)


class _Lines:
    """The lines of the file as words, with the section they belong to."""

    def __init__(self, text: str, path: str | os.PathLike[str]):
        self.path = path
        self.sections: dict[str, list[tuple[int, list[str]]]] = {}
        section = ""
        for number, line in enumerate(text.splitlines(), 1):
            words = line.split("#")[0].split()
            if not words:
                continue
            if words[0].startswith(":"):
                section = words[0].lower()
                self.sections.setdefault(section, [])
            else:
                self.sections.setdefault(section, []).append((number, words))

    def section(self, name: str) -> list[tuple[int, list[str]]]:
        """Numbered lines of a section that must be there."""
        if name not in self.sections:
            raise ClipError(self.path, f"has no {name} section; it is no whole ASF file.")
        return self.sections[name]

    def numbers(self, words: list[str], count: int, line: int) -> tuple[float, ...]:
        """The first `count` words as numbers."""
        try:
            values = tuple(float(word) for word in words[:count])
        except ValueError as error:
            raise ClipError(self.path, f"{error}; a number belongs here.", line) from None
        if len(values) < count or not all(abs(v) <= LARGEST for v in values):
            raise ClipError(self.path, f"{count} finite numbers belong here.", line)
        return values


def parsed_asf(data: bytes, path: str | os.PathLike[str]) -> Figure:
    """The bytes of an ASF file as a figure.

    Raises:
        ClipError: The bytes are no ASF file that can be read; names the line and the remedy.
    """
    lines = _Lines(decoded(data), path)
    length, radians = 1.0, np.pi / 180.0
    for line, words in lines.sections.get(":units", []):
        key = words[0].lower()
        if key == "length":
            length = lines.numbers(words[1:], 1, line)[0]
            if not 1e-6 <= length <= 1e6:
                raise ClipError(path, f"length is {length}; it must be positive.", line)
        elif key == "angle" and len(words) > 1 and words[1].lower().startswith("rad"):
            radians = 1.0
    root, position, orientation = _root(lines)
    bones = {root.name: root, **_bones(lines)}
    if len(bones) > MAX_JOINTS:
        raise ClipError(path, f"has more than {MAX_JOINTS} bones; export only the body's.")
    return Figure(
        bones=_tree(lines, bones),
        unit=0.0254 / length,
        radians=radians,
        position=position,
        orientation=orientation,
    )


def _order(lines: _Lines, word: str, line: int) -> str:
    if sorted(word.upper()) != ["X", "Y", "Z"]:
        raise ClipError(lines.path, f"axis order {quoted(word)} must be XYZ in some order.", line)
    return word.upper()


def _dofs(lines: _Lines, words: list[str], line: int) -> tuple[str, ...]:
    dofs = tuple(word.lower() for word in words)
    for dof in dofs:
        if dof not in _DOFS:
            raise ClipError(
                lines.path, f"{quoted(dof)} is unknown; freedoms are {', '.join(_DOFS)}.", line
            )
    if len(set(dofs)) != len(dofs):
        raise ClipError(lines.path, "lists a freedom twice.", line)
    return dofs


def _root(lines: _Lines) -> tuple[Bone, tuple[float, ...], tuple[float, ...]]:
    """The root as a bone, its rest position and its rest orientation."""
    dofs: tuple[str, ...] = ("tx", "ty", "tz", "rx", "ry", "rz")
    order, position, orientation = "XYZ", (0.0,) * 3, (0.0,) * 3
    for line, words in lines.section(":root"):
        key = words[0].lower()
        if key == "order":
            dofs = _dofs(lines, words[1:], line)
        elif key == "axis" and len(words) > 1:
            order = _order(lines, words[1], line)
        elif key == "position":
            position = lines.numbers(words[1:], 3, line)
        elif key == "orientation":
            orientation = lines.numbers(words[1:], 3, line)
    return Bone(name="root", parent=-1, order=order, dofs=dofs), position, orientation


def _bones(lines: _Lines) -> dict[str, Bone]:
    """Bones by name, their parents not known yet."""
    bones: dict[str, Bone] = {}
    name, length, order = "", 1.0, "XYZ"
    direction, axis = (0.0,) * 3, (0.0,) * 3
    dofs: tuple[str, ...] = ()
    for line, words in lines.section(":bonedata"):
        key = words[0].lower()
        if key == "begin":
            name, length, order = "", 1.0, "XYZ"
            direction, axis, dofs = (0.0,) * 3, (0.0,) * 3, ()
        elif key == "name" and len(words) > 1:
            name = words[1]
        elif key == "direction":
            direction = lines.numbers(words[1:], 3, line)
        elif key == "length":
            length = lines.numbers(words[1:], 1, line)[0]
        elif key == "axis":
            axis = lines.numbers(words[1:], 3, line)
            order = _order(lines, words[4], line) if len(words) > 4 else "XYZ"
        elif key == "dof":
            dofs = _dofs(lines, words[1:], line)
        elif key == "end":
            if not name or name in bones or name == "root":
                raise ClipError(
                    lines.path, f"bone name {quoted(name)} is missing or used twice.", line
                )
            size = float(np.linalg.norm(direction))
            bones[name] = Bone(
                name=name,
                parent=-1,
                vector=tuple(v / (size or 1.0) * length for v in direction),
                axis=axis,
                order=order,
                dofs=dofs,
            )
    return bones


def _tree(lines: _Lines, bones: dict[str, Bone]) -> tuple[Bone, ...]:
    """Bones with their parents, depth first, by the hierarchy section."""
    children: dict[str, list[str]] = {name: [] for name in bones}
    parents: dict[str, str] = {}
    for line, words in lines.section(":hierarchy"):
        if words[0].lower() in ("begin", "end"):
            continue
        for name in words:
            if name not in bones:
                raise ClipError(
                    lines.path, f"the hierarchy names {quoted(name)}, which is no bone.", line
                )
        for child in words[1:]:
            if child in parents or child == "root":
                raise ClipError(lines.path, f"bone {quoted(child)} has two parents.", line)
            parents[child] = words[0]
            children[words[0]].append(child)
    out: list[Bone] = []
    numbers: dict[str, int] = {}
    stack = ["root"]
    while stack:
        name = stack.pop()
        bone = bones[name]
        numbers[name] = len(out)
        out.append(
            Bone(
                name=name,
                parent=numbers[parents[name]] if name in parents else -1,
                vector=bone.vector,
                axis=bone.axis,
                order=bone.order,
                dofs=bone.dofs,
            )
        )
        stack.extend(reversed(children[name]))
    if len(out) != len(bones):
        lost = next(name for name in bones if name not in numbers)
        raise ClipError(lines.path, f"the hierarchy leads from the root to no {quoted(lost)}.")
    return tuple(out)
