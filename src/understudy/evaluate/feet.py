"""Soles: how far feet slide while they stand, in a simulation and in the clip it tracked.

Two rules say when a foot stands. In a simulation its contact force does. A clip has no forces, so
its foot stands where the lowest point of the sole is near the ground and slow; the same rule is
applied to the simulated motion so that the two can be compared.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from understudy.evaluate.events import ContactEvent, events_of, touching
from understudy.evaluate.force_plate import as_by_plate
from understudy.evaluate.measure import Measured, Performer
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.scene import Ground

NEAR_GROUND = 0.03
"""A sole point lower than this may stand [m]."""
SLOW = 0.35
"""A sole point slower than this may stand [m/s]; a foot in swing passes the ground at 3 m/s."""
LOADED = 0.02
"""Share of body weight a foot must carry to count as standing."""
STEP_GAP = 0.1
"""A foot that leaves the ground for less than this has not taken a step [s]; swings last 0.2 s and
more, a heel that lifts off and settles again some hundredths."""
GROUND = "ground"


@dataclass(frozen=True, kw_only=True)
class Slide:
    """How much feet slid while they stood.

    Attributes:
        speed: Mean speed along the ground while standing [m/s]; None when no foot ever stood.
        standing: Per foot, whether it stood, shape (frames, feet).
        speeds: Per foot, speed along the ground [m/s], shape (frames, feet).
        lowest: Height of the lowest sole point over all feet [m], shape (frames,).
    """

    speed: float | None
    standing: np.ndarray[Any, np.dtype[np.bool_]] = field(repr=False)
    speeds: Array = field(repr=False)
    lowest: Array = field(repr=False)


@dataclass(frozen=True, kw_only=True)
class Footfalls:
    """How often and how long one foot, with its toes, was on the ground.

    Attributes:
        foot: The link that is the foot.
        touchdowns: How often it came down, the start of a take that begins on it included.
        stance_mean_s: Mean time on the ground [s].
        impulse_mean_ns: Mean impulse of the ground on it [N s].
        peak_force_n: Largest force, filtered as a force plate's [N].
        peak_force_percent: The same [% of body weight].
        spike_force_n: Largest force at any one step, unfiltered [N].
        penetration_mm: Deepest overlap [mm].
        events: Each stay on the ground.
    """

    foot: str
    touchdowns: int
    stance_mean_s: float
    impulse_mean_ns: float
    peak_force_n: float
    peak_force_percent: float
    spike_force_n: float
    penetration_mm: float
    events: tuple[ContactEvent, ...] = field(repr=False)

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes, without the single events."""
        names = ("foot", "touchdowns", "stance_mean_s", "impulse_mean_ns", "peak_force_n")
        names += ("peak_force_percent", "spike_force_n", "penetration_mm")
        return {name: getattr(self, name) for name in names}


def footfalls(measured: Measured) -> tuple[Footfalls, ...]:
    """The stays on the ground of every foot of every character, where it had any."""
    names, out = measured.owners, []
    if GROUND not in names.names:
        return ()
    for who in measured.performers:
        for bodies in feet(who).values():
            foot, *toes = (names.names[names.of_body[body]] for body in bodies)
            rows = touching(measured, foot, GROUND, merged=dict.fromkeys(toes, foot))
            stays = events_of(rows, gap=STEP_GAP)
            if not stays:
                continue
            force = measured.ground_reaction(who.index, links=bodies)
            peak = float(np.linalg.norm(as_by_plate(force, measured.rate), axis=1).max())
            out.append(
                Footfalls(
                    foot=foot,
                    touchdowns=len(stays),
                    stance_mean_s=float(np.mean([stay.duration_s for stay in stays])),
                    impulse_mean_ns=float(np.mean([stay.impulse_ns for stay in stays])),
                    peak_force_n=peak,
                    peak_force_percent=100.0 * peak / who.weight,
                    spike_force_n=max(stay.peak_force_n for stay in stays),
                    penetration_mm=max(stay.penetration_mm for stay in stays),
                    events=stays,
                )
            )
    return tuple(out)


def without_footfalls(
    measured: Measured, events: tuple[ContactEvent, ...]
) -> tuple[ContactEvent, ...]:
    """The events that are not a foot on the ground."""
    names = measured.owners
    soles = {
        names.names[names.of_body[body]]
        for who in measured.performers
        for bodies in feet(who).values()
        for body in bodies
    }
    return tuple(e for e in events if not (e.between[0] in soles and e.between[1] == GROUND))


