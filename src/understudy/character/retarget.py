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
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip, Pose
from understudy.motion.edits import sampled
from understudy.motion.figure import PARENTS
from understudy.motion.rotations import Array

# The vertical correction that keeps soles on the ground is smoothed over this long [s].
_SMOOTHING = 0.03
# The floor under an actor: soles lower than this part of the time.
_FLOOR_QUANTILE = 0.05
# A sole at rest: a corner this near the lowest [m] and this slow [m/s].
_RESTING_HEIGHT, _RESTING_SPEED = 0.02, 0.5
# Captured floors are uneven by this part of stature; more is a step up.
_UNEVEN = 0.06


def retargeted(clip: Clip, character: Character) -> Clip:
    """A clip on a character's skeleton (its joint names, its rest T-pose).

    The clip the character was made from, or any edit of it, goes over exactly. Another person's
    clip goes over by role: missing joints follow their parent, joints the body lacks are composed
    into the next outboard, the hips' path is scaled by leg length about where it starts, and the
    lowest sole stays as high over the floor as the actor's, in scale.

    Raises:
        InvalidValue: A clip of another skeleton for a character without roles, or the reverse.
    """
    if clip.skeleton == character.skeleton:
        return clip
    if clip.skeleton == character.source:
        return _own(clip, character)
    if not character.humanoid:
        return _by_name(clip, character)
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
    lift = _lift(pose, actor, out.forward_kinematics(), body, scale, clip.rate)
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


def _sole_points(character: Character) -> list[tuple[int, Array]]:
    """Link and corners of every contact box of the feet [m], shape (4, 3)."""
    out = []
    for i, link in enumerate(character.links):
        if not link.joint.endswith(("ankle", "ball")):
            continue
        for shape in link.shapes:
            if shape.use == "contact":
                x, y, z = shape.size
                low = [(sx * x, sy * y, -z) for sx in (-1, 1) for sy in (-1, 1)]
                out.append((i, shape.position + np.array(low)))
    return out


def lowest_soles(pose: Pose, character: Character) -> Array:
    """Height of the lowest point of any sole [m], shape (frames,); the root's without feet."""
    points = _sole_points(character)
    if not points:
        return pose.positions[:, 0, 2]
    heights = [
        pose.positions[:, i, None, 2] + rot.rotate(pose.rotations[:, i, None], corners)[..., 2]
        for i, corners in points
    ]
    return np.concatenate(heights, axis=1).min(axis=1)


def _lift(
    pose: Pose, actor: Character, out: Pose, body: Character, scale: float, rate: float
) -> Array:
    """What to add to the body's height so that its soles are where the actor's are [m].

    While a sole of the actor rests on the floor the body's lowest sole is put on z = 0; in between,
    in a flight, it is as high as the actor's in scale.
    """
    if not (_sole_points(actor) and _sole_points(body)):
        return np.zeros(len(pose.positions))
    soles = lowest_soles(pose, actor)
    wanted = scale * np.maximum(soles - _floor(soles, pose, actor, rate), 0.0)
    lift = wanted - lowest_soles(out, body)
    return gaussian_filter1d(lift, _SMOOTHING * rate, mode="nearest") if len(lift) > 1 else lift


def _floor(soles: Array, pose: Pose, actor: Character, rate: float) -> Array:
    """Height of the floor under the actor [m], shape (frames,), as his resting soles show it."""
    level = float(np.quantile(soles, _FLOOR_QUANTILE))
    resting = np.zeros(len(soles), bool)
    for link, corners in _sole_points(actor):
        turned = rot.rotate(pose.rotations[:, link, None], corners)
        points = pose.positions[:, link, None] + turned
        if len(points) > 1:
            speed = np.linalg.norm(np.gradient(points, axis=0), axis=-1) * rate
        else:
            speed = np.zeros(points.shape[:2])
        low = points[..., 2] < soles[:, None] + _RESTING_HEIGHT
        resting |= (low & (speed < _RESTING_SPEED)).any(axis=1)
    # Steps and stages are no floor: the body climbs them as the actor did.
    resting &= np.abs(soles - level) < _UNEVEN * actor.height
    if not resting.any():
        return np.full(len(soles), level)
    frames = np.flatnonzero(resting)
    return np.interp(np.arange(len(soles)), frames, soles[frames])
