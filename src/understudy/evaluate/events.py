"""Contacts as results: what touched what, when, for how long and how hard.

A contact event is a stretch of time in which two things touch. The forces of all contact points
between them are added frame by frame, so an event has one force, whatever the shapes: its impulse
is that force over time and equals the momentum that went from one to the other.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.errors import InvalidValue, shown
from understudy.evaluate.contacts import Integers
from understudy.evaluate.measure import Measured, measured
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.take import Take

GAP = 0.02
"""Touches closer together than this are one event [s]. A hand rolls from finger to palm and a hard
surface chatters for a few milliseconds; the strokes of one fast drumming hand are 80 ms apart."""


@dataclass(frozen=True, kw_only=True)
class ContactEvent:
    """Two things touching for a while.

    Attributes:
        between: Names of the two: links ("right_hand", of a second character "b/right_hand"),
            props, "ground"; in that order, unless others were asked for.
        start_s: When they first touch [s].
        duration_s: From the first touch to the end of the last [s].
        impulse_ns: Size of `impulse` [N s].
        impulse: Time integral of the force on the first of the two [N s], world, shape (3,).
        peak_force_n: Largest size of that force [N]. It depends on how hard the surfaces are and on
            the step; the impulse does not.
        peak_s: When [s].
        penetration_mm: Deepest overlap of any contact point [mm].
        approach_m_s: Closing speed at the first touch, along the surface's normal [m/s]; negative
            when they were already parting.
        position: Where: the mean contact point, weighted by force [m], world, shape (3,).
        touches: Number of touches without any gap that make up the event.
    """

    between: tuple[str, str]
    start_s: float
    duration_s: float
    impulse_ns: float
    impulse: Array = field(repr=False, compare=False)
    peak_force_n: float
    peak_s: float
    penetration_mm: float
    approach_m_s: float
    position: Array = field(repr=False, compare=False)
    touches: int = 1

    def __post_init__(self) -> None:
        for name in ("impulse", "position"):
            array = np.array(getattr(self, name), float)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def end_s(self) -> float:
        """When they part [s]."""
        return self.start_s + self.duration_s

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes, with the unit in every key."""
        return {
            "between": list(self.between),
            "start_s": self.start_s,
            "duration_s": self.duration_s,
            "impulse_ns": self.impulse_ns,
            "impulse_world_ns": self.impulse.tolist(),
            "peak_force_n": self.peak_force_n,
            "peak_s": self.peak_s,
            "penetration_mm": self.penetration_mm,
            "approach_m_s": self.approach_m_s,
            "position_world_m": self.position.tolist(),
            "touches": self.touches,
        }


def contact_events(
    take: Take | Measured, first: str | None = None, second: str | None = None, *, gap: float = GAP
) -> tuple[ContactEvent, ...]:
    """What touched what, in order of time.

    Args:
        take: A take, or what `measured(take)` gave.
        first: Only contacts of this link, prop or "ground"; forces are those on it.
        second: Only contacts between the two.
        gap: Touches less than this apart are one event [s]; 0 keeps every touch for itself.

    Raises:
        UnknownName: Nothing in the scene is called that.
        InvalidValue: The gap is negative, or both names are the same.
    """
    if not (np.isfinite(gap) and gap >= 0):
        raise InvalidValue(f"gap is {shown(gap)} s; it must be zero or positive.")
    m = take if isinstance(take, Measured) else measured(take)
    return events_of(touching(m, first, second), gap=gap)


def contact_force(take: Take | Measured, first: str, second: str | None = None) -> Array:
    """Contact force on the first by the second, or by all else [N], world, shape (frames, 3).

    Raises:
        UnknownName: Nothing in the scene is called that.
    """
    m = take if isinstance(take, Measured) else measured(take)
    found = touching(m, first, second)
    out = np.zeros((m.frames, 3))
    np.add.at(out, found.frame, found.force)
    return out


@dataclass(frozen=True, kw_only=True)
class Touching:
    """Contacts added up over the points of each pair: one row for each pair and frame they touch.

    Rows are sorted by pair, then frame.

    Attributes:
        names: What the numbers in `pair` stand for.
        times: Time of every measured frame [s], shape (frames,).
        step: Time between two [s].
        pair: The two, shape (rows, 2).
        frame: Measured frame, shape (rows,).
        force: Force on the first of the two [N], world, shape (rows, 3).
        depth: Deepest overlap [m], shape (rows,).
        closing: Largest closing speed [m/s], shape (rows,).
        load: Sum of the sizes of the points' forces [N], shape (rows,).
        position: Mean contact point, weighted by those [m], shape (rows, 3).
    """

    names: tuple[str, ...]
    times: Array
    step: float
    pair: Integers
    frame: Integers
    force: Array
    depth: Array
    closing: Array
    load: Array
    position: Array

    def only(self, rows: np.ndarray[Any, np.dtype[np.bool_]]) -> Touching:
        """The rows of a mask."""
        columns = ("pair", "frame", "force", "depth", "closing", "load", "position")
        return replace(self, **{name: getattr(self, name)[rows] for name in columns})


