"""How far one thing reaches into another, by geometry alone.

Where contact is off, nothing is in the contact table, however deep a hand is in a drum. The overlap
of the two says the same of a take with contact and of one without.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from understudy.errors import InvalidValue
from understudy.evaluate.owners import owners, owners_in
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.take import Take


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
        InvalidValue: Both names are the same, the two can never touch, or the rate is not positive.
    """
    states = take.qpos[:: take.stride(rate)]
    model, pairs = shapes_touching(take, first, second)
    if not pairs:
        return np.zeros(len(states))
    data = mujoco.MjData(model)
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


def shapes_touching(
    take: Take, first: str, second: str
) -> tuple[mujoco.MjModel, list[tuple[int, int]]]:
    """A model of the take's scene, and pairs of its geometries by which two things touch in it.

    Raises:
        UnknownName: Nothing in the scene is called that.
        InvalidValue: The two can never touch: both are fixed, or they are joined.
    """
    scene, model, known = take.scene, take.model, owners(take)
    if known.index(first) == known.index(second):
        raise InvalidValue(f"Both names are {first!r}; an overlap is of two things.")
    bodies = mujoco.mjtObj.mjOBJ_BODY
    if all(mujoco.mj_name2id(model, bodies, name) > 0 for name in (first, second)):
        # The scene knows which shapes are for touching: have it make them touch.
        scene = replace(scene, contacts=((first, second),))
        model = scene.model
        known = owners_in(scene, model)
        geoms = zip(model.pair_geom1, model.pair_geom2, strict=True)
        sides = {known.index(first), known.index(second)}
        return model, [(int(a), int(b)) for a, b in geoms if {*known.of_geom[[a, b]]} == sides]
    mine, other = (np.flatnonzero(known.of_geom == known.index(name)) for name in (first, second))
    kind, affinity = model.geom_contype, model.geom_conaffinity
    every = [(int(a), int(b)) for a in mine for b in other]
    meant = [(a, b) for a, b in every if kind[a] & affinity[b] or kind[b] & affinity[a]]
    return model, meant or every
