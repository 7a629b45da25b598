"""Standing on two feet that stay where they are: where they stand, and legs closed under a body.

A bow that keeps its balance moves the hips back as the trunk goes forward. Captured legs do so by
themselves; legs that were never captured, or another body's, are made to: the pelvis keeps the
clip's orientation and goes where it holds the center of mass over the middle of the feet.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from understudy.character.body import Character
from understudy.character.soles import SLOW, sole_points
from understudy.errors import InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.limbs import bent
from understudy.motion.rotations import Array
from understudy.motion.skeleton import frozen_array

SIDES = ("left", "right")
# A natural stance: feet under the hip joints, turned outward [deg], knees all but straight [deg].
TOE_OUT, KNEES = 8.0, 9.0
# A foot rests that is slow, flat to within this [rad] and this near its lowest [m] ...
_FLAT, _NEAR = np.radians(20.0), 0.05
# ... and a clip stands whose two feet rest together for at least this much of its time, each within
# this of one place [m].
_STANDS, _PLACE = 0.7, 0.06
# The pelvis does not follow what moves faster than this [s]: arms that beat five times a second
# would shake it.
_SMOOTHING = 0.12
# Over this height [m] the pelvis comes to rest at the end of its legs' reach.
_SOFT = 0.003
_ROUNDS = 25
# How far a pelvis can tilt over its feet, and turn away from them [rad].
_MOST_TILT, _MOST_TURN = np.radians(110.0), np.radians(70.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Footing:
    """Two feet flat on the plane z = 0, left and right.

    Attributes:
        ankles: Positions of the ankle joints [m], world, shape (2, 3).
        feet: World rotations of the feet, shape (2, 4).
        toes: Local rotations of the ball joints, shape (2, 4).
        soles: Middle of each sole [m], world, on the floor, shape (2, 3).
        captured: Whether the clip stands so; otherwise it is a natural stance.
    """

    ankles: Array
    feet: Array
    toes: Array
    soles: Array
    captured: bool = False

    def __post_init__(self) -> None:
        for name, shape in (
            ("ankles", (2, 3)),
            ("feet", (2, 4)),
            ("toes", (2, 4)),
            ("soles", (2, 3)),
        ):
            object.__setattr__(self, name, frozen_array(getattr(self, name), shape, name))

    @property
    def center(self) -> Array:
        """Middle of the support [m], world, shape (3,)."""
        return self.soles.mean(axis=0)


@dataclass(frozen=True)
class Sole:
    """The sole of a flat foot, in the frame of the foot's link.

    Attributes:
        tilt: What turns the foot flat where it points along x, shape (4,).
        toes: Local rotation of the ball joint that lays the toes flat, shape (4,).
        middle: Center of the sole's outline, on the sole, in the foot's frame [m], shape (3,).
        half: Half of its length and of its width [m].
    """

    tilt: Array
    toes: Array
    middle: Array
    half: tuple[float, float]


def sole_of(character: Character, side: str) -> Sole:
    """The sole of a foot that stands flat.

    Raises:
        UnknownName: The body has no such foot.
        InvalidValue: The foot has too few points to stand on.
    """
    foot = character.index(f"{side}_ankle")
    points = sole_points(character)
    own = [(center, radius) for link, center, radius in points if link == foot]
    if len(own) < 3:
        raise InvalidValue(
            f"The {side} foot of {character.name!r} has {len(own)} contact points; to stand on it "
            "takes three or more."
        )
    centers, lows = np.array([center for center, _ in own]), np.array([radius for _, radius in own])
    tilt = _leveling(centers - np.array([0.0, 0.0, 1.0]) * lows[:, None])
    down = rot.rotate(rot.conjugate(tilt), np.array([0.0, 0.0, -1.0]))
    soles = [center + radius * down for center, radius in own]
    level = float(np.mean([sole @ down for sole in soles]))
    toes = rot.identity()
    try:
        ball = character.index(f"{side}_ball")
    except UnknownName:
        ball = -1
    ends = [(center, radius) for link, center, radius in points if link == ball]
    if ends:
        # The toes turn about the foot's lateral axis until their points lie in the sole's plane.
        at, middle = character.links[ball].offset, np.mean([center for center, _ in ends], axis=0)
        want = level - ends[0][1] - float(at @ down)
        a, b = (
            float(np.delete(middle, 1) @ np.delete(down, 1)),
            float(middle[2] * down[0] - middle[0] * down[2]),
        )
        size = float(np.hypot(a, b))
        turn = np.arctan2(b, a)
        angle = np.arccos(np.clip(want / size, -1.0, 1.0))
        nearest = min((turn + angle, turn - angle), key=lambda t: abs(_half_turn(t)))
        toes = rot.from_rotvec(np.array([0.0, _half_turn(nearest), 0.0]))
        soles += [at + rot.rotate(toes, center) + radius * down for center, radius in ends]
    flat = rot.rotate(tilt, np.array(soles))
    low, high = flat.min(axis=0), flat.max(axis=0)
    middle = rot.rotate(rot.conjugate(tilt), 0.5 * (low + high))
    return Sole(tilt, toes, middle, (float(high[0] - low[0]) / 2, float(high[1] - low[1]) / 2))


def footing(clip: Clip, character: Character, *, during: np.ndarray | None = None) -> Footing:
    """Where the clip's feet stand, laid flat; where they do not rest, a natural stance below it.

    Args:
        clip: On the character's own skeleton.
        character: A body with legs and feet.
        during: Frames to look at, shape (frames,) of bool; all by default.
    """
    look = np.ones(clip.frames, bool) if during is None or not during.any() else during
    pose = clip.forward_kinematics()
    yaw = _heading(pose.rotations[look, 0])
    soles = [sole_of(character, side) for side in SIDES]
    where, turned, resting = [], [], np.ones(int(look.sum()), bool)
    for side, sole in zip(SIDES, soles, strict=True):
        i = character.index(f"{side}_ankle")
        place = pose.positions[:, i] + rot.rotate(pose.rotations[:, i], sole.middle)
        speed = np.linalg.norm(derivative(place, clip.rate, smoothing=0.075), axis=1)[look]
        place = place[look]
        flat = rot.multiply(pose.rotations[look, i], rot.conjugate(sole.tilt))
        up = rot.rotate(flat, np.array([0.0, 0.0, 1.0]))[:, 2]
        middle = np.median(place, axis=0)
        away = np.linalg.norm(place[:, :2] - middle[:2], axis=1)
        resting &= (speed < SLOW) & (up > np.cos(_FLAT)) & (away < _PLACE)
        resting &= place[:, 2] < _NEAR
        where.append(middle)
        turned.append(_heading(flat))
    captured = bool(resting.mean() >= _STANDS)
    if not captured:
        where, turned = _natural(clip, character, pose.positions[look, 0], yaw)
    ankles, feet = np.zeros((2, 3)), np.zeros((2, 4))
    for k, sole in enumerate(soles):
        feet[k] = rot.multiply(rot.from_euler("Z", np.array([turned[k]])), sole.tilt)
        ankles[k] = np.array([*where[k][:2], 0.0]) - rot.rotate(feet[k], sole.middle)
    middles = np.array([[*place[:2], 0.0] for place in where])
    toes = np.array([sole.toes for sole in soles])
    return Footing(ankles=ankles, feet=feet, toes=toes, soles=middles, captured=captured)


_TRAVEL = 0.3  # A pelvis that moves farther than this along the ground [m] does not just sway.


def balanced(
    clip: Clip, character: Character, feet: Footing, *, during: np.ndarray | None = None
) -> Clip:
    """The clip with its legs closed on two fixed feet and its center of mass over their middle.

    The pelvis keeps the clip's orientation and, where the clip stands, its height; the upper body
    is as it was. The pelvis goes where the center of mass is over the middle of the feet.

    Args:
        clip: On the character's own skeleton.
        character: A body with legs and feet.
        feet: Where it stands; see `footing`.
        during: Frames that are to be balanced, shape (frames,) of bool; all by default. The others
            must not be possible.

    Raises:
        InvalidValue: The pelvis turns away from the feet or lies, or the feet are too far apart.
    """
    _check_pelvis(clip, feet, during)
    legs = [
        [character.index(f"{side}_{joint}") for joint in ("hip", "knee", "ankle")] for side in SIDES
    ]
    masses = np.array([link.mass for link in character.links])
    upper, moment = _upper(clip, character, legs)
    turned = clip.rotations[:, 0]
    hips = [rot.rotate(turned, character.links[leg[0]].offset) for leg in legs]
    path = np.array(clip.root_positions)
    path[:, :2] = feet.center[:2]
    local = np.array(clip.rotations)

    def close() -> Array:
        """Set the pelvis' height and both legs; return the center of mass."""
        path[:, 2] = _height(clip, character, legs, hips, path, feet)
        total = moment + upper * path
        for k, leg in enumerate(legs):
            total = total + _close_leg(character, leg, path + hips[k], turned, feet, k, local)
        return total / masses.sum()

    for _ in range(_ROUNDS):
        off = feet.center[:2] - close()[:, :2]
        path[:, :2] += 1.2 * off
        if np.abs(off).max() < 1e-5:
            break
    if clip.frames > 2:
        path[:, :2] = gaussian_filter1d(path[:, :2], _SMOOTHING * clip.rate, axis=0, mode="nearest")
    close()
    for k, side in enumerate(SIDES):
        if f"{side}_ball" in clip.skeleton.names:
            local[:, character.index(f"{side}_ball")] = feet.toes[k]
    stood = "where the clip stands" if feet.captured else "in a natural stance"
    notes = [f"Balanced: both feet flat {stood}, the center of mass over them."]
    travel = float(np.ptp(clip.root_positions[:, :2], axis=0).max())
    if travel > _TRAVEL:
        notes.append(f"The clip travels {travel:.1f} m; balancing, the body stays on the spot.")
    return replace(clip, rotations=local, root_positions=path, notes=(*clip.notes, *notes))