def feet(who: Performer) -> dict[str, np.ndarray[Any, np.dtype[np.int64]]]:
    """Body numbers of each foot (with its toes) by side; empty without roles for feet."""
    sides = {
        side: who.bodies_with_roles(f"{side}_ankle", f"{side}_ball") for side in ("left", "right")
    }
    return {side: bodies for side, bodies in sides.items() if len(bodies)}


def loaded_slide(measured: Measured, character: int = 0) -> Slide:
    """Slide of the simulated feet, standing where they carry at least 2 % of body weight.

    The speed of a foot is that of its contact points, weighted by their normal forces.
    """
    who, table, frames = measured.performer(character), measured.contacts, measured.frames
    pairs = list(feet(who).values())
    speeds, standing = np.zeros((frames, len(pairs))), np.zeros((frames, len(pairs)), bool)
    normal = np.abs(np.sum(table.force * table.normal, axis=1))
    for k, bodies in enumerate(pairs):
        mine = table.involving(bodies)
        load = np.bincount(table.frame[mine], normal[mine], frames)
        drift = np.bincount(table.frame[mine], normal[mine] * table.slip[mine], frames)
        standing[:, k] = load > LOADED * who.weight
        speeds[:, k] = drift / np.where(load > 0, load, 1.0)
    mean = float(speeds[standing].mean()) if standing.any() else None
    return Slide(speed=mean, standing=standing, speeds=speeds, lowest=np.zeros(frames))


def kinematic_slide(
    clip: Clip, who: Performer, model: mujoco.MjModel, *, ground: Ground | None = None
) -> Slide:
    """Slide of a clip's feet, standing where the lowest sole point is near the ground and slow.

    Args:
        clip: A motion on the character's skeleton.
        who: The character, for its feet.
        model: The model that holds the character's contact shapes.
        ground: The ground; None is the plane z = 0.
    """
    uneven = ground if isinstance(ground, Ground) and not ground.level else None
    pose = clip.forward_kinematics()
    numbers = {int(body): k for k, body in enumerate(who.bodies)}
    pairs = list(feet(who).values())
    speeds = np.zeros((clip.frames, len(pairs)))
    heights = np.full((clip.frames, len(pairs)), np.inf)
    for k, bodies in enumerate(pairs):
        points, radii = [], []
        for body in bodies:
            local, radius = sole_points(model, int(body))
            link = numbers[int(body)]
            turned = rot.rotate(pose.rotations[:, link][:, None], local[None])
            points.append(pose.positions[:, link][:, None] + turned)
            radii.append(radius)
        placed, radius = np.concatenate(points, axis=1), np.concatenate(radii)
        if placed.shape[1] == 0:
            continue
        height = placed[..., 2] - radius
        if uneven is not None:
            height = height - uneven.height(placed)
        drift = np.gradient(placed, 1.0 / clip.rate, axis=0) if clip.frames > 1 else 0.0 * placed
        low = np.argmin(height, axis=1)
        rows = np.arange(clip.frames)
        speeds[:, k] = np.linalg.norm(drift[rows, low, :2], axis=-1)
        heights[:, k] = height[rows, low]
    standing = (heights < NEAR_GROUND) & (speeds < SLOW)
    mean = float(speeds[standing].mean()) if standing.any() else None
    lowest = heights.min(axis=1) if pairs else np.full(clip.frames, np.inf)
    return Slide(speed=mean, standing=standing, speeds=speeds, lowest=lowest)


def sole_points(model: mujoco.MjModel, body: int) -> tuple[Array, Array]:
    """Points of a link that can touch, in its frame [m], and the ball radius around each [m].

    A box gives its corners, a capsule its two centers, a sphere its center, any other shape the
    corners of its bounding box.
    """
    points, radii = [np.zeros((0, 3))], [np.zeros(0)]
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    first = int(model.body_geomadr[body])
    for geom in range(first, first + int(model.body_geomnum[body])):
        # Bit 0 is the ground's; links may touch each other on other bits.
        if not (model.geom_contype[geom] | model.geom_conaffinity[geom]) & 1:
            continue
        size, kind = model.geom_size[geom], mujoco.mjtGeom(model.geom_type[geom])
        radius = 0.0
        if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            local, radius = np.zeros((1, 3)), float(size[0])
        elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
            local, radius = np.array([[0, 0, -size[1]], [0, 0, size[1]]], float), float(size[0])
        elif kind == mujoco.mjtGeom.mjGEOM_BOX:
            local = corners * size
        else:
            center, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
            local = center + corners * half
        points.append(model.geom_pos[geom] + rot.rotate(model.geom_quat[geom], local))
        radii.append(np.full(len(local), radius))
    return np.concatenate(points), np.concatenate(radii)
