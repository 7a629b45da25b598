"""How a whole body follows its clip when nothing, or little, holds it.

A body that is free can be lost: it falls, or goes on somewhere else. The figures are those that
full-body trackers are compared by: joint positions in the world and seen from the root, the center
of mass, the time until it is lost, and the help it had.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.errors import InvalidValue
from understudy.evaluate import compare
from understudy.evaluate.measure import Measured, measured
from understudy.evaluate.score import HELD, motion
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.character import Character
    from understudy.take import Take

LOST_HEIGHT, LOST_ANGLE, LOST_DISTANCE = 0.2, np.radians(45.0), 0.6
"""A body is lost when its center of mass is this much higher or lower than the clip's [m], its root
turned by this much from the clip's, or its center of mass this far from the clip's [m]."""
FALLING = (5.0, 15.0)
"""A center of mass that accelerates downward by so much is in flight [m/s^2]."""
SHORTEST_FLIGHT = 0.07
"""Shorter stretches of such acceleration are no flights [s]."""
_SHORT = 0.05
"""A take that ends so much before its clip still is whole [s]."""
_SMOOTHING = 0.1
"""Window in which the clip's acceleration is fitted [s]."""


@dataclass(frozen=True, kw_only=True)
class Following:
    """How one character followed its clip.

    Attributes:
        duration_s: Time compared [s].
        clip_s: How long the clip is [s].
        lost_s: When the body was lost: its center of mass 0.2 m too high or low or 0.6 m away, or
            its root 45 degrees off [s]; None when it never was.
        free_s: Time before that with no outside force on the root [s].
        help_percent: Root mean square outside force on the root [% of body weight].
        help_peak_percent: Its peak [% of body weight].
        joint_position_mm: Mean distance of joints from the clip's, in the world [mm].
        joint_position_peak_mm: Largest mean over the joints at one time [mm].
        joint_relative_mm: As joint_position_mm, with both roots at one place, not turned [mm].
        com_mm: Root mean square distance of the centers of mass [mm].
        com_peak_mm: Its peak [mm].
        shake: Root mean square angular acceleration of the joints over that of the clip; above 1
            the body is less smooth than its clip. None for a clip that does not move.
        clip_flight_s: Time the clip's center of mass falls freely [s].
    """

    duration_s: float
    clip_s: float
    lost_s: float | None
    free_s: float
    help_percent: float
    help_peak_percent: float
    joint_position_mm: float
    joint_position_peak_mm: float
    joint_relative_mm: float
    com_mm: float
    com_peak_mm: float
    shake: float | None
    clip_flight_s: float

    @property
    def free(self) -> bool:
        """True when nothing but contact held the body and it was never lost."""
        return self.lost_s is None and self.free_s >= self.duration_s - 1e-9

    @property
    def whole(self) -> bool:
        """True when the take goes on to the end of the clip."""
        return self.duration_s >= self.clip_s - _SHORT

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes."""
        return asdict(self) | {"free": self.free, "whole": self.whole}


def following(take: Take, *, character: int = 0, measures: Measured | None = None) -> Following:
    """Measure how a character followed its clip.

    Args:
        take: The take.
        character: Which of the scene's characters.
        measures: What `measured(take)` gave, to save doing it again.

    Raises:
        InvalidValue: The character tracked no clip.
    """
    m = measured(take) if measures is None else measures
    who, reference = m.performer(character), take.references[character]
    if reference is None:
        raise InvalidValue("This take has no reference clip to compare with.")
    simulated = motion(take, m, character)
    found = compare.compared(simulated, reference)
    apart = _apart(who.character, simulated, reference, found.times)
    away = np.linalg.norm(apart, axis=1)
    lost = (np.abs(apart[:, 2]) > LOST_HEIGHT) | (away > LOST_DISTANCE)
    lost |= found.root_angles > LOST_ANGLE
    force = np.linalg.norm(m.root_force(character), axis=1) / who.weight * 100.0
    turn = np.linalg.norm(m.root_torque(character), axis=1) / (who.weight * who.height) * 100.0
    alone = ((force < HELD) & (turn < HELD))[: len(found.times)]
    last = int(np.argmax(lost)) if lost.any() else len(lost)
    lasted = float(found.times[-1] - found.times[0])
    return Following(
        duration_s=lasted,
        clip_s=reference.duration,
        lost_s=float(found.times[last]) if lost.any() else None,
        free_s=lasted * float(alone[:last].sum()) / len(lost),
        help_percent=float(np.sqrt(np.mean(np.square(force)))),
        help_peak_percent=float(force.max()),
        joint_position_mm=1e3 * float(found.distances.mean()),
        joint_position_peak_mm=1e3 * float(found.distances.mean(axis=1).max()),
        joint_relative_mm=1e3 * float(found.relative_distances.mean()),
        com_mm=1e3 * float(np.sqrt(np.mean(np.square(away)))),
        com_peak_mm=1e3 * float(away.max()),
        shake=_shake(take.clip(character), reference),
        clip_flight_s=flight_time(mass_center(reference, who.character), reference.rate),
    )


def mass_center(clip: Clip, character: Character) -> Array:
    """Center of mass of a character in the poses of a clip [m], world, shape (frames, 3).

    Args:
        clip: A motion on its skeleton.
        character: Whose masses.
    """
    pose = clip.forward_kinematics()
    masses = np.array([link.mass for link in character.links])
    centers = np.array([link.com for link in character.links])
    placed = pose.positions + rot.rotate(pose.rotations, centers[None])
    return np.einsum("j,fjk->fk", masses / masses.sum(), placed)


def flight_time(center: Array, rate: float) -> float:
    """Time in which a center of mass falls freely [s], stretches of 0.07 s and more counted.

    Args:
        center: Its path [m], shape (frames, 3).
        rate: Frames per second [Hz].
    """
    down = -derivative(center[:, 2], rate, smoothing=_SMOOTHING, order=2)
    falling = (down > FALLING[0]) & (down < FALLING[1])
    edges = np.flatnonzero(np.diff(np.concatenate(([0], falling.astype(int), [0]))))
    lengths = (edges[1::2] - edges[::2]) / rate
    return float(lengths[lengths >= SHORTEST_FLIGHT - 1e-9].sum())


def _apart(body: Character, simulated: Clip, reference: Clip, times: Array) -> Array:
    """From the clip's center of mass to the simulated one [m], world, shape (frames, 3)."""
    turned, path = compare.sampled(reference, times)
    there = Clip(
        skeleton=simulated.skeleton, rotations=turned, root_positions=path, rate=simulated.rate
    )
    return mass_center(simulated, body)[: len(times)] - mass_center(there, body)


def _shake(simulated: Clip, reference: Clip) -> float | None:
    """Angular acceleration of joints, root mean square, over the reference's."""
    own, given = (_roughness(clip) for clip in (simulated, reference))
    return own / given if given > 1e-6 else None


def _roughness(clip: Clip) -> float:
    """Root mean square angular acceleration of the joints in their parents' frames [rad/s^2]."""
    speed = rot.angular_velocity(clip.rotations[:, 1:], clip.rate)
    if not speed.size:
        return 0.0
    return float(np.sqrt(np.mean(np.square(derivative(speed, clip.rate)))))