# -- details -----------------------------------------------------------------------------------


def _upper(clip: Clip, character: Character, legs: list[list[int]]) -> tuple[float, Array]:
    """Mass of all but the legs [kg], and its moment about the pelvis [kg m], (frames, 3)."""
    pose = clip.forward_kinematics()
    below = {i for leg in legs for i in leg}
    for i, link in enumerate(character.links):
        if link.parent in below:
            below.add(i)
    mass, moment = 0.0, np.zeros((clip.frames, 3))
    for i, link in enumerate(character.links):
        if i not in below:
            at = pose.positions[:, i] + rot.rotate(pose.rotations[:, i], link.com)
            mass += link.mass
            moment += link.mass * (at - pose.positions[:, 0])
    return mass, moment


def _check_pelvis(clip: Clip, feet: Footing, during: np.ndarray | None) -> None:
    turned = clip.rotations[:, 0] if during is None else clip.rotations[during, 0]
    up = rot.rotate(turned, np.array([0.0, 0.0, 1.0]))[:, 2]
    if up.min() < np.cos(_MOST_TILT):
        raise InvalidValue(
            f"The pelvis tilts by {np.degrees(np.arccos(up.min())):.0f} deg; on its feet it can "
            f"tilt by {np.degrees(_MOST_TILT):.0f}."
        )
    ahead = rot.rotate(feet.feet, np.array([1.0, 0.0, 0.0])).sum(axis=0)
    side = rot.rotate(turned, np.array([0.0, 1.0, 0.0]))
    # Of the side, which a bow leaves level.
    yaw = np.arctan2(-side[:, 0], side[:, 1]) - np.arctan2(ahead[1], ahead[0])
    most = np.abs((yaw + np.pi) % (2.0 * np.pi) - np.pi).max()
    if most > _MOST_TURN:
        raise InvalidValue(
            f"The pelvis turns {np.degrees(most):.0f} deg away from the feet; while they stay it "
            f"can turn by {np.degrees(_MOST_TURN):.0f}."
        )


