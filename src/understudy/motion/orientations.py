"""Reads world orientations of body segments, as inertial or magnetic sensors give them.

Joint rotations follow from equation 1 of Zordan & Hodgins, "Tracking and Modifying Upper-body Human
Motion Data with Dynamic Simulation" (Computer Animation and Simulation 1999): with the orientations
of the inboard and the outboard segment, R_joint = R_inboard^T R_outboard.

The file is a table in text, a row per sample, with a header line naming its columns:

    time, segment, w, x, y, z
    0.000, pelvis, 1, 0, 0, 0
    0.000, chest, 0.99, 0, 0.14, 0

`time` in seconds (rows in any order, rates may differ and be irregular), `segment` a link or joint
of the standard figure (chest or upper_back, left_upper_arm or left_shoulder), and a quaternion that
turns the segment from the T-pose facing +x, left +y, up +z into its world orientation. Optional
columns px, py, pz give the place of the pelvis [m] in its rows. Columns may come in any order, be
separated by commas, semicolons, tabs or blanks, and lines that start with # are skipped.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from understudy.errors import ClipError, InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip, Conventions
from understudy.motion.figure import LINKS, PARENTS, ROLES, figure
from understudy.motion.recording import unit_in_meters
from understudy.motion.rotations import Array
from understudy.motion.settle import checked_options
from understudy.motion.source import decoded, file_bytes, quoted
from understudy.motion.values import LARGEST

MAX_FRAMES = 1_000_000
GAP = 3.0  # sample periods without a sample that are worth a note
_COLUMNS = {
    "time": ("time", "t", "times", "timestamp", "seconds", "time_s", "time_sec"),
    "segment": ("segment", "link", "joint", "body", "sensor", "bone", "name", "part"),
    "w": ("w", "qw", "q_w", "quat_w", "rw", "rot_w", "q0"),
    "x": ("qx", "q_x", "quat_x", "rx", "rot_x", "q1", "x"),
    "y": ("qy", "q_y", "quat_y", "ry", "rot_y", "q2", "y"),
    "z": ("qz", "q_z", "quat_z", "rz", "rot_z", "q3", "z"),
    "px": ("px", "p_x", "pos_x", "position_x", "root_x", "x"),
    "py": ("py", "p_y", "pos_y", "position_y", "root_y", "y"),
    "pz": ("pz", "p_z", "pos_z", "position_z", "root_z", "z"),
}
# From a file with y up, in which the T-pose faces +z, left +x: x to y, y to z, z to x.
_FROM_Y_UP = np.array([0.5, 0.5, 0.5, 0.5])


def read_orientations(
    path: str | os.PathLike[str],
    *,
    up: str | None = None,
    unit: float | str | None = None,
    rate: float | None = None,
    height: float = 1.75,
) -> Clip:
    """Segment orientations as a clip on the standard figure.

    Samples of each segment are interpolated along great arcs to a fixed rate. A segment without
    samples moves with the segment it hangs from. Without positions the body is kept on the ground
    in place. Every such step is noted.

    Args:
        path: The file, laid out as this module's description says.
        up: Vertical axis of the orientations: "z" (None means "z"), or "y" for a T-pose that faces
            +z with left +x.
        unit: Meters per unit of the positions, or a name such as "cm"; None means meters.
        rate: Frames per second of the clip [Hz]; None takes the median rate of the samples.
        height: Stature of the figure [m].

    Raises:
        ClipError: The file cannot be read; names the line, the value and the remedy.
        InvalidValue: An option that cannot be meant.
    """
    checked_options(up, rate, "auto")
    if up == "x":
        raise InvalidValue("up is 'x'; orientations are read with 'z' or 'y' up.")
    samples = _Samples(decoded(file_bytes(path)), path)
    return samples.clip(up or "z", unit_in_meters(1.0 if unit is None else unit), rate, height)


def is_orientations(text: str) -> bool:
    """Whether a text starts like a table of segment orientations."""
    for line in text.splitlines()[:100]:
        if line.strip() and not line.lstrip().startswith("#"):
            columns = _columns(_words(line))
            return {"time", "segment", "w", "x", "y", "z"} <= set(columns)
    return False


def _words(line: str) -> list[str]:
    for mark in (",", ";", "\t"):
        if mark in line:
            return [word.strip().strip("\"'") for word in line.split(mark)]
    return [word.strip("\"'") for word in line.split()]


def _columns(words: list[str]) -> dict[str, int]:
    """Which word of a row each column is; names may carry a unit in brackets."""
    names = [re.sub(r"[\[(].*", "", word).strip().lower().replace(" ", "_") for word in words]
    out: dict[str, int] = {}
    for column, known in _COLUMNS.items():
        for name in known:
            if name in names and names.index(name) not in out.values():
                out[column] = names.index(name)
                break
    return out


def _segment(word: str) -> str:
    """The joint of the figure that a segment's name means; raises `UnknownName`."""
    plain = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", word.strip())
    plain = re.sub(r"[\s\-.]+", "_", plain).lower()
    plain = re.sub(r"^(l|lft)_", "left_", re.sub(r"^(r|rgt)_", "right_", plain))
    if plain in ROLES:
        return plain
    for role, link in LINKS.items():
        if plain == link:
            return role
    raise UnknownName("segment", word[:40], (*LINKS.values(), *ROLES))


