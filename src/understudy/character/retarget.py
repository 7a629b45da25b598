"""Clips onto characters and back.

Onto its own character a clip goes exactly: every link takes its clip joint's world orientation
times a constant, and the root the joint's position. Onto another body go the joint rotations role
by role, with the path of the hips scaled by leg length and the soles kept where the actor had them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from understudy.character.body import Character
from understudy.character.soles import sole_heights, sole_points, standing
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import sampled
from understudy.motion.figure import PARENTS
from understudy.motion.rotations import Array

# The vertical correction that keeps soles on the ground is smoothed over this long [s].
_SMOOTHING = 0.03


def retargeted(clip: Clip, character: Character, *, actor: Character | None = None) -> Clip:
    """A clip on a character's skeleton (its joint names, its rest T-pose).

    The clip the character was made from, or any edit of it, goes over exactly. Another person's
    clip goes over by role: missing joints follow their parent, joints the body lacks are composed
    into the next outboard, the hips' path is scaled by leg length about where it starts, and the
    lowest sole stays as high over the floor as the actor's, in scale.

    Args:
        clip: Any clip.
        character: Who is to perform it.
        actor: Whose skeleton the clip is on, where that is known; found from the clip otherwise.

    Raises:
        InvalidValue: A clip of another skeleton for a character without roles, or the reverse.
    """
    if clip.skeleton == character.skeleton:
        return clip
    if clip.skeleton == character.source:
        return _own(clip, character)
    if not character.humanoid:
        return _by_name(clip, character)
    if actor is not None and clip.skeleton == actor.skeleton:
        return _performed(clip, actor, character)
    actor = Character.from_clip(clip)
    if not actor.humanoid:
        raise InvalidValue(
            f"{clip.name}: no person was found in its skeleton ({actor.roles.reason}), and "
            f"{character.name!r} is one. Say which joint is which with a mapping."
        )
    return _performed(_own(clip, actor), actor, character)


def restored(clip: Clip, source: Clip, character: Character) -> Clip:
    """A motion of a character back on the full skeleton it was captured with.

    Joints that became links take the links' world orientations; folded and dropped joints keep the
    rotations captured at the same time (the last ones, where the motion goes on longer). The pelvis
    is where the body's is.

    Args:
        clip: On the character's skeleton.
        source: The captured clip, on the skeleton wanted.
        character: The body that performed.

    Raises:
        InvalidValue: The clip is not on the character's skeleton.
    """
    if clip.skeleton != character.skeleton:
        raise InvalidValue(f"{clip.name}: is not on the skeleton of {character.name!r}.")
    if source.skeleton == character.skeleton:
        return clip
    if source.skeleton != character.source:
        if not character.humanoid:
            return clip
        actor = Character.from_clip(source)
        clip, character = _performed(clip, character, actor), actor
    skeleton, pose = source.skeleton, clip.forward_kinematics()
    local, _ = sampled(source, np.minimum(clip.times, source.duration), method="slerp")
    local = np.array(local)
    links = {skeleton.index(k.clip_joint): i for i, k in enumerate(character.links) if k.clip_joint}
    world = np.empty_like(local)
    at = np.zeros((clip.frames, len(skeleton), 3))
    for joint, parent in enumerate(skeleton.parents):
        inboard = world[:, parent] if parent >= 0 else rot.identity(clip.frames)
        if joint in links:
            i = links[joint]
            back = rot.conjugate(character.links[i].alignment)
            world[:, joint] = rot.multiply(pose.rotations[:, i], back)
            local[:, joint] = rot.multiply(rot.conjugate(inboard), world[:, joint])
        else:
            world[:, joint] = rot.multiply(inboard, local[:, joint])
        if parent >= 0:
            at[:, joint] = at[:, parent] + rot.rotate(inboard, skeleton.offsets[joint])
    pelvis = skeleton.index(character.links[0].origin_joint or skeleton.names[0])
    return replace(
        source,
        rotations=local,
        root_positions=pose.positions[:, 0] - at[:, pelvis],
        rate=clip.rate,
        name=clip.name,
        notes=(*source.notes, *clip.notes[len(source.notes) :]),
    )


# -- the same skeleton ------------------------------------------------------------------------


def _own(clip: Clip, character: Character) -> Clip:
    """Exact: world orientations of the clip joints times the links' alignments."""
    skeleton, pose = clip.skeleton, clip.forward_kinematics()
    world = np.stack(
        [
            rot.multiply(pose.rotations[:, skeleton.index(k.clip_joint or "")], k.alignment)
            for k in character.links
        ],
        axis=1,
    )
    root = skeleton.index(character.links[0].origin_joint or "")
    return _on(clip, character, world, pose.positions[:, root])


