"""Masses of a linkage's bodies from published tables of human segments."""

from __future__ import annotations

import numpy as np

from understudy.errors import InvalidValue
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array


def anthropometric_masses(clip: Clip, mass: float | None = None) -> Array:
    """Mass of every body [kg], shape (joints,), adding up to a person's.

    A segment's mass (`Character.from_clip`) goes to the bones that turn with it, in proportion to
    their lengths; a segment without bones gives its mass to the bone that leads to it.

    Raises:
        InvalidValue: The clip's joints cannot be recognized as a person's.
    """
    from understudy.character.body import Character

    person = Character.from_clip(clip, mass=mass)
    if not person.humanoid:
        raise InvalidValue(
            f"The joints of {clip.name!r} are not recognized as a person's; "
            "give the masses by name."
        )
    skeleton = clip.skeleton
    link_at = {link.clip_joint: k for k, link in enumerate(person.links)}
    owner = np.zeros(len(skeleton), int)  # the link that each joint turns with
    for joint, parent in enumerate(skeleton.parents):
        own = link_at.get(skeleton.names[joint])
        owner[joint] = own if own is not None else (owner[parent] if parent >= 0 else 0)
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    lengths[0] = 0.0
    # A small share for spheres, so that no body is without mass.
    share = lengths + 0.02 * lengths.sum() / len(skeleton)
    bones = np.array([owner[max(p, 0)] for p in skeleton.parents])
    out = np.zeros(len(skeleton))
    for k, link in enumerate(person.links):
        mine = np.flatnonzero(bones == k)
        if not len(mine):
            joint = link.clip_joint or skeleton.names[0]
            mine = np.array([skeleton.index(joint)])
        out[mine] += link.mass * share[mine] / share[mine].sum()
    return out
