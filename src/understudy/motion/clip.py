"""A motion clip: a skeleton, its joint rotations and its root path at a fixed rate.

World frame: right-handed, z up, meters, seconds, radians. Nothing here knows physics.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from functools import cached_property
from numbers import Real
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton, frozen_array

if TYPE_CHECKING:
    from understudy.motion.reaching import HandTarget

# Frames per second that a motion can have [Hz]: BVH files state up to 100 s a frame, and nothing
# that moves is recorded faster than this.
RATES = (0.01, 1e5)


def check_rate(rate: float, name: str = "rate") -> float:
    """The rate [Hz], when it can be meant.

    Raises:
        InvalidValue: No number, or outside `RATES`.
    """
    low, high = RATES
    if not (isinstance(rate, Real) and low <= rate <= high):
        raise InvalidValue(f"{name} is {rate!s:.40} Hz; it must lie in {low:g} to {high:g} Hz.")
    return float(rate)


@dataclass(frozen=True, kw_only=True)
class Conventions:
    """The dialect of the file a clip came from, so that a writer can restore it.

    Attributes:
        up: The file's vertical axis, "x", "y" or "z".
        unit: Meters per file unit.
        rotation_orders: Euler order per joint as channels list it ("ZXY"); empty means "ZXY" for
            every joint.
        channels: All channels per joint as the file lists them, positions in lower case and
            rotations in upper case ("xyzZXY"); empty means root positions first, then rotations.
    """

    up: str = "y"
    unit: float = 0.01
    rotation_orders: tuple[str, ...] = ()
    channels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.up not in ("x", "y", "z"):
            raise InvalidValue(f"up axis is {self.up!r}; it must be 'x', 'y' or 'z'.")
        if not (np.isfinite(self.unit) and self.unit > 0):
            raise InvalidValue(f"unit is {self.unit} m; it must be a positive number.")

    def order(self, joint: int) -> str:
        """Euler order of joint number `joint`."""
        return self.rotation_orders[joint] if joint < len(self.rotation_orders) else "ZXY"

    @property
    def axis_change(self) -> Array:
        """Quaternion (4,) that turns the file's axes into z up."""
        half = np.sqrt(0.5)
        return {
            "z": np.array([1.0, 0.0, 0.0, 0.0]),
            "y": np.array([half, half, 0.0, 0.0]),  # (x, y, z) -> (x, -z, y)
            "x": np.array([half, 0.0, -half, 0.0]),  # (x, y, z) -> (-z, y, x)
        }[self.up]


