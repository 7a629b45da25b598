"""A motion as a file states it, in the file's own axes and units.

Every reader that must find out axes and units makes one; `understudy.motion.settle` turns it into a
`Clip`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from numbers import Real

from understudy.errors import InvalidValue
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

# CMU's Acclaim files state lengths as value / 0.45 in inches (mocap.cs.cmu.edu, FAQ).
UNITS = {
    "m": 1.0,
    "cm": 0.01,
    "mm": 0.001,
    "inch": 0.0254,
    "ft": 0.3048,
    "cmu": 0.0254 / 0.45,
}


# From a micrometer to a kilometer.
UNIT_RANGE = (1e-6, 1e3)


@dataclass(frozen=True, kw_only=True)
class Recording:
    """A motion in the axes and the unit of its file.

    Attributes:
        path: The file, for messages.
        name: Name of the clip that comes out.
        skeleton: Joints; offsets in file units along file axes.
        rotations: Local rotations about file axes, wxyz, shape (frames, joints, 4).
        root_positions: Root path in file units along file axes, shape (frames, 3).
        rate: Frames per second as the file states it [Hz].
        channels: Channels per joint, lower case positions and upper case rotations ("xyzZXY").
        stated_unit: Meters per file unit where the file states it, otherwise None.
        notes: What the reader met.
    """

    path: str
    name: str
    skeleton: Skeleton
    rotations: Array = field(repr=False)
    root_positions: Array = field(repr=False)
    rate: float
    channels: tuple[str, ...] = ()
    stated_unit: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.rotations)

    def kept(self, frames: slice) -> Recording:
        """The same recording with only some of its frames."""
        return replace(
            self, rotations=self.rotations[frames], root_positions=self.root_positions[frames]
        )


def unit_in_meters(unit: float | str) -> float:
    """Meters per file unit, from a number or one of the names in `UNITS`.

    Raises:
        InvalidValue: Another name, or a number outside `UNIT_RANGE`.
    """
    if isinstance(unit, str):
        if unit not in UNITS:
            raise InvalidValue(
                f"unit (--unit) is {unit!r:.40}; it must be a number of meters or one of "
                f"{', '.join(UNITS)}."
            )
        return UNITS[unit]
    low, high = UNIT_RANGE
    if not (isinstance(unit, Real) and low <= unit <= high):
        raise InvalidValue(
            f"unit (--unit) is {unit!s:.40} m; it must lie in {low:g} to {high:g} m, or be one of "
            f"{', '.join(UNITS)}."
        )
    return float(unit)
