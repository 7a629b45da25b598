"""Soles that fit the way a clip stands.

A captured foot is a rigid line with noise: with soles drawn where anatomy puts them, heel, ball and
toes of a standing actor disagree about the floor by centimeters. So each contact point of a foot is
moved along the sole's normal until the clip itself says it stands on the floor, and the slow drift
of the floor under the clip (capture floors are not level) is taken out with the same points.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import (
    binary_closing,
    binary_opening,
    gaussian_filter1d,
    label,
    maximum_filter1d,
    median_filter,
    minimum_filter1d,
)

from understudy.character.body import Character
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array

SLOW = 0.35  # A point in stance moves slower than this [m/s].
LOW = 0.12  # And lies lower than this over the floor [m].
MOST = 0.03  # Most a point moves in one round [m].
ROUNDS = 3
# On uneven ground the lowest point within this time [s] is on it; the body goes up and down more
# slowly than the feet [s], and a foot in stance may be further off before it is planted [m].
DRIFT, UNEVEN_SMOOTHING, UNEVEN_HEIGHT = 0.3, 0.4, 0.08
EDGE = 0.04  # This near the edge of a step [m] a point may stand in front of it.
STANDS = 0.003  # A floor found this near z = 0 [m] is z = 0, and so is a foot moved by less.
MOST_SHIFT = 0.1  # A foot further off than this is not there by accident [m].
MOST_LIFT = 0.6  # Hands of a body with long arms may hang this far below the floor [m].
PLANTED_HEIGHT = 0.03  # A sole point in stance is lower than this [m]
PLANTED_SPEED = 0.7  # and slides no faster [m/s].
PLANT_SMOOTHING = 0.04  # [s].
# A foot swinging by at twice that speed or more passes at least this high over the floor [m].
CLEARANCE = 0.015
_UP = np.array([0.0, 0.0, 1.0])
_LEG, _ARM = ("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist")
# Axes a straight limb bends about, in its upper link's frame: a knee's, and an elbow's in T-pose.
_LATERAL, _VERTICAL = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


class Floor(Protocol):
    """What lies under the feet where it is not the plane z = 0."""

    def height(self, points: Any, /) -> Array:
        """Height under world points (..., 2 or more) [m], shape (...)."""
        ...

    def normals(self, points: Any, /) -> Array:
        """Unit normals there, shape (..., 3)."""
        ...


def fitted_soles(clip: Clip, character: Character) -> Character:
    """The body with soles fitted to the way a clip stands.

    Three rounds: the floor's height over time is where the lowest slow point is; each point then
    moves along its link's z until its own 5 % quantile of height is 0. Inner and outer points, left
    and right feet move alike: a body's shoes are alike.

    Args:
        clip: On the character's own skeleton.
        character: The body.

    Returns:
        The fitted body; the same where no foot is ever slow and low.
    """
    points = sole_points(character)
    if not points:
        return character
    shifts = np.zeros(len(points))
    grounded = clip
    for _ in range(ROUNDS):
        grounded = standing(grounded, character, shifts=shifts)
        heights, slow = _sole_motion(grounded, character, shifts)
        for k in range(len(points)):
            used = heights[slow[:, k] & (heights[:, k] < LOW), k]
            if len(used) >= 3:
                shifts[k] -= float(np.clip(np.quantile(used, 0.05), -MOST, MOST))
    return _moved(character, points, _shared(character, points, shifts))


def standing(
    clip: Clip,
    character: Character,
    *,
    shifts: Array | None = None,
    ground: Floor | None = None,
) -> Clip:
    """The clip lowered or raised, slowly over time, so that its resting soles touch the floor.

    Args:
        clip: On the character's own skeleton.
        character: A body with contact shapes at its feet; without any the clip is unchanged.
        shifts: Change of each sole point along its link's z [m], for a fit in progress.
        ground: The floor; None is z = 0. On a slope the feet are tilted with it.
    """
    if not sole_points(character):
        return clip
    if ground is not None:
        clip = _tilted(clip, character, ground)
    heights, slow = _sole_motion(clip, character, shifts, ground)
    base = _base(heights, slow)
    near, smooth, part = base, 0.15, 0.2
    if ground is not None:
        # A straight leg gets no longer: so low that feet have to be lifted to stand on the floor.
        smooth, part = UNEVEN_SMOOTHING, 0.9
        # Walking level over a slope, a clip is off the floor by more and more.
        window = 2 * round(DRIFT * clip.rate) + 1
        lows = np.where(slow, heights, np.inf).min(axis=1)
        lows = np.where(np.isfinite(lows), lows, heights.min(axis=1))
        near = minimum_filter1d(lows, window, mode="nearest")[:, None]
    resting = slow & (heights < near + LOW)
    known = resting.any(axis=1)
    if known.sum() < 3:
        return _lowered(clip, np.full(clip.frames, base))
    lowest = np.where(resting, heights, np.inf).min(axis=1)
    frames = np.arange(clip.frames)
    floor = np.interp(frames, frames[known], lowest[known])
    window = 2 * round(0.1 * clip.rate) + 1
    floor = median_filter(floor, window, mode="nearest")
    # Odd reflection at the ends keeps a walk up a slope going up.
    pad = 0 if ground is None else min(round(3.0 * smooth * clip.rate), clip.frames - 1)
    floor = np.pad(floor, pad, mode="reflect", reflect_type="odd")
    floor = gaussian_filter1d(floor, smooth * clip.rate, mode="nearest")
    floor = floor[pad : pad + clip.frames]
    after = np.where(resting, heights - floor[:, None], np.inf).min(axis=1)[known]
    floor += float(np.quantile(after, part)) + 0.001
    return _lowered(clip, floor)


def planted(clip: Clip, character: Character, *, ground: Floor | None = None) -> Clip:
    """The clip with feet that neither sink into the floor nor slide along it, and hands above it.

    A captured foot has no sole: pushing off, it turns its toes some centimeters into the floor, and
    in stance it drifts by how far the skeleton is off the actor's. A simulated one would trip and
    stick. The ankle is moved so that the foot's lowest point stays above z = 0 and, while it is
    low and slow, where it is; between stances the correction blends over. Hip and knee follow in
    the leg's own plane and the foot keeps its orientation. Hands that sink are lifted alike. A
    note says how far.

    Args:
        clip: On the character's own skeleton, standing on the floor.
        character: The body.
        ground: The floor; None is z = 0.
    """
    if clip.frames < 5 or not sole_points(character):
        return clip
    local, most = np.array(clip.rotations), {"feet": 0.0, "hands": 0.0}
    joints = [link.joint for link in character.links]
    for side in ("left", "right"):
        for part, limb, hinge in (("feet", _LEG, _LATERAL), ("hands", _ARM, _VERTICAL)):
            names = [f"{side}_{joint}" for joint in limb]
            points = [
                place
                for place, link in zip(*_paths(clip, character, part), strict=True)
                if joints[link].startswith(side)
            ]
            if not points or any(name not in joints for name in names):
                continue
            places = np.stack(points, axis=1)
            swinging = places
            if ground is not None:
                swinging = places - ground.height(places)[..., None] * _UP
                places[..., 2] -= _under(ground, places)
            if part == "feet":
                low = PLANTED_HEIGHT if ground is None else UNEVEN_HEIGHT
                shift = _planting(places, swinging, clip.rate, low)
            else:
                shift = np.zeros((clip.frames, 3))
                shift[:, 2] = _rise(-places[..., 2].min(axis=1), clip.rate, most=MOST_LIFT)
            if np.abs(shift).max() < STANDS:
                continue
            _move_end(clip, [joints.index(name) for name in names], shift, local, hinge)
            most[part] = max(most[part], float(np.linalg.norm(shift, axis=1).max()))
    notes = [
        f"{verb} the {part}{where}: moved by up to {1000 * most[part]:.0f} mm."
        for verb, part, where in (
            ("Planted", "feet", " on the floor"),
            ("Lifted", "hands", " out of the floor"),
        )
        if most[part] > 0.0
    ]
    return replace(clip, rotations=local, notes=(*clip.notes, *notes)) if notes else clip


def _planting(places: Array, swinging: Array, rate: float, low: float) -> Array:
    """How to move a foot [m], shape (frames, 3), from the paths of its sole points.

    `places` has shape (frames, points, 3), the lowest point of each sphere, its z over
    the floor. A point in stance is lower than `low` [m]. `swinging` is the same over every edge: a
    foot in swing passes above it.
    """
    frames = np.arange(len(places))
    lowest = places[..., 2].argmin(axis=1)
    height = places[frames, lowest, 2]
    velocity = derivative(places[..., :2], rate, smoothing=0.075)[frames, lowest]
    stance = (height < low) & (np.linalg.norm(velocity, axis=1) < PLANTED_SPEED)
    stance = binary_closing(np.pad(stance, 3, mode="edge"), iterations=3)[3:-3]
    stance = binary_opening(np.pad(stance, 9, mode="edge"), iterations=max(1, round(0.03 * rate)))
    found: Any = label(stance[9:-9])
    spans, count = found
    shift = np.zeros((len(places), 3))
    for span in (spans == k for k in range(1, count + 1)):
        # Undo the velocity of the point that bears; on average over the stance the foot stays put.
        path = -cumulative_trapezoid(velocity[span], dx=1.0 / rate, axis=0, initial=0.0)
        shift[span, :2] = path - path.mean(axis=0)
        shift[span, 2] = -height[span]
    shift = _blended(np.clip(shift, -MOST_SHIFT, MOST_SHIFT), spans > 0)
    shift = gaussian_filter1d(shift, 0.5 * PLANT_SMOOTHING * rate, axis=0, mode="nearest")
    # What still sinks or swings by too low is lifted by the greatest lack nearby, smoothed: no
    # corner in the path.
    swing = np.linalg.norm(velocity, axis=1) / PLANTED_SPEED - 1.0
    clear = CLEARANCE * np.clip(swing, 0.0, 1.0)
    lowest = np.where(spans > 0, places[..., 2].min(axis=1), swinging[..., 2].min(axis=1))
    shift[:, 2] += _rise(clear - (lowest + shift[:, 2]), rate)
    return shift


def _rise(depth: Array, rate: float, *, most: float = MOST_SHIFT) -> Array:
    """How far to lift [m] over time so that nothing stays `depth` too low, without a corner."""
    depth = np.clip(depth, 0.0, most)
    rise = maximum_filter1d(depth, 2 * round(PLANT_SMOOTHING * rate) + 1, mode="nearest")
    return gaussian_filter1d(rise, 0.5 * PLANT_SMOOTHING * rate, mode="nearest")


def _blended(shift: Array, stance: np.ndarray) -> Array:
    """The shift in stance, and monotone curves between stances; before and after as at the nearest.

    A correction that came in from nothing at the ends would be an acceleration no actor had.
    """
    knots = np.flatnonzero(stance)
    if not len(knots):
        return np.zeros_like(shift)
    if len(knots) == 1:
        return np.broadcast_to(shift[knots], shift.shape).copy()
    frames = np.clip(np.arange(len(shift)), knots[0], knots[-1])
    return PchipInterpolator(knots, shift[knots], axis=0)(frames)


def _move_end(clip: Clip, limb: list[int], shift: Array, local: Array, hinge: Array) -> None:
    """Change a limb's three rotations in `local` so that its end joint is moved by `shift` [m].

    `limb` is hip, knee and ankle, or shoulder, elbow and wrist; the foot or hand keeps its
    orientation. `hinge` is the axis in the upper link's frame to bend a straight limb about.
    """
    hip, knee, ankle = limb
    pose = clip.forward_kinematics()
    place, turned = pose.positions, pose.rotations
    inboard = turned[:, clip.skeleton.parents[hip]]
    thigh, shank = place[:, knee] - place[:, hip], place[:, ankle] - place[:, knee]
    wanted = place[:, ankle] + shift - place[:, hip]
    a, b = np.linalg.norm(thigh, axis=1), np.linalg.norm(shank, axis=1)
    now = np.linalg.norm(place[:, ankle] - place[:, hip], axis=1)
    # A leg does not stretch: at most as straight as it is, or all but straight.
    longest = np.maximum(now, 0.998 * (a + b))
    reach = np.clip(np.linalg.norm(wanted, axis=1), np.abs(a - b) + 1e-6, longest)

    def bend(distance: Array) -> Array:
        """Angle between thigh and shank [rad] at a distance of hip and ankle."""
        return np.arccos(np.clip((distance**2 - a**2 - b**2) / (2.0 * a * b), -1.0, 1.0))

    # The axis of the knee; where the leg is straight, the thigh's own.
    normal = np.cross(thigh, shank)
    lateral = rot.rotate(turned[:, hip], hinge)
    lateral -= thigh * (np.sum(lateral * thigh, axis=1) / a**2)[:, None]
    blend = np.clip(np.linalg.norm(normal, axis=1) / (0.05 * a * b), 0.0, 1.0)[:, None]
    size = np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    axis = blend * normal / size + (1.0 - blend) * lateral
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    fold = rot.from_rotvec(axis * (bend(reach) - bend(now))[:, None])
    swing = rot.shortest_arc(thigh + rot.rotate(fold, shank), wanted)
    thigh_turned = rot.multiply(swing, turned[:, hip])
    shank_turned = rot.multiply(swing, rot.multiply(fold, turned[:, knee]))
    local[:, hip] = rot.multiply(rot.conjugate(inboard), thigh_turned)
    local[:, knee] = rot.multiply(rot.conjugate(thigh_turned), shank_turned)
    local[:, ankle] = rot.multiply(rot.conjugate(shank_turned), turned[:, ankle])


def sole_points(character: Character) -> list[tuple[int, Array, float]]:
    """Link, center in the link frame [m] and radius [m] of every contact sphere of the feet."""
    return [
        (i, shape.position, float(shape.size[0]))
        for i, link in enumerate(character.links)
        if _is_foot(link.joint)
        for shape in link.shapes
        if shape.contact and shape.kind == "sphere"
    ]


def sole_paths(clip: Clip, character: Character, *, side: str = "") -> Array:
    """World path of the lowest point of every sole sphere [m], shape (frames, points, 3).

    Of both feet, or of the "left" or "right".
    """
    found = zip(*_paths(clip, character, "feet"), strict=True)
    paths = [path for path, link in found if character.links[link].joint.startswith(side)]
    return np.stack(paths, axis=1) if paths else np.zeros((clip.frames, 0, 3))


def sole_heights(clip: Clip, character: Character) -> Array:
    """Height of every sole point over z = 0 [m], shape (frames, points)."""
    return _sole_motion(clip, character, None)[0]


def _is_foot(joint: str) -> bool:
    return joint.endswith(("_ankle", "_ball"))


def _paths(clip: Clip, character: Character, part: str) -> tuple[list[Array], list[int]]:
    """World path [m] of the lowest point of every end of a contact shape, (frames, 3), and link.

    `part` is "feet" (spheres) or "hands" (capsules, with their two ends).
    """
    pose = clip.forward_kinematics()
    points = sole_points(character) if part == "feet" else _hand_points(character)
    paths = [
        pose.positions[:, link]
        + rot.rotate(pose.rotations[:, link], center)
        - np.array([0.0, 0.0, radius])
        for link, center, radius in points
    ]
    return paths, [link for link, _, _ in points]


def _hand_points(character: Character) -> list[tuple[int, Array, float]]:
    """Link, center in the link frame [m] and radius [m] of both ends of the hands' capsules."""
    return [
        (i, shape.position + end * rot.rotate(shape.rotation, np.array([0.0, 0.0, 1.0])), radius)
        for i, link in enumerate(character.links)
        if link.joint.endswith("_wrist")
        for shape in link.shapes
        if shape.contact and shape.kind == "capsule"
        for radius in [float(shape.size[0])]
        for end in (-float(shape.size[1]), float(shape.size[1]))
    ]