@dataclass(frozen=True, eq=False)
class Pose:
    """World poses of a skeleton over time.

    Attributes:
        positions: Joint positions [m], shape (frames, joints, 3).
        rotations: Joint orientations, wxyz, shape (frames, joints, 4).
        ends: End-site positions [m], shape (frames, ends, 3).
    """

    positions: Array
    rotations: Array
    ends: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Clip:
    """Joint rotations and a root path at a fixed rate; immutable.

    Attributes:
        skeleton: The joints.
        rotations: Local joint rotations, wxyz, shape (frames, joints, 4); the root's is its world
            orientation. Signs are made continuous over time.
        root_positions: World position of the root [m], shape (frames, 3).
        rate: Frames per second [Hz].
        name: Short name, used for files.
        synthetic: True when the motion was made, not captured.
        notes: What a reader or an edit detected or changed, one sentence each.
        conventions: The dialect to write files in.
    """

    skeleton: Skeleton
    rotations: Array = field(repr=False)
    root_positions: Array = field(repr=False)
    rate: float
    name: str = "clip"
    synthetic: bool = False
    notes: tuple[str, ...] = field(default=(), repr=False)
    conventions: Conventions = field(default_factory=Conventions, repr=False)

    def __post_init__(self) -> None:
        joints = len(self.skeleton)
        turned = frozen_array(self.rotations, (None, joints, 4), "rotations")
        path = frozen_array(self.root_positions, (None, 3), "root_positions")
        if len(turned) < 1 or len(turned) != len(path):
            raise InvalidValue(
                f"{len(turned)} frames of rotations and {len(path)} of root positions; "
                "a clip needs the same number, at least one."
            )
        rate = check_rate(self.rate)
        length = np.sqrt(np.einsum("...i,...i->...", turned, turned))
        if np.any(length < 1e-6):
            raise InvalidValue("A joint rotation is the zero quaternion.")
        # Unit quaternions pass unchanged, so that a clip written and read again is the same bits.
        length[np.abs(length - 1.0) < 1e-15] = 1.0
        if np.any(length != 1.0):
            turned = turned / length[..., None]
        turned = rot.continuous(turned)
        turned.setflags(write=False)
        set_ = object.__setattr__
        set_(self, "rotations", turned)
        set_(self, "root_positions", path)
        set_(self, "rate", rate)
        set_(self, "name", _readable(self.name))
        set_(self, "notes", tuple(self.notes))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Clip):
            return NotImplemented
        return (
            (self.skeleton, self.rate, self.name, self.synthetic, self.notes, self.conventions)
            == (
                other.skeleton,
                other.rate,
                other.name,
                other.synthetic,
                other.notes,
                other.conventions,
            )
            and np.array_equal(self.rotations, other.rotations)
            and np.array_equal(self.root_positions, other.root_positions)
        )

    def __hash__(self) -> int:
        return hash((self.skeleton.names, self.rate, self.name, self.root_positions.tobytes()))

    # -- reading ----------------------------------------------------------------------------

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.rotations)

    @property
    def duration(self) -> float:
        """Time from the first frame to the last [s]."""
        return (self.frames - 1) / self.rate

    @property
    def times(self) -> Array:
        """Time of each frame from the first [s], shape (frames,)."""
        return np.arange(self.frames) / self.rate

    def joint(self, name: str) -> Array:
        """Local rotations of one joint, shape (frames, 4); raises `UnknownName`."""
        return self.rotations[:, self.skeleton.index(name)]

    def forward_kinematics(self) -> Pose:
        """World poses of every joint and end site (computed once)."""
        return self._pose

    @cached_property
    def _pose(self) -> Pose:
        skeleton = self.skeleton
        turned = np.empty(self.rotations.shape)
        placed = np.empty((*self.rotations.shape[:2], 3))
        turned[:, 0], placed[:, 0] = self.rotations[:, 0], self.root_positions
        for i, p in enumerate(skeleton.parents[1:], 1):
            turned[:, i] = rot.multiply(turned[:, p], self.rotations[:, i])
            placed[:, i] = placed[:, p] + rot.rotate(turned[:, p], skeleton.offsets[i])
        carriers = list(skeleton.end_joints)
        ends = placed[:, carriers] + rot.rotate(turned[:, carriers], skeleton.end_offsets)
        for array in (placed, turned, ends):
            array.setflags(write=False)
        return Pose(placed, turned, ends)

    def noted(self, *notes: str) -> Clip:
        """The same clip with more notes."""
        return replace(self, notes=(*self.notes, *notes))

    def renamed(self, name: str) -> Clip:
        """The same clip under another name."""
        return replace(self, name=name)

    # -- edits (each in a module of this folder) ----------------------------------------------

    def trimmed(self, start: float = 0.0, end: float | None = None) -> Clip:
        """The part between two times [s]; see `understudy.motion.edits.trimmed`."""
        from understudy.motion import edits

        return edits.trimmed(self, start, end)

    def resampled(self, rate: float, *, method: Literal["slerp", "spline"] = "slerp") -> Clip:
        """The same motion at another rate [Hz]; see `understudy.motion.edits.resampled`."""
        from understudy.motion import edits

        return edits.resampled(self, rate, method=method)

    def retimed(self, speed: float) -> Clip:
        """The motion `speed` times as fast; see `understudy.motion.edits.retimed`."""
        from understudy.motion import edits

        return edits.retimed(self, speed)

    def placed(self, *, at: ArrayLike | None = None, heading: float = 0.0) -> Clip:
        """Moved over the ground to `at` [m] and turned [rad]; see `motion.edits.placed`."""
        from understudy.motion import edits

        return edits.placed(self, at=at, heading=heading)

    def spliced(self, other: Clip, *, at: float, blend: float = 0.5, start: float = 0.0) -> Clip:
        """This clip going over into another at a time [s]; see `motion.segments.spliced`."""
        from understudy.motion import segments

        return segments.spliced(self, other, at=at, blend=blend, start=start)

    def looped(self, count: int | None = None, *, until: float | None = None) -> Clip:
        """Played several times, or until a time [s]; see `motion.segments.looped`."""
        from understudy.motion import segments

        return segments.looped(self, count, until=until)

    def reaching(self, *targets: HandTarget) -> Clip:
        """Hands placed at positions at given times; see `motion.reaching.reaching`."""
        from understudy.motion import reaching

        return reaching.reaching(self, targets)

    def mirrored(self) -> Clip:
        """Left and right exchanged; see `understudy.motion.edits.mirrored`."""
        from understudy.motion import edits

        return edits.mirrored(self)

    def grounded(self) -> Clip:
        """Shifted so that the feet stand on z = 0; see `understudy.motion.ground.grounded`."""
        from understudy.motion import ground

        return ground.grounded(self)

    def repaired(self) -> Clip:
        """Single-frame glitches removed, with notes; see `understudy.motion.repair.repaired`."""
        from understudy.motion import repair

        return repair.repaired(self)


def _readable(name: str) -> str:
    """A name that can be written as UTF-8: file names may hold bytes that are no text."""
    try:
        name.encode()
    except UnicodeEncodeError:
        try:
            return os.fsencode(name).decode("utf-8", "replace")
        except UnicodeEncodeError:
            return name.encode("utf-8", "replace").decode()
    return name