def touching(
    m: Measured,
    first: str | None = None,
    second: str | None = None,
    *,
    merged: dict[str, str] | None = None,
) -> Touching:
    """Contacts pair by pair; with names, only theirs.

    Args:
        m: What was measured.
        first: The one whose contacts are asked for.
        second: The other.
        merged: Names that stand for others: {"left_toes": "left_foot"} makes toes part of the foot.
    """
    table, names = m.contacts, m.owners.names
    one = None if first is None else m.owners.index(first)
    two = None if second is None else m.owners.index(second)
    if one is None and two is not None:
        one, two = two, None
    if one is not None and one == two:
        raise InvalidValue(f"Both names are {first!r}; a contact is between two things.")
    number = np.arange(len(names))
    for name, instead in (merged or {}).items():
        number[names.index(name)] = names.index(instead)
    sides = np.where(table.geoms >= 0, number[m.owners.of_geom[np.maximum(table.geoms, 0)]], -1)
    swapped = sides[:, 0] > sides[:, 1] if one is None else sides[:, 0] != one
    sides = np.where(swapped[:, None], sides[:, ::-1], sides)
    size = np.linalg.norm(table.force, axis=1)
    # Points within a margin are listed before they touch.
    kept = ((table.depth > 0) | (size > 0)) & (sides[:, 0] != sides[:, 1]) & (sides >= 0).all(1)
    if one is not None:
        kept &= sides[:, 0] == one
    if two is not None:
        kept &= sides[:, 1] == two
    rows = np.flatnonzero(kept)
    code = (sides[rows, 0] * len(names) + sides[rows, 1]) * m.frames + table.frame[rows]
    order = np.argsort(code, kind="stable")
    rows, code = rows[order], code[order]
    cell, begin = np.unique(code, return_index=True)
    # The table has the force on the second geometry.
    force = np.where(swapped[rows], 1.0, -1.0)[:, None] * table.force[rows]
    load = _sums(size[rows], begin)
    weighted = _sums(size[rows, None] * table.position[rows], begin)
    counts = np.diff(np.append(begin, len(rows)))[:, None]
    plain = _sums(table.position[rows], begin) / np.maximum(counts, 1)
    pair, frame = np.divmod(cell, m.frames)
    return Touching(
        names=names,
        times=m.times,
        step=1.0 / m.rate,
        pair=np.stack(np.divmod(pair, len(names)), axis=1),
        frame=frame,
        force=_sums(force, begin),
        depth=_largest(table.depth[rows], begin),
        closing=_largest(table.closing[rows], begin),
        load=load,
        position=np.where(load[:, None] > 0, weighted / np.maximum(load, 1e-300)[:, None], plain),
    )


def _sums(values: Any, begin: Integers) -> Array:
    return np.add.reduceat(values, begin, axis=0) if len(begin) else values[:0]


def _largest(values: Array, begin: Integers) -> Array:
    return np.maximum.reduceat(values, begin) if len(begin) else values[:0]


def events_of(t: Touching, *, gap: float) -> tuple[ContactEvent, ...]:
    """Events of rows that follow each other, those less than `gap` [s] apart joined."""
    # Forces of the last frame acted over no step.
    t = t.only(t.frame < len(t.times) - 1)
    if not len(t.frame):
        return ()
    other = (np.diff(t.pair, axis=0) != 0).any(axis=1)
    between = np.diff(t.frame) - 1
    fresh = np.append(True, other | (between != 0))
    # A part in a million of a step forgives rounding in gap / step.
    split = other | ((between > 0) & (between * t.step >= gap - 1e-6 * t.step))
    begin = np.flatnonzero(np.append(True, split))
    end = np.append(begin[1:], len(t.frame))
    impulse, size = _sums(t.force, begin) * t.step, np.linalg.norm(t.force, axis=1)
    depth, touches = _largest(t.depth, begin), _sums(fresh.astype(np.int64), begin)
    weight = np.where(np.repeat(_sums(t.load, begin), end - begin) > 0, t.load, 1.0)
    place = _sums(weight[:, None] * t.position, begin) / _sums(weight, begin)[:, None]
    out = []
    for k, (a, b) in enumerate(zip(begin, end, strict=True)):
        peak = a + int(np.argmax(size[a:b]))
        out.append(
            ContactEvent(
                between=(t.names[t.pair[a, 0]], t.names[t.pair[a, 1]]),
                start_s=float(t.times[t.frame[a]]),
                duration_s=float(t.frame[b - 1] - t.frame[a] + 1) * t.step,
                impulse_ns=float(np.linalg.norm(impulse[k])),
                impulse=impulse[k],
                peak_force_n=float(size[peak]),
                peak_s=float(t.times[t.frame[peak]]),
                penetration_mm=1e3 * max(0.0, float(depth[k])),
                approach_m_s=float(t.closing[a]),
                position=place[k],
                touches=int(touches[k]),
            )
        )
    return tuple(sorted(out, key=lambda e: (e.start_s, t.names.index(e.between[0]), e.between)))