def _height(
    clip: Clip,
    character: Character,
    legs: list[list[int]],
    hips: list[Array],
    path: Array,
    feet: Footing,
) -> Array:
    """Height of the pelvis [m], (frames,): the clip's where it stands, but within reach."""
    bend = np.radians(KNEES)
    tops = []
    for k, (_, knee, ankle) in enumerate(legs):
        a = float(np.linalg.norm(character.links[knee].offset))
        b = float(np.linalg.norm(character.links[ankle].offset))
        reach = a * a + b * b + 2.0 * a * b * np.cos(bend)
        away = (path + hips[k] - feet.ankles[k])[:, :2]
        room = reach - np.sum(away**2, axis=1)
        if room.min() < 0.25 * reach:
            raise InvalidValue(
                f"The {SIDES[k]} foot is {np.sqrt(np.sum(away**2, axis=1).max()):.2f} m beside the "
                f"hip and the leg is {a + b:.2f} m long; the feet stand too far apart."
            )
        tops.append(feet.ankles[k, 2] + np.sqrt(room) - hips[k][:, 2])
    top = _lower(tops[0], tops[1])
    return _lower(top, clip.root_positions[:, 2]) if feet.captured else top


def _lower(a: Array, b: Array) -> Array:
    """The lower of two heights, rounded off over `_SOFT`; never higher."""
    return 0.5 * (a + b - np.sqrt((a - b) ** 2 + _SOFT**2))


