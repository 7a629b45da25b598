"""Keeping the balance over two standing feet (Zordan & Hodgins 1999, section 4.2, the bow).

Legs that were never captured hold the center of mass over the feet while the upper body follows the
clip. First the clip is given legs (`character.footing`): feet flat and fixed, the pelvis where the
center of mass is over their middle. Then, in every step, feedback chooses what the floor should do:

    F = m (k (c_r - c) + d (v_r - v) + a_r + g)             force on the center of mass
    M = k' e + d' (w_r - w) + dL_r/dt                       moment about it, by the pelvis' turn e

Both together say where the floor must push, the center of pressure p: M = (p - c) x F. It is kept
inside the feet; of what cannot be had then M gives a part, so that the trunk swings to where the
body falls as people's do, and F the rest. The feet share the load as p lies between them, and each
leg's joint at p_j gives -(p_i - p_j) x f_i and holds its own leg's weight: the transposed Jacobian
of a foot that stands. Part of the legs' servos stays on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any

import mujoco
import numpy as np

from understudy.character import Character
from understudy.character.footing import SIDES, balanced, footing, sole_of
from understudy.control import balance_law, gains
from understudy.control.reference import sampled
from understudy.control.task import Task, joint_rows
from understudy.errors import InvalidValue, shown
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import angular_velocities, derivative
from understudy.motion.rotations import Array
from understudy.scene import Scene

LEG = ("hip", "knee", "ankle")
# The clip's accelerations are taken over this long [s].
_SMOOTHING = 0.1
# Stiffness of the pelvis' height [1/s^2 of g / h], critically damped; with the legs' servos beside
# it the body stands on its legs, not on this.
_LIFT = 10.0
# Part of the sole that may bear. At its edge a foot would tip.
_MARGIN = 0.95
# Moments [m g h]: the most that is given to save the body from falling, and the most that is asked
# to turn the pelvis back; and how much of what is lacking the moment takes over.
_GIVE, _MOST, _SPLIT = 0.3, 0.1, 0.4


@dataclass(frozen=True, kw_only=True)
class Balance(Task):
    """Holds the center of mass over the feet with hips, knees and ankles; nothing holds the pelvis.

    The feet stay where the clip stands, flat; where its feet do not rest or were not captured, in a
    natural stance below it. It balances from beginning to end. With a shorter `span` the pelvis is
    "assisted" unless `tracked` is told otherwise: before and after, the legs follow the clip, and a
    free pelvis would have only their servos to stand on.

    Attributes:
        stiffness: How the center of mass is pulled to the middle of the feet, in g / h, h its
            height: at 1 as fast as gravity would make it fall.
        damping_ratio: Of that pull; 1 comes back without swaying over.
        upright: How the pelvis is turned to the clip's orientation, in g / h, critically damped.
        servos: Part of the legs' servos that stays on, 0 to 1.
        reference: The clip with balanced legs; `tracked` sets it.
    """

    stiffness: float = 1.5
    damping_ratio: float = 1.0
    upright: float = 10.0
    servos: float = 0.75
    reference: Clip | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, least, most in (
            ("stiffness", 0.1, 20.0),
            ("damping_ratio", 0.0, 5.0),
            ("upright", 0.0, 100.0),
            ("servos", 0.0, 1.0),
        ):
            value = getattr(self, name)
            if not isinstance(value, Real) or not least <= float(value) <= most:
                raise InvalidValue(
                    f"Balance: {name} is {shown(value)}; it must lie in {least:g} to {most:g}."
                )

    @property
    def joints(self) -> tuple[str, ...]:
        """Hips, knees and ankles."""
        return tuple(f"{side}_{joint}" for side in SIDES for joint in LEG)

    @property
    def pelvis(self) -> str | None:
        """Free, where it balances from beginning to end."""
        return "free" if self.span == (0.0, math.inf) else None

    def fitted(self, reference: Clip, body: Character) -> tuple[Task, Clip]:
        """The task, and the reference with legs that stand and balance during its span.

        Raises:
            UnknownName: The body has no legs.
            InvalidValue: The span begins after the clip, or the clip cannot be done standing.
        """
        self.check_joints(body)
        start, end = self.span
        during = (reference.times >= start) & (reference.times <= end)
        if not during.any():
            raise InvalidValue(
                f"Balance: span begins at {start:g} s; the clip lasts {reference.duration:g} s."
            )
        made = balanced(reference, body, footing(reference, body, during=during), during=during)
        if start > 0.0 or end < reference.duration:
            made = self._eased(reference, made)
        return replace(self, reference=made), made

    def _eased(self, clip: Clip, made: Clip) -> Clip:
        """From the clip to the balanced one where the span begins, and back where it ends."""
        edge = np.minimum(clip.times - self.span[0], self.span[1] - clip.times)
        ease = max(self.ease, 1.0 / clip.rate)
        weight = 0.5 - 0.5 * np.cos(np.pi * np.clip(edge / ease, 0.0, 1.0))
        turned = rot.slerp(clip.rotations, made.rotations, weight[:, None])
        path = clip.root_positions + weight[:, None] * (made.root_positions - clip.root_positions)
        return replace(made, rotations=turned, root_positions=path)

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Check that there is level ground to stand on.

        Raises:
            UnknownName: The body has no legs.
            InvalidValue: No ground, or a sloping one, or no reference.
        """
        super().configure(scene, model)
        if scene.ground is None or not scene.ground.level:
            what = "no ground" if scene.ground is None else "ground that is not level"
            raise InvalidValue(f"Balance: the scene has {what}; it stands on level ground only.")
        if self.reference is None:
            raise InvalidValue("Balance: no reference; give the task to `tracked`, which sets it.")

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, its numbers, and whether the body has fallen."""
        part, body = scene.parts[self.character], scene.characters[self.character]
        root = part.bodies[0]
        tree = int(model.body_rootid[root])
        moving = np.flatnonzero(model.body_rootid == tree)
        mass, gravity = float(model.body_mass[moving].sum()), abs(float(model.opt.gravity[2]))
        samples, height = self._samples(scene, body)
        # All gains in the time in which a body of this height falls over.
        pace = math.sqrt(gravity / height)
        inertia = float(gains.outboard_inertia(model, part)[0])
        most = mass * gravity * height
        numbers = (
            *(scene.timestep, len(samples), mass, gravity, tree, root, len(moving)),
            self.stiffness * pace**2,
            2.0 * self.damping_ratio * math.sqrt(self.stiffness) * pace,
            *(_LIFT * pace**2, 2.0 * math.sqrt(_LIFT) * pace),
            inertia * self.upright * pace**2,
            2.0 * inertia * math.sqrt(self.upright) * pace,
            *(self.servos, _MARGIN),
            *(_GIVE * most, _MOST * most, _SPLIT),
        )
        feet = []
        for side in SIDES:
            sole = sole_of(body, side)
            foot = part.bodies[body.index(f"{side}_ankle")]
            feet.append((foot, *sole.middle, *sole.tilt, *sole.half))
        rows = joint_rows(scene, model, self.character, self.joints)
        bodies = np.stack((moving, model.body_mass[moving]), axis=-1)
        parts = (self.times, numbers, feet, rows, bodies, samples)
        flat = [np.asarray(values, float).ravel() for values in parts]
        return balance_law.law, np.concatenate(flat), np.zeros(1)

    def _samples(self, scene: Scene, body: Character) -> tuple[Array, float]:
        """The law's reference, a row for every step, and the mean height of the center [m]."""
        clip = self.reference
        assert clip is not None
        steps = math.floor(clip.duration / scene.timestep + 1e-9) + 1
        times = np.arange(steps, dtype=np.float64) * scene.timestep
        at = sampled(clip, times)
        legs = [body.index(joint) for joint in self.joints]
        momentum = _momentum(clip, body)
        rows = [np.interp(times, clip.times, column) for column in momentum.T]
        spin = rot.rotate(at.rotations[:, 0], at.rates[:, 0])
        joints = np.concatenate((at.rotations[:, legs], at.rates[:, legs]), axis=-1)
        out = np.column_stack((*rows, at.rotations[:, 0], spin, joints.reshape(steps, -1)))
        return out, float(momentum[:, 2].mean())


