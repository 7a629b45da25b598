"""Writes BVH files in the dialect a clip came from.

The clip's `Conventions` say which axis is up, how long a unit is and which channels each joint
lists; a clip that came from no file is written with y up, in centimeters, Z X Y rotations.
"""

from __future__ import annotations

import os

import numpy as np

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.files import written
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

_LETTERS = {
    **{axis.lower(): f"{axis}position" for axis in "XYZ"},
    **{axis: f"{axis}rotation" for axis in "XYZ"},
}


def write_bvh(clip: Clip, path: str | os.PathLike[str]) -> None:
    """Write a clip as BVH, in the axes, the unit and the channel order of its conventions.

    Reading it again gives the same positions within 1e-6 m and the same rotations within 1e-4
    degrees. Joints whose channels cannot hold their rotation (fewer than three axes, and the motion
    was edited) get three. A file that exists is replaced only when the new one is complete.

    Raises:
        UnderstudyError: The file cannot be written.
        InvalidValue: A joint name that BVH cannot hold.
    """
    order = _file_order(clip.skeleton)
    channels, columns = _channels(clip)
    unit = clip.conventions.unit
    table = np.concatenate([columns[j] for j in order], axis=1)
    # 1e-8 m and 1e-6 degrees: far below what the reader promises.
    digits = max(6, int(np.ceil(8 + np.log10(unit))))
    formats = [
        f"%.{digits}f" if letter.islower() else "%.6f" for j in order for letter in channels[j]
    ]
    row = " ".join(formats)
    with written(path) as temporary, temporary.open("w", newline="\n", encoding="utf-8") as file:
        file.write(_hierarchy(clip, channels, digits))
        file.write(f"MOTION\nFrames: {clip.frames}\nFrame Time: {1 / clip.rate:.12g}\n")
        for values in table:
            file.write(row % tuple(values) + "\n")


def _file_order(skeleton: Skeleton) -> list[int]:
    """Joints depth first, as nested braces list them."""
    order: list[int] = []
    stack = [0]
    while stack:
        joint = stack.pop()
        order.append(joint)
        stack.extend(reversed(skeleton.children(joint)))
    return order


def _to_file(clip: Clip, vectors: Array) -> Array:
    """World vectors [m] in the file's axes and unit."""
    turn = np.round(rot.to_matrix(clip.conventions.axis_change))
    return vectors @ turn / clip.conventions.unit


def _channels(clip: Clip) -> tuple[list[str], list[Array]]:
    """Channels of each joint as letters, and the values under them, each (frames, channels)."""
    conventions, joints = clip.conventions, len(clip.skeleton)
    offsets = _to_file(clip, clip.skeleton.offsets)
    turn = np.round(rot.to_matrix(conventions.axis_change))
    local = clip.rotations.copy()
    local[..., 1:] = local[..., 1:] @ turn
    root = _to_file(clip, clip.root_positions)
    letters: list[str] = []
    columns: list[Array] = []
    for j in range(joints):
        if len(conventions.channels) == joints:
            listed = conventions.channels[j]
        else:
            listed = conventions.order(j)
        if j == 0 and not all(axis in listed for axis in "xyz"):
            fixed = np.allclose(root, offsets[0], atol=1e-9 / conventions.unit, rtol=0)
            if not (conventions.channels and fixed):
                listed = "xyz" + "".join(c for c in listed if c.isupper())
        listed, angles = _euler(local[:, j], listed)
        values = np.empty((clip.frames, len(listed)))
        turned = 0
        for k, letter in enumerate(listed):
            if letter.islower():
                axis = "xyz".index(letter)
                values[:, k] = root[:, axis] if j == 0 else offsets[j, axis]
            else:
                values[:, k] = angles[:, turned]
                turned += 1
        letters.append(listed)
        columns.append(values)
    return letters, columns


def _euler(q: Array, listed: str) -> tuple[str, Array]:
    """The channels of a joint, widened where they cannot hold its rotations, and angles [deg]."""
    order = "".join(c for c in listed if c.isupper())
    if len(order) < 3:
        whole = order + "".join(axis for axis in "ZXY" if axis not in order)
        angles = _angles(q, whole)
        if len(set(order)) == len(order) and np.all(np.abs(angles[:, len(order) :]) < 1e-6):
            return listed, angles[:, : len(order)]
        order = whole
    elif len(set(order)) == 3:
        return listed, _angles(q, order)
    else:
        order = "ZXY"
    return "".join(c for c in listed if c.islower()) + order, _angles(q, order)


def _angles(q: Array, order: str) -> Array:
    """Euler angles [deg] without jumps of whole turns, shape (frames, 3)."""
    return np.degrees(np.unwrap(rot.to_euler(q, order), axis=0))


def _hierarchy(clip: Clip, channels: list[str], digits: int) -> str:
    """The HIERARCHY section; nesting costs no recursion."""
    skeleton = clip.skeleton
    offsets = _to_file(clip, skeleton.offsets)
    ends = _to_file(clip, skeleton.end_offsets)
    sites: dict[int, list[int]] = {}
    for k, joint in enumerate(skeleton.end_joints):
        sites.setdefault(joint, []).append(k)
    lines = ["HIERARCHY"]
    depth = 0

    def add(text: str) -> None:
        lines.append("\t" * depth + text)

    def offset(vector: Array) -> str:
        return "OFFSET " + " ".join(f"{v:.{digits + 2}f}" for v in vector)

    stack: list[int | None] = [0]  # None closes a brace
    while stack:
        joint = stack.pop()
        if joint is None:
            depth -= 1
            add("}")
            continue
        name = skeleton.names[joint]
        if name != " ".join(name.split()) or not name or any(c in "{}" for c in name):
            raise InvalidValue(f"joint name {name!r} cannot be written in BVH; rename it.")
        add(f"{'JOINT' if joint else 'ROOT'} {name}")
        add("{")
        depth += 1
        add(offset(offsets[joint]))
        words = [_LETTERS[letter] for letter in channels[joint]]
        add(" ".join(["CHANNELS", str(len(words)), *words]))
        for k in sites.get(joint, ()):
            add("End Site")
            add("{")
            lines.append("\t" * (depth + 1) + offset(ends[k]))
            add("}")
        stack.append(None)
        stack.extend(reversed(skeleton.children(joint)))
    return "\n".join(lines) + "\n"