def _close_leg(
    character: Character,
    leg: list[int],
    start: Array,
    pelvis: Array,
    feet: Footing,
    k: int,
    local: Array,
) -> Array:
    """Set a leg's three rotations in `local`; return its mass times its center [kg m]."""
    hip, knee, ankle = leg
    links = character.links
    target = np.broadcast_to(feet.ankles[k], start.shape)
    foot = np.broadcast_to(feet.feet[k], (len(start), 4))
    ahead = rot.rotate(foot, np.array([1.0, 0.0, 0.0])) * np.array([1.0, 1.0, 0.0])
    thigh, shank = bent(start, target, ahead, links[knee].offset, links[ankle].offset)
    local[:, hip] = rot.multiply(rot.conjugate(pelvis), thigh)
    local[:, knee] = rot.multiply(rot.conjugate(thigh), shank)
    local[:, ankle] = rot.multiply(rot.conjugate(shank), foot)
    at = start + rot.rotate(thigh, links[knee].offset)
    total = links[hip].mass * (start + rot.rotate(thigh, links[hip].com))
    total += links[knee].mass * (at + rot.rotate(shank, links[knee].com))
    total += links[ankle].mass * (target + rot.rotate(foot, links[ankle].com))
    for link in links:
        if link.parent == ankle:
            at = target + rot.rotate(foot, link.offset)
            turn = rot.multiply(feet.feet[k], feet.toes[k])
            total += link.mass * (at + rot.rotate(turn, link.com))
    return total


def _natural(
    clip: Clip, character: Character, path: Array, yaw: float
) -> tuple[list[Array], list[float]]:
    """Middles of the soles [m] and headings [rad] of a natural stance below a path."""
    middle = np.mean(path, axis=0)
    facing = rot.from_euler("Z", np.array([yaw]))
    where, turned = [], []
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        apart = abs(float(character.link(f"{side}_hip").offset[1]))
        where.append(middle + rot.rotate(facing, np.array([0.0, sign * apart, 0.0])))
        turned.append(yaw + sign * np.radians(TOE_OUT))
    return where, turned


def _heading(rotations: Array) -> float:
    """Mean direction of the x axis on the floor [rad]."""
    ahead = rot.rotate(rotations, np.array([1.0, 0.0, 0.0])).reshape(-1, 3).sum(axis=0)
    return float(np.arctan2(ahead[1], ahead[0]))


def _leveling(points: Array) -> Array:
    """The rotation that makes the plane through points (n, 3) level."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle)[2][-1]
    return rot.shortest_arc(normal * np.sign(normal[2] or 1.0), np.array([0.0, 0.0, 1.0]))


def _half_turn(angle: float) -> float:
    """The same angle within -pi to pi [rad]."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