def _momentum(clip: Clip, body: Character) -> Array:
    """What a clip's center of mass does, shape (frames, 12).

    Its position from the middle of the feet [m], velocity [m/s], acceleration [m/s^2], and the
    change of the angular momentum about it [N m].
    """
    pose = clip.forward_kinematics()
    masses = np.array([link.mass for link in body.links])
    shares = masses / masses.sum()
    at = pose.positions + rot.rotate(pose.rotations, np.array([link.com for link in body.links]))
    center = np.einsum("j,fja->fa", shares, at)
    soles = []
    for side in SIDES:
        i = body.index(f"{side}_ankle")
        middle = rot.rotate(pose.rotations[:, i], sole_of(body, side).middle)
        soles.append(pose.positions[:, i] + middle)
    moving = derivative(at, clip.rate, smoothing=_SMOOTHING)
    velocity = np.einsum("j,fja->fa", shares, moving)
    frames = rot.to_matrix(pose.rotations)
    inertias = np.array([link.inertia for link in body.links])
    spin = angular_velocities(clip, smoothing=_SMOOTHING)
    own = np.einsum("fjab,jbc,fjdc,fjd->fa", frames, inertias, frames, spin, optimize=True)
    arms, beside = at - center[:, None], moving - velocity[:, None]
    turning = own + np.einsum("j,fja->fa", masses, np.cross(arms, beside))
    faster = derivative(velocity, clip.rate, smoothing=_SMOOTHING)
    change = derivative(turning, clip.rate, smoothing=_SMOOTHING)
    return np.concatenate((center - 0.5 * (soles[0] + soles[1]), velocity, faster, change), axis=1)