def _on(clip: Clip, character: Character, world: Array, path: Array, *notes: str) -> Clip:
    """A clip on the character's skeleton from world orientations of its links."""
    local = np.array(world)
    for i, link in enumerate(character.links):
        if link.parent >= 0:
            local[:, i] = rot.multiply(rot.conjugate(world[:, link.parent]), world[:, i])
    return Clip(
        skeleton=character.skeleton,
        rotations=local,
        root_positions=path,
        rate=clip.rate,
        name=clip.name,
        synthetic=clip.synthetic,
        notes=(*clip.notes, *notes),
    )


def _by_name(clip: Clip, character: Character) -> Clip:
    """Local rotations by joint name, for characters without roles."""
    missing = [k.joint for k in character.links if k.joint not in clip.skeleton.names]
    if missing:
        raise InvalidValue(
            f"{clip.name}: lacks the joint {missing[0]!r} of {character.name!r}, which has no "
            "roles to go by."
        )
    pose = clip.forward_kinematics()
    index = [clip.skeleton.index(k.joint) for k in character.links]
    return _on(clip, character, pose.rotations[:, index], pose.positions[:, index[0]])


# -- another body -----------------------------------------------------------------------------


def _performed(clip: Clip, actor: Character, body: Character) -> Clip:
    """A clip on one person's skeleton, on another person's."""
    pose = clip.forward_kinematics()
    given = {k.role: pose.rotations[:, i] for i, k in enumerate(actor.links) if k.role}
    world: dict[str, Array] = {}
    for link in body.links:
        role = link.role or ""
        world[role] = given[role] if role in given else _followed(role, given, world)
    turned = np.stack([world[k.role or ""] for k in body.links], axis=1)
    scale = _leg_length(body) / _leg_length(actor)
    hips = pose.positions[:, 0] + rot.rotate(pose.rotations[:, 0], _mid_hip(actor))
    path = hips * scale
    path[:, :2] += hips[0, :2] * (1.0 - scale)
    path -= rot.rotate(turned[:, 0], _mid_hip(body))
    out = _on(clip, body, turned, path, f"Performed by {body.name!r}, path scaled by {scale:.3f}.")
    lift = _lift(clip, actor, out, body, scale)
    path = np.array(path)
    path[:, 2] += lift
    return replace(out, root_positions=path)


def _followed(role: str, given: dict[str, Array], world: dict[str, Array]) -> Array:
    """Orientation of a link whose role the actor lacks: its parent's, or half way up the back."""
    if role == "lower_back" and "upper_back" in given:
        return rot.slerp(world["pelvis"], given["upper_back"], np.array(0.5))
    parent = PARENTS[role]
    while parent not in world:
        parent = PARENTS[parent]
    return world[parent]


def _mid_hip(character: Character) -> Array:
    """Middle of the hip joints in the pelvis frame [m], shape (3,); the pelvis without legs."""
    hips = [k.offset for k in character.links if k.joint in ("left_hip", "right_hip")]
    return np.mean(hips, axis=0) if hips else np.zeros(3)


def _leg_length(character: Character) -> float:
    """Hip to sole of the standing body [m]; its height where it has no legs."""
    for side in ("left", "right"):
        joints = (f"{side}_knee", f"{side}_ankle")
        lengths = [np.linalg.norm(k.offset) for k in character.links if k.joint in joints]
        if len(lengths) == 2:
            return float(sum(lengths)) - character.sole_height
    return 0.53 * character.height


def _lift(clip: Clip, actor: Character, out: Clip, body: Character, scale: float) -> Array:
    """What to add to the body's height so that its soles are where the actor's are [m].

    While a sole of the actor rests on the floor the body's lowest sole is put on z = 0; in between,
    in a flight, it is as high as the actor's in scale.
    """
    if not (sole_points(actor) and sole_points(body)):
        return np.zeros(clip.frames)
    over_floor = sole_heights(standing(clip, actor), actor).min(axis=1)
    lift = scale * np.maximum(over_floor, 0.0) - sole_heights(out, body).min(axis=1)
    return gaussian_filter1d(lift, _SMOOTHING * clip.rate, mode="nearest")