def _tilted(clip: Clip, character: Character, ground: Floor) -> Clip:
    """The clip with each foot turned as the plane under it is turned from the level."""
    pose, local = clip.forward_kinematics(), np.array(clip.rotations)
    for k, link in enumerate(character.links):
        if not link.joint.endswith("_ankle"):
            continue
        up = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (clip.frames, 3))
        normals = gaussian_filter1d(
            ground.normals(pose.positions[:, k]), 0.1 * clip.rate, axis=0, mode="nearest"
        )
        tilt = rot.shortest_arc(up, normals)
        above = pose.rotations[:, link.parent]
        turned = rot.multiply(tilt, pose.rotations[:, k])
        local[:, k] = rot.multiply(rot.conjugate(above), turned)
    # A level floor leaves the feet bitwise as they are.
    same = np.allclose(local, clip.rotations, atol=1e-12)
    return clip if same else replace(clip, rotations=local)


def _under(ground: Floor, places: Array) -> Array:
    """Height of the ground under points (..., 3) [m]; within a riser, that of the lower tread.

    A toe that a captured clip puts a little into a riser stands in front of it.
    """
    here = ground.height(places)
    around = [
        ground.height(places[..., :2] + EDGE * np.array(way))
        for way in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
    ]
    low = np.min(around, axis=0)
    return np.where(places[..., 2] < np.minimum(here - EDGE, 0.5 * (here + low)), low, here)


