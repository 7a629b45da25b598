"""The floor that a clip stands on, read off its feet: level, sloping, or with things to step on.

A foot rests where most of its sole is slow. It bears the body where no other foot rests, or where
the center of mass is over it more than over the other; a foot held up in the air does not. Bearing
feet at one height are the floor. Where they lie on a plane that tilts, and are tilted like it, that
plane is the floor; where some are higher, there is a block under them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import binary_opening, find_objects, label

from understudy.character.body import Character
from understudy.character.soles import sole_paths
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array
from understudy.scene.ground import Block, Ground

SLOW = 0.35  # A point at rest is slower than this [m/s] ...
LASTS = 0.25  # ... and a foot that bears does so for this long [s], its height the same to
STEADY = 0.02  # within this [m].
SHARE = 0.35  # Of two feet at rest one bears that has this share of the weight.
# Feet this much higher than the floor stand on something [m]; less is a floor that is not level.
RAISED = 0.14
LIKE = 0.08  # Feet within this height [m] and
NEAR = 0.3  # within this distance [m] of each other stand on the same thing.
ASIDE, BEYOND = 0.25, 0.15  # A block is this much wider and longer than the feet on it [m].
PASSES = 0.08  # And a foot that passes this far below the top [m] passes before it.
CLEAR = 0.01  # A foot before a riser stands so far off it [m].
RISER = 0.1  # And begins at most this much before them [m].
SUNK = 0.03  # A foot held up this far inside a block [m] shows that it ends before there.
# Angles of a slope [rad]: less is a capture floor that is not level, more are stairs.
SLOPES = (np.radians(3.0), np.radians(25.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Rest:
    """A foot that bears: height of its sole [m], duration [s], places of its sole points (n, 3)."""

    height: float
    lasts: float
    points: Array

    @property
    def middle(self) -> Array:
        return self.points[:, :2].mean(axis=0)


def surveyed(clip: Clip, character: Character) -> tuple[Ground, str]:
    """The ground under a clip, and a note; level ground and no note where nothing speaks against.

    A sloping plane goes through the world's origin; the clip is not moved.

    Args:
        clip: On the character's own skeleton, at any height.
        character: A body with soles.
    """
    center = _center(clip, character)
    paths = [sole_paths(clip, character, side=side) for side in ("left", "right")]
    if clip.frames < 10 or any(path.shape[1] < 3 for path in paths):
        return Ground(), ""
    rests, still = _rests(paths, center, clip.rate)
    if len(rests) < 2:
        return Ground(), ""
    rests.sort(key=lambda rest: rest.height)
    floor = _floor(rests)
    sloping = _slope(rests)
    if sloping is not None:
        degrees = np.degrees(sloping.slope)
        way = np.degrees(sloping.heading)
        return sloping, f"The floor slopes: {degrees:.1f} degrees, up toward {way:.0f} degrees."
    raised = [rest for rest in rests if rest.height > floor + RAISED]
    if not raised:
        return Ground(), ""
    blocks = _blocks(rests, _clusters(raised), floor, (paths, still), _way_up(center))
    tops = ", ".join(f"{100.0 * block.height:.0f}" for block in blocks)
    return Ground(blocks=blocks), f"Feet stand on things {tops} cm high: put under them."


def _rests(paths: list[Array], center: Array, rate: float) -> tuple[list[_Rest], Array]:
    """Every stretch in which a foot bears, and where soles are that are held up, (n, 3)."""
    falls = -derivative(center[:, 2], rate, smoothing=0.125, order=2) > 7.0
    resting = [_resting(path, rate) for path in paths]
    middles = [path[..., :2].mean(axis=1) for path in paths]
    rests, hanging = [], []
    for own, other in ((0, 1), (1, 0)):
        apart = middles[own] - middles[other]
        along = np.sum((center[:, :2] - middles[other]) * apart, axis=1)
        share = along / np.maximum(np.sum(apart**2, axis=1), 1e-9)
        bears = resting[own] & (~resting[other] | (share > SHARE)) & ~falls
        rests += _steady(paths[own], bears, rate)
        hanging += _steady(paths[own], resting[own] & ~bears, rate)
    still = [rest.points for rest in hanging]
    return rests, np.concatenate(still) if still else np.zeros((0, 3))


def _steady(paths: Array, held: np.ndarray, rate: float) -> list[_Rest]:
    """Stretches of the frames `held` in which a foot keeps its height."""
    found = []
    labeled: Any = label(held)
    for (span,) in find_objects(labeled[0]):
        lows = paths[span, :, 2].min(axis=1)
        height = float(np.median(lows))
        steady = np.abs(lows - height) < STEADY
        if steady.sum() >= LASTS * rate:
            points = paths[span][steady].mean(axis=0)
            found.append(_Rest(height=height, lasts=float(steady.sum()) / rate, points=points))
    return found


def _resting(paths: Array, rate: float) -> np.ndarray:
    speed = np.linalg.norm(derivative(paths, rate, smoothing=0.1), axis=-1)
    slow = np.sort(speed, axis=1)[:, paths.shape[1] // 2] < SLOW
    return binary_opening(slow, iterations=max(1, round(0.04 * rate)))


def _center(clip: Clip, character: Character) -> Array:
    """Center of mass [m], shape (frames, 3)."""
    pose = clip.forward_kinematics()
    total = np.zeros((clip.frames, 3))
    for k, link in enumerate(character.links):
        total += link.mass * (pose.positions[:, k] + rot.rotate(pose.rotations[:, k], link.com))
    return total / sum(link.mass for link in character.links)


def _floor(rests: list[_Rest]) -> float:
    """Height of the lowest layer of rests that holds a twentieth of their time [m]."""
    whole, seen = sum(rest.lasts for rest in rests), 0.0
    for rest in rests:
        seen += rest.lasts
        if seen >= 0.05 * whole:
            return rest.height
    return rests[-1].height


def _slope(rests: list[_Rest]) -> Ground | None:
    """A tilted plane that the rests lie on and are tilted like."""
    places = np.array([rest.middle for rest in rests])
    heights = np.array([rest.height for rest in rests])
    rise = _gradient(places, heights)
    steep = float(np.linalg.norm(rise))
    if not SLOPES[0] < np.arctan(steep) < SLOPES[1] or np.ptp(heights) < RAISED:
        return None
    off = (heights - heights.mean()) - (places - places.mean(axis=0)) @ rise
    if np.sqrt(np.mean(off**2)) > STEADY:
        return None
    way = rise / steep
    tilts = []
    for rest in rests:
        along = (rest.points[:, :2] - rest.middle) @ way
        spread = float(np.sum(along**2))
        tilts.append(float(np.sum(along * rest.points[:, 2])) / max(spread, 1e-9))
    if np.median(tilts) < 0.5 * steep:
        return None
    return Ground(slope=float(np.arctan(steep)), heading=float(np.arctan2(way[1], way[0])))


def _gradient(places: Array, heights: Array) -> Array:
    """How much heights rise per meter of ground, shape (2,)."""
    away = places - places.mean(axis=0)
    return np.linalg.lstsq(away, heights - heights.mean(), rcond=0.1)[0]


def _way_up(center: Array) -> float:
    """Direction of the way over the ground that a center of mass goes, the end that is up [rad]."""
    away = center - center.mean(axis=0)
    way = np.linalg.svd(away[:, :2], full_matrices=False)[2][0]
    way = way * np.sign(float((away[:, :2] @ way) @ away[:, 2]) or 1.0)
    return float(np.arctan2(way[1], way[0]))


def _clusters(raised: list[_Rest]) -> list[list[_Rest]]:
    """Rests on the same thing, together; lowest first."""
    clusters: list[list[_Rest]] = []
    for rest in raised:
        for cluster in clusters:
            level = float(np.mean([other.height for other in cluster]))
            apart = min(float(np.linalg.norm(rest.middle - other.middle)) for other in cluster)
            if abs(rest.height - level) < LIKE and apart < NEAR + 0.3:
                cluster.append(rest)
                break
        else:
            clusters.append([rest])
    return clusters


def _blocks(
    rests: list[_Rest],
    clusters: list[list[_Rest]],
    floor: float,
    feet: tuple[list[Array], Array],
    heading: float,
) -> tuple[Block, ...]:
    """A block under each cluster, its sides along `heading`; lowest first.

    `feet` are the paths of both soles and the places of soles held up, (n, 3).
    """
    paths, still = feet
    passing = np.concatenate([path.reshape(-1, 3) for path in paths])
    cos, sin = np.cos(heading), np.sin(heading)
    turn = np.array([[cos, sin], [-sin, cos]])
    flat, swept = still[:, :2] @ turn.T, passing[:, :2] @ turn.T
    blocks: list[Block] = []
    behind = -np.inf  # where the block on top ends
    for cluster in reversed(clusters):
        own = np.concatenate([rest.points[:, :2] for rest in cluster]) @ turn.T
        top = max(cluster, key=lambda rest: rest.lasts).height
        low, high = own.min(axis=0), own.max(axis=0)
        sides = np.stack((low - np.array([RISER, ASIDE]), high + np.array([BEYOND, ASIDE])))
        lower = [rest.points[:, :2] @ turn.T for rest in rests if rest.height < top - LIKE]
        for foot in lower:
            # Between both feet; where the higher one stands with its heel or toes over the edge,
            # at the end of the lower one.
            if foot[:, 0].mean() < own[:, 0].mean():
                edge = foot[:, 0].max()
                edge = 0.5 * (edge + low[0]) if edge < low[0] else edge + CLEAR
                sides[0, 0] = max(sides[0, 0], min(edge, own[:, 0].mean()))
            else:
                edge = foot[:, 0].min()
                edge = 0.5 * (edge + high[0]) if edge > high[0] else edge - CLEAR
                sides[1, 0] = min(sides[1, 0], max(edge, own[:, 0].mean()))
        below = passing[:, 2] < top - PASSES
        beside = (swept[:, 1] > sides[0, 1]) & (swept[:, 1] < sides[1, 1])
        sides = _before(sides, float(own[:, 0].mean()), swept[below & beside, 0])
        sides = _cut(sides, low, high, flat[still[:, 2] < top - SUNK])
        sides[1, 0] = max(sides[1, 0], behind)
        behind = sides[1, 0]
        middle = sides.mean(axis=0) @ turn
        size = sides[1] - sides[0]
        blocks.append(
            Block(
                position=(float(middle[0]), float(middle[1])),
                height=top - floor,
                length=float(size[0]),
                width=float(size[1]),
                heading=heading,
            )
        )
    return tuple(reversed(blocks))


def _before(sides: Array, middle: float, along: Array) -> Array:
    """The rectangle with its ends where no foot passes below its top, as far as to its middle."""
    sides = np.array(sides)
    front = along[(along > sides[0, 0]) & (along < middle)]
    back = along[(along < sides[1, 0]) & (along > middle)]
    sides[0, 0] = min(front.max(initial=sides[0, 0] - CLEAR) + CLEAR, middle)
    sides[1, 0] = max(back.min(initial=sides[1, 0] + CLEAR) - CLEAR, middle)
    return sides


def _cut(sides: Array, low: Array, high: Array, points: Array) -> Array:
    """The rectangle (2, 2) without points that pass below its top, but never less than low, high.

    Of its four sides the one that has to give way least does, again and again.
    """
    sides = np.array(sides)
    for _ in range(8):
        within = points[((points > sides[0]) & (points < sides[1])).all(axis=1)]
        if not len(within):
            break
        costs = []
        for end, axis in ((0, 0), (0, 1), (1, 0), (1, 1)):
            edge = within[:, axis].max() if end == 0 else within[:, axis].min()
            edge = min(edge, low[axis]) if end == 0 else max(edge, high[axis])
            costs.append((abs(float(edge - sides[end, axis])), end, axis, float(edge)))
        movable = [cost for cost in costs if cost[0] > 1e-6]
        if not movable:
            break
        _, end, axis, edge = min(movable)
        sides[end, axis] = edge
    return sides
