"""How far one thing reaches into another, by geometry alone.

Where contact is off, nothing is in the contact table, however deep a hand is in a drum. The overlap
of the two says the same of a take with contact and of one without.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from understudy.errors import InvalidValue
from understudy.evaluate.contacts import Integers
from understudy.evaluate.owners import Owners, owners
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.take import Take

HIDDEN = 3
"""Geometries from this group on are not drawn: those that a character touches with."""


def overlap(take: Take, first: str, second: str, *, rate: float | None = None) -> Array:
    """Depth to which two things overlap [m], zero while apart, shape (frames,).

    The depth is the shortest way out: the length by which the deepest pair of shapes would have to
    move apart. It is computed for the recorded poses, whether the two collide in the scene or not,
    so takes with contact and without can be compared. What has passed more than half way through a
    thin thing is nearer to its far side.

    Args:
        take: The take.
        first: A link, prop or "ground".
        second: Another.
        rate: Frames per second [Hz], or the nearest that divides the take's; by default every step.

    Raises:
        UnknownName: Nothing in the scene is called that.
        InvalidValue: Both names are the same, or the rate is not positive.
    """
    known = owners(take)
    one, two = known.index(first), known.index(second)
    if one == two:
        raise InvalidValue(f"Both names are {first!r}; an overlap is of two things.")
    states = take.qpos[:: take.stride(rate)]
    pairs = [(a, b) for a in shapes(take, known, one) for b in shapes(take, known, two)]
    if not pairs:
        return np.zeros(len(states))
    model, data = take.model, mujoco.MjData(take.model)
    first_ids, second_ids = (np.array(side) for side in zip(*pairs, strict=True))
    # A plane has no radius: it may be near anything.
    radius = np.where(model.geom_rbound > 0, model.geom_rbound, np.inf)
    reach = radius[first_ids] + radius[second_ids]
    qpos, placed, depth = data.qpos, data.geom_xpos, np.zeros(len(states))
    for frame, state in enumerate(states):
        qpos[:] = state
        mujoco.mj_kinematics(model, data)
        between = np.linalg.norm(placed[first_ids] - placed[second_ids], axis=1)
        for k in np.flatnonzero(between < reach):
            a, b = pairs[k]
            depth[frame] = max(depth[frame], -mujoco.mj_geomDistance(model, data, a, b, 0.0, None))
    return depth


def shapes(take: Take, known: Owners, owner: int) -> list[int]:
    """Geometries by which an owner touches.

    A link has shapes kept for touching, which are not drawn; a prop touches with what is drawn as
    solid (group 0), not with what is only to be seen (1 and 2).
    """
    mine: Integers = np.flatnonzero(known.of_geom == owner)
    group = take.model.geom_group[mine]
    for kept in (group >= HIDDEN, group == 0):
        if kept.any():
            return [int(geom) for geom in mine[kept]]
    return [int(geom) for geom in mine]
