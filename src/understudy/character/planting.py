"""Feet planted on the floor, and hands above it or on it, by inverse kinematics.

A captured foot has no sole, and a captured hand rarely meets the floor it leans on. Ends of limbs
are moved a little so that what rests stays where it is; thigh and shank, or both parts of the arm,
follow in the limb's own plane, and the foot or hand keeps its orientation.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import binary_closing, binary_opening, gaussian_filter1d, label, maximum_filter1d

from understudy.character.body import Character
from understudy.character.soles import (
    STANDS,
    UNEVEN_HEIGHT,
    Floor,
    point_paths,
    sole_points,
    under,
)
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array

MOST_SHIFT = 0.1  # A foot further off than this is not there by accident [m].
MOST_LIFT = 0.6  # Hands of a body with long arms may hang this far below the floor [m].
PLANTED_HEIGHT = 0.03  # A sole point in stance is lower than this [m]
ROLLING = 0.03  # Bearing on an edge, a foot stands on no point this much higher [m].
PLANTED_SPEED = 0.7  # and slides no faster [m/s].
PLANT_SMOOTHING = 0.04  # [s].
# A foot swinging by at twice that speed or more passes at least this high over the floor [m].
CLEARANCE = 0.015
# Ground that differs by more under one sole is an edge [m], and is passed so high, however slowly.
RISER, EDGE_CLEARANCE = 0.03, 0.03
LEG, ARM = ("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist")
# Axes a straight limb bends about, in its upper link's frame: a knee's, and an elbow's in T-pose.
LATERAL, VERTICAL = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


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
        for part, limb, hinge in (("feet", LEG, LATERAL), ("hands", ARM, VERTICAL)):
            names = [f"{side}_{joint}" for joint in limb]
            points = [
                place
                for place, link in zip(*point_paths(clip, character, part), strict=True)
                if joints[link].startswith(side)
            ]
            if not points or any(name not in joints for name in names):
                continue
            places = np.stack(points, axis=1)
            if part == "feet":
                shift = _planting(places, clip.rate, ground)
            else:
                depth = -_over(places, ground)[..., 2].min(axis=1)
                shift = np.zeros((clip.frames, 3))
                shift[:, 2] = _rise(depth, clip.rate, most=MOST_LIFT)
            if np.abs(shift).max() < STANDS:
                continue
            moved_end(clip, [joints.index(name) for name in names], shift, local, hinge)
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


def _over(places: Array, ground: Floor | None) -> Array:
    """Places (..., 3) [m] with their height over the ground instead of over z = 0."""
    if ground is None:
        return places
    height = places[..., 2] - under(ground, places)
    return np.concatenate((places[..., :2], height[..., None]), axis=-1)


def _sole(places: Array) -> Array:
    """Points all over a foot's sole [m], (frames, more, 3): an edge may meet it anywhere.

    `places` are the lowest points of its spheres, (frames, points, 3), in pairs from heel to toe.
    """
    back, front = places[:, :-2], places[:, 2:]
    between = [back + part * (front - back) for part in (0.2, 0.4, 0.6, 0.8)]
    return np.concatenate((places, *between), axis=1)


def _planting(paths: Array, rate: float, ground: Floor | None) -> Array:
    """How to move a foot [m], shape (frames, 3), from the paths of its sole points.

    `paths` has shape (frames, points, 3), the lowest point of each sphere. Where the ground is
    uneven, a foot in swing passes above every edge, and one that rolls over an edge is in swing.
    """
    places = _over(paths, ground)
    low = PLANTED_HEIGHT if ground is None else UNEVEN_HEIGHT
    frames = np.arange(len(places))
    lowest = places[..., 2].argmin(axis=1)
    height = places[frames, lowest, 2]
    velocity = derivative(places[..., :2], rate, smoothing=0.075)[frames, lowest]
    stance = (height < low) & (np.linalg.norm(velocity, axis=1) < PLANTED_SPEED)
    if ground is not None:
        stance &= height - _over(_sole(paths), ground)[..., 2].min(axis=1) < ROLLING
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
    lowest = height + shift[:, 2]
    if ground is not None:
        sole = _sole(paths + shift[:, None])
        floor = ground.height(sole)
        lowest = np.where(spans > 0, lowest, (sole[..., 2] - floor).min(axis=1))
        clear[(spans == 0) & (np.ptp(floor, axis=1) > RISER)] = EDGE_CLEARANCE
    shift[:, 2] += _rise(clear - lowest, rate)
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


def moved_end(clip: Clip, limb: list[int], shift: Array, local: Array, hinge: Array) -> None:
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
