"""Writes a clip as a table in text (CSV), for spreadsheets and plots."""

from __future__ import annotations

import os

import numpy as np

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.files import written


def write_csv(clip: Clip, path: str | os.PathLike[str], *, order: str = "ZXY") -> None:
    """Write joint positions and joint angles as CSV, a row per frame.

    Lines that start with # explain the columns: `time` [s]; `<joint>.x`, `.y`, `.z`, world
    positions of the joints [m], z up; `<joint>.<axis>`, angles of each joint against its parent
    (of the root against the world) [deg], turned in the order of the columns, each about the axes
    that the turns before it have turned; all angles zero is the rest pose.

    Args:
        clip: The motion.
        path: The file; one that exists is replaced when the new one is complete.
        order: Order of the angles, such as "ZXY".

    Raises:
        UnderstudyError: The file cannot be written.
        InvalidValue: The order does not name the three axes.
    """
    if sorted(order) != ["X", "Y", "Z"]:
        raise InvalidValue(f"order is {order!r}; it must hold X, Y and Z once each.")
    names = [name.replace(",", "_").replace('"', "_") for name in clip.skeleton.names]
    positions = clip.forward_kinematics().positions.reshape(clip.frames, -1)
    angles = np.degrees(np.unwrap(rot.to_euler(clip.rotations, order), axis=0))
    columns = [
        "time",
        *(f"{name}.{axis}" for name in names for axis in "xyz"),
        *(f"{name}.{axis}" for name in names for axis in order),
    ]
    table = np.concatenate(
        (clip.times[:, None], positions, angles.reshape(clip.frames, -1)), axis=1
    )
    row = ",".join(["%.6f"] * table.shape[1])
    with written(path) as temporary, temporary.open("w", newline="\n", encoding="utf-8") as file:
        file.write(f"# {clip.name}: {clip.frames} frames at {clip.rate:g} Hz\n")
        file.write("# time in seconds; joint.x joint.y joint.z: world position in meters, z up\n")
        file.write(f"# joint.{' joint.'.join(order)}: angles in degrees, intrinsic {order}\n")
        file.write(",".join(columns) + "\n")
        for values in table:
            file.write(row % tuple(values) + "\n")