def _sole_motion(
    clip: Clip, character: Character, shifts: Array | None, ground: Floor | None = None
) -> tuple[Array, np.ndarray]:
    """Heights of the sole points over the floor [m] and whether each is slow, (frames, points)."""
    pose = clip.forward_kinematics()
    heights, slow = [], []
    for k, (link, center, radius) in enumerate(sole_points(character)):
        at = center if shifts is None else center + np.array([0.0, 0.0, shifts[k]])
        place = pose.positions[:, link] + rot.rotate(pose.rotations[:, link], at)
        speed = np.linalg.norm(derivative(place, clip.rate, smoothing=0.075), axis=1)
        low = place[:, 2] - radius
        if ground is not None:
            low = low - _under(ground, np.concatenate((place[:, :2], low[:, None]), axis=1))
        heights.append(low)
        slow.append(speed < SLOW)
    return np.stack(heights, axis=1), np.stack(slow, axis=1)


def _base(heights: Array, slow: np.ndarray) -> float:
    """A first guess of the floor: the 5 % quantile of slow points, or of the lowest points."""
    values = heights[slow] if slow.sum() >= 3 else heights.min(axis=1)
    return float(np.quantile(values, 0.05))


def _lowered(clip: Clip, floor: Array) -> Clip:
    # A clip that stands within the contact's own depth stands already.
    if np.abs(floor).max() < STANDS:
        return clip
    path = np.array(clip.root_positions)
    path[:, 2] -= floor
    low, high = 1000.0 * floor.min(), 1000.0 * floor.max()
    note = f"Set on the floor: lowered by {low:.0f} to {high:.0f} mm."
    kept = tuple(n for n in clip.notes if not n.startswith("Set on the floor:"))
    return replace(clip, root_positions=path, notes=(*kept, note))


def _shared(character: Character, points: list[tuple[int, Array, float]], shifts: Array) -> Array:
    kinds = [
        (character.links[link].joint.partition("_")[2], round(float(center[0]), 3))
        for link, center, _ in points
    ]
    out = np.array(shifts)
    for kind in set(kinds):
        same = [k for k, other in enumerate(kinds) if other == kind]
        out[same] = np.mean(shifts[same])
    return out


def _moved(
    character: Character, points: list[tuple[int, Array, float]], shifts: Array
) -> Character:
    links, k = list(character.links), 0
    for i in dict.fromkeys(link for link, _, _ in points):
        shapes = []
        for shape in links[i].shapes:
            if shape.contact and shape.kind == "sphere":
                up = np.array([0.0, 0.0, shifts[k]])
                shape = replace(shape, position=shape.position + up)
                k += 1
            shapes.append(shape)
        links[i] = replace(links[i], shapes=tuple(shapes))
    return replace(character, links=tuple(links))