class _Samples:
    """The rows of a file, by segment."""

    def __init__(self, text: str, path: str | os.PathLike[str]):
        self.path = path
        self.notes: list[str] = []
        self.times: dict[str, list[float]] = {}
        self.turns: dict[str, list[list[float]]] = {}
        self.places: list[list[float]] = []  # time, x, y, z of the pelvis
        roles: dict[str, str] = {}
        columns: dict[str, int] | None = None
        for number, line in enumerate(text.splitlines(), 1):
            if not line.strip() or line.lstrip().startswith("#"):
                continue
            words = _words(line)
            if columns is None:
                columns = self._header(words, number)
                continue
            self._row(words, columns, roles, number)
        if not self.times:
            raise ClipError(path, "holds no samples; give a header and a row per sample.")

    def _header(self, words: list[str], number: int) -> dict[str, int]:
        if words[0] == "time" and any(word.endswith(".x") for word in words):
            raise ClipError(
                self.path,
                "is a table of joint positions; it cannot be read back as motion; keep .npz or "
                ".bvh.",
            )
        columns = _columns(words)
        missing = [c for c in ("time", "segment", "w", "x", "y", "z") if c not in columns]
        if missing:
            raise ClipError(
                self.path,
                f"the header {quoted(','.join(words))} lacks {', '.join(missing)}; "
                "it must name time, segment, w, x, y, z.",
                number,
            )
        return columns

    def _row(
        self, words: list[str], columns: dict[str, int], roles: dict[str, str], number: int
    ) -> None:
        if len(words) <= max(columns[c] for c in ("time", "segment", "w", "x", "y", "z")):
            raise ClipError(self.path, f"{len(words)} columns are fewer than the header's.", number)
        word = words[columns["segment"]]
        if word not in roles:
            try:
                roles[word] = _segment(word)
            except UnknownName as error:
                raise ClipError(self.path, str(error), number) from None
        role = roles[word]
        time, *turn = (self._number(words[columns[c]], number) for c in ("time", *"wxyz"))
        if sum(v * v for v in turn) < 1e-12:
            raise ClipError(self.path, "the quaternion is zero; leave the row out.", number)
        self.times.setdefault(role, []).append(time)
        self.turns.setdefault(role, []).append(turn)
        if role == "pelvis" and {"px", "py", "pz"} <= set(columns):
            cells = [
                words[columns[c]] if columns[c] < len(words) else "" for c in ("px", "py", "pz")
            ]
            if all(cells):
                self.places.append([time, *(self._number(cell, number) for cell in cells)])

    def _number(self, word: str, number: int) -> float:
        try:
            value = float(word)
        except ValueError:
            value = np.nan
        if not abs(value) <= LARGEST:
            raise ClipError(self.path, f"{quoted(word)} is not a usable number.", number)
        return value

    def clip(self, up: str, unit: float, rate: float | None, height: float) -> Clip:
        """The clip these samples are."""
        series = {role: self._series(role) for role in self.times}
        start = max(times[0] for times, _ in series.values())
        end = min(times[-1] for times, _ in series.values())
        if end < start:
            raise ClipError(self.path, "the segments' samples do not overlap in time.")
        hertz = self._rate(series) if rate is None else float(rate)
        if (end - start) * hertz > MAX_FRAMES:
            raise ClipError(
                self.path,
                f"spans {end - start:g} s at {hertz:g} Hz, more than {MAX_FRAMES} frames; "
                "check the times or pass rate= (--rate).",
            )
        times = start + np.arange(int((end - start) * hertz + 1e-6) + 1) / hertz
        world = {role: self._at(role, times, *series[role], hertz) for role in series}
        turn = np.array([1.0, 0, 0, 0]) if up == "z" else _FROM_Y_UP
        rotations = self._joints(world, turn, len(times))
        skeleton = figure(height)
        path = self._path(times, turn, unit)
        still = Clip(
            skeleton=skeleton,
            rotations=rotations,
            root_positions=np.zeros((len(times), 3)) if path is None else path,
            rate=hertz,
            name=Path(self.path).stem,
            conventions=Conventions(up="z", unit=1.0),
        )
        if path is None:
            pose = still.forward_kinematics()
            lowest = np.minimum(pose.positions[..., 2].min(1), pose.ends[..., 2].min(1))
            path = np.stack((0.0 * lowest, 0.0 * lowest, -lowest), axis=1)
            self.notes.append(
                "The file gives no positions: the body stays in place, its lowest point on the "
                "ground, so flights are lost."
            )
        return Clip(
            skeleton=skeleton,
            rotations=rotations,
            root_positions=path,
            rate=hertz,
            name=still.name,
            notes=tuple(self.notes),
            conventions=still.conventions,
        )

    def _series(self, role: str) -> tuple[Array, Array]:
        """Sorted times and unit quaternions of a segment; of equal times the last counts."""
        times = np.array(self.times[role])
        turns = np.array(self.turns[role])
        order = np.argsort(times, kind="stable")
        last = np.append(np.diff(times[order]) > 0.0, True)
        keep = order[last]
        return times[keep], rot.continuous(rot.normalized(turns[keep]))

    def _rate(self, series: dict[str, tuple[Array, Array]]) -> float:
        steps = np.diff(max((times for times, _ in series.values()), key=len))
        if len(steps) == 0:
            self.notes.append("One sample only: a rate of 60 Hz is assumed.")
            return 60.0
        hertz = 1.0 / float(np.median(steps))
        # Rounded, so that clocks with jitter give the rate they were set to.
        hertz = round(hertz) if hertz > 5.0 and abs(hertz / round(hertz) - 1.0) < 0.01 else hertz
        if not 1e-3 <= hertz <= 1e5:
            raise ClipError(self.path, f"samples come at {hertz:g} Hz; time must be in seconds.")
        uneven = float(np.percentile(np.abs(steps * hertz - 1.0), 90))
        if uneven > 0.05:
            self.notes.append(f"Sample times are irregular: resampled to {hertz:g} Hz.")
        return float(hertz)

    def _at(self, role: str, times: Array, known: Array, turns: Array, hertz: float) -> Array:
        """Orientations of a segment at the clip's times, shape (frames, 4)."""
        steps = np.diff(known)
        gaps = steps[steps > GAP * max(1.0 / hertz, float(np.median(steps)) if len(steps) else 0)]
        if len(gaps):
            self.notes.append(
                f"{LINKS[role]}: {len(gaps)} gaps without samples, the longest {gaps.max():.2f} s, "
                "were interpolated."
            )
        if len(known) == 1:
            return np.tile(turns, (len(times), 1))
        left = np.clip(np.searchsorted(known, times, side="right") - 1, 0, len(known) - 2)
        weight = np.clip((times - known[left]) / steps[left], 0.0, 1.0)
        return rot.slerp(turns[left], turns[left + 1], weight)

    def _joints(self, world: dict[str, Array], turn: Array, frames: int) -> Array:
        """Joint rotations by equation 1, shape (frames, joints, 4)."""
        out = rot.identity(frames, len(ROLES))
        filled: dict[str, Array] = {}
        missing: list[str] = []
        for j, role in enumerate(ROLES):
            inboard = filled[PARENTS[role]] if role in PARENTS else rot.identity(frames)
            if role in world:
                outboard = rot.multiply(turn, rot.multiply(world[role], rot.conjugate(turn)))
            else:
                outboard = inboard
                missing.append(LINKS[role])
            filled[role] = outboard
            out[:, j] = rot.multiply(rot.conjugate(inboard), outboard)
        if missing:
            self.notes.append(
                f"No samples of {', '.join(missing)}: each moves with the segment it hangs from."
            )
        return out

    def _path(self, times: Array, turn: Array, unit: float) -> Array | None:
        """Root path [m], or None where the file gives none."""
        if not self.places:
            return None
        rows = np.array(self.places)
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        place = np.stack([np.interp(times, rows[:, 0], rows[:, k]) for k in (1, 2, 3)], axis=1)
        return rot.rotate(turn, place) * unit
