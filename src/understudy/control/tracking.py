"""Tracking: servos make the simulated joints follow a clip (Zordan & Hodgins 1999, section 3).

Two laws, both run by the engine's orientation servos:

- `paper`: torque = k (desired - actual) - kd (joint velocity), equation 2, with kd = k / 10. The
  damping works against the motion itself, so the motion lags by kd / k.
- `modern`: the damping acts on the difference to the reference velocity, and inverse dynamics of
  the reference supplies what the motion needs in any case. Both enter through the commanded
  orientation: a servo of stiffness k and damping kd = T k whose target is turned ahead by
  T omega + feedforward / k gives torque k (error) + kd (omega - actual) + feedforward. One servo
  gives the whole torque, so a limit on it limits all of it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from understudy.character.athlete import IN_MOTION
from understudy.control import gains
from understudy.control.controller import Controls
from understudy.control.feedforward import Rehearsal, Required, required
from understudy.control.reference import Sampled, sampled
from understudy.errors import InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import Method
from understudy.motion.rotations import Array
from understudy.scene import Scene

LAWS = ("modern", "paper")
PELVIS = ("led", "assisted", "free")
FEEDFORWARDS = ("inverse_dynamics", "none")
TORQUE_LIMITS = ("off", "human")
SERVOS = ("stiff", "soft")

# Zordan & Hodgins 1999, section 3: "Damping gains are one-tenth of the corresponding stiffness".
PAPER_DAMPING_TIME = 0.1
_EARLY = 0.1  # What tells the velocity at the start [s].
# Natural frequencies of the root servo [rad/s], along the ground, upward, and in rotation: a led
# pelvis follows its path closely; an assisted one gives way, so that the feet carry the body.
ROOT_FREQUENCY = {
    "led": (50.0, 50.0, 50.0),
    "assisted": (15.0, 8.0, 50.0),
    "free": (0.0, 0.0, 0.0),
}


@dataclass(frozen=True, kw_only=True)
class Tracking:
    """Makes one character follow a clip; open loop, so it runs in the fastest gear.

    Attributes:
        reference: The clip, on the character's own skeleton (see `retargeted`).
        character: Which of the scene's characters.
        law: "modern" or "paper".
        stiffness: Overall stiffness [1/s^2]; a joint's gain is this times its outboard inertia.
        damping_time: kd / k [s]; by default 0.1 for the paper's law, and critical damping
            2 / sqrt(stiffness) for the modern one (stance legs: at most 0.01).
        servos: "stiff", with gains as above, or "soft" (`gains.SOFT_STIFFNESS`), for a free body.
        feedforward: "inverse_dynamics" or "none"; the paper's law uses none.
        pelvis: "led" along its path by a stiff servo, "assisted" by a soft one that leaves to the
            feet what they can carry, or "free": nothing holds it.
        root_frequency: Natural frequencies of the root servo [rad/s], along the ground, upward and
            in rotation; by default by `pelvis`.
        torque_limits: "off", or "human": no joint's servo exceeds the published strength of a
            person of this sex, mass and height; with soft servos that of one in motion, whose legs
            are stronger than on a dynamometer (`character.athlete.IN_MOTION`).
        interpolation: "spline" or "slerp" between frames.
        strengths: Joint names and factors: such a joint gives this many times the torque its servo
            would (gains, feedforward and torque limit alike). 0 is limp: no servo, a little passive
            damping. Joints not named have 1.
        locked: Joints held by a lock far stiffer than a servo, without feedforward, at the angle
            the reference has.
        rehearsal: The body and clip whose gains and feedforward these are; None for the scene's
            own body and the reference.
        captured: The clip as it was read, kept for reports.
    """

    reference: Clip
    character: int = 0
    law: str = "modern"
    stiffness: float = 3000.0
    damping_time: float | None = None
    servos: str = "stiff"
    feedforward: str | None = None
    pelvis: str = "assisted"
    root_frequency: tuple[float, float, float] | None = None
    torque_limits: str = "off"
    interpolation: Method = "spline"
    strengths: tuple[tuple[str, float], ...] = ()
    locked: tuple[str, ...] = ()
    rehearsal: Rehearsal | None = field(default=None, repr=False)
    captured: Clip | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        for name, valid in (
            ("law", LAWS),
            ("pelvis", PELVIS),
            ("torque_limits", TORQUE_LIMITS),
            ("servos", SERVOS),
            ("feedforward", (None, *FEEDFORWARDS)),
        ):
            value = getattr(self, name)
            if value not in valid:
                raise InvalidValue(f"{name} is {value!r}; it must be one of {valid}.")
        if not (np.isfinite(self.stiffness) and 0 < self.stiffness <= 1e7):
            raise InvalidValue(f"stiffness is {self.stiffness} /s^2; it must lie in 0 to 1e7.")
        if self.law == "paper" and self.feedforward == "inverse_dynamics":
            raise InvalidValue("The paper's law has no feedforward; use law='modern'.")
        if self.damping_time is not None and not 0 <= self.damping_time <= 10:
            raise InvalidValue(f"damping_time is {self.damping_time} s; it must lie in 0 to 10.")
        if self.root_frequency is not None and not (
            len(self.root_frequency) == 3 and all(0 <= w <= 1e3 for w in self.root_frequency)
        ):
            raise InvalidValue(
                f"root_frequency is {self.root_frequency}; it must be three numbers in 0 to 1000."
            )
        joints = self.reference.skeleton.names[1:]
        for joint in (*self.locked, *(joint for joint, _ in self.strengths)):
            if joint not in joints:
                raise UnknownName("joint", joint, joints)
        for joint, factor in self.strengths:
            if not 0 <= factor <= 100:
                raise InvalidValue(
                    f"The strength of {joint!r} is {factor}; it must lie in 0 to 100."
                )

    @property
    def kd_over_k(self) -> float:
        """Damping over stiffness [s]."""
        if self.damping_time is not None:
            return self.damping_time
        if self.servos == "soft":
            return gains.SOFT_DAMPING_TIME
        return PAPER_DAMPING_TIME if self.law == "paper" else 2.0 / np.sqrt(self.stiffness)

    @property
    def facts(self) -> dict[str, Any]:
        """What a certificate says about this controller."""
        return {
            "law": self.law,
            "pelvis": self.pelvis,
            "stiffness": self.stiffness,
            "damping_time": self.kd_over_k,
            **({"servos": self.servos} if self.servos != "stiff" else {}),
            "feedforward": self._feedforward,
            "torque_limits": self.torque_limits,
            "interpolation": self.interpolation,
            **({"strengths": dict(self.strengths)} if self.strengths else {}),
            **({"locked": list(self.locked)} if self.locked else {}),
            **({"feedforward_of": "the rehearsed body and clip"} if self.rehearsal else {}),
        }

    @property
    def _feedforward(self) -> str:
        return self.feedforward or ("none" if self.law == "paper" else "inverse_dynamics")

    # -- Controller --------------------------------------------------------------------------

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Write joint and root gains, and torque limits, into the model.

        Raises:
            InvalidValue: The reference is not on this character's skeleton.
        """
        part, body = scene.parts[self.character], scene.characters[self.character]
        if self.reference.skeleton.names != body.skeleton.names:
            raise InvalidValue(
                f"The reference {self.reference.name!r} is not on the skeleton of "
                f"{body.name!r}; retarget it first."
            )
        k, kd = self._gains(scene, model)
        own = gains.outboard_inertia(model, part)[1:]
        strengths = self._strengths
        for j, (actuator, link) in enumerate(
            zip(part.joint_actuators, body.links[1:], strict=True)
        ):
            strength = strengths[j]
            if link.joint in self.locked:
                lock = max(gains.LOCKED_STIFFNESS * own[j], gains.LOCKED_OVER_SERVO * k[j])
                gains.set_orientation_gain(model, actuator, lock, 2.0 * np.sqrt(lock * own[j]))
                continue
            gains.set_orientation_gain(model, actuator, strength * k[j], strength * kd[j])
            self._stop(model, part.bodies[j + 1], link.role, link.motion_limit, j + 1)
            if strength == 0.0:
                first = part.dofs.start + 6 + 3 * j
                model.dof_damping[first : first + 3] = gains.LIMP_DAMPING * own[j]
            if self.torque_limits == "human" and link.torque_limit is not None:
                # The engine bounds the length of the torque vector: the strongest axis' limit.
                model.actuator_forcelimited[actuator] = True
                limit = strength * float(np.max(link.torque_limit))
                if self.servos == "soft":
                    limit *= IN_MOTION.get((link.role or "").partition("_")[2], 1.0)
                model.actuator_forcerange[actuator] = 0.0, limit
        if self.servos == "soft":
            first, last = part.dofs.start + 6, part.dofs.stop
            model.dof_armature[first:last] = gains.SOFT_ARMATURE
        mass, inertia = self._root_inertia(scene, model)
        along, up, turn = self._root_frequency
        for actuator, w in zip(part.root_actuators[:3], (along, along, up), strict=True):
            gains.set_position_gain(model, actuator, mass * w * w, 2.0 * mass * w)
        gains.set_orientation_gain(
            model, part.root_actuators[3], inertia * turn * turn, 2.0 * inertia * turn
        )

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Begin in the reference's first pose, at its velocity.

        At its very start a spline through a captured clip says more of noise than of the velocity,
        so that is the line through the first tenth of a second.
        """
        part = scene.parts[self.character]
        early = np.arange(min(self.reference.frames, 1 + round(_EARLY * self.reference.rate)))
        times = early / self.reference.rate
        first = sampled(self.reference, times, interpolation=self.interpolation)
        data.qpos[part.qpos] = first.qpos()[0]
        line = np.polyfit(times, first.qvel(), min(1, len(times) - 1))
        data.qvel[part.dofs] = line[-1]

    def controls(self, scene: Scene, model: mujoco.MjModel, times: Array) -> Controls:
        """Commanded orientations and root path for every step."""
        part = scene.parts[self.character]
        if model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE:
            # Its servos act with the angle at the end of the step.
            times = times + scene.timestep
        reference = sampled(self.reference, times, interpolation=self.interpolation)
        ctrl = np.zeros((len(times), model.nu))
        k, kd = self._gains(scene, model)
        ahead = np.zeros((len(times), len(k), 3))
        if self.law == "modern":
            ahead += (kd / k)[:, None] * reference.rates[:, 1:]
        if self._feedforward == "inverse_dynamics":
            need = self.need(scene, model)
            ahead += _at(times, self.reference, need.joints) / k[None, :, None]
        ahead[:, [name in self.locked for name in self.reference.skeleton.names[1:]]] = 0.0
        turned = rot.multiply(reference.rotations[:, 1:], rot.from_rotvec(_bounded(ahead)))
        columns = np.asarray(part.joint_controls, int)[:, None] + np.arange(4)
        ctrl[:, columns] = turned
        self._root_controls(scene, model, reference, times, ctrl)
        return Controls(ctrl)

    def need(self, scene: Scene, model: mujoco.MjModel) -> Required:
        """Inverse dynamics of the reference; a led pelvis bears whatever the ground would.

        Of the rehearsed clip and body where there is a rehearsal.
        """
        contact = self.pelvis != "led"
        if self.rehearsal is not None:
            return self.rehearsal.need(self.character, contact=contact)
        key = (id(scene), model.opt.timestep)
        if key not in self._needs:
            self._needs[key] = required(
                scene, model, self.character, self.reference, contact=contact
            )
        return self._needs[key]

    # -- details -----------------------------------------------------------------------------

    @cached_property
    def _needs(self) -> dict[Any, Required]:
        return {}

    @property
    def _root_frequency(self) -> tuple[float, float, float]:
        given = self.root_frequency
        return ROOT_FREQUENCY[self.pelvis] if given is None else given

    def _stop(
        self, model: mujoco.MjModel, body: int, role: str | None, limit: float | None, j: int
    ) -> None:
        """Stop a joint where people's joints end, or 10 degrees past where the clip goes."""
        kind = (role or "").partition("_")[2]
        limit = np.radians(gains.WEAK_STOPS[kind]) if kind in gains.WEAK_STOPS else limit
        if limit is None:
            return
        widest = float(rot.angle(self.reference.rotations[:, j]).max()) + np.radians(10.0)
        joint = model.body_jntadr[body]
        model.jnt_limited[joint] = True
        model.jnt_range[joint] = 0.0, min(max(limit, widest), np.pi)

    @property
    def _strengths(self) -> Array:
        """Strength of every joint but the root, shape (links - 1,)."""
        given = dict(self.strengths)
        return np.array([given.get(name, 1.0) for name in self.reference.skeleton.names[1:]])

    def _learned(self, scene: Scene, model: mujoco.MjModel) -> tuple[Scene, mujoco.MjModel]:
        """The scene and model that gains are made for."""
        if self.rehearsal is None:
            return scene, model
        return self.rehearsal.scene, self.rehearsal.scene.model

    def _gains(self, scene: Scene, model: mujoco.MjModel) -> tuple[Array, Array]:
        """Stiffness [N m/rad] and damping [N m s/rad] at strength 1, each shape (links - 1,)."""
        scene, model = self._learned(scene, model)
        if self.servos == "soft":
            k = gains.soft_stiffness(scene, model, self.character, self.stiffness)
            return k, k * self.kd_over_k
        k = gains.joint_stiffness(scene, model, self.character, self.stiffness)
        kd = k * self.kd_over_k
        if self.law == "modern" and self.damping_time is None:
            stands = [bool(kind) for kind in gains.stance_joints(scene, self.character)]
            least = min(self.kd_over_k, gains.STANCE_DAMPING_TIME)
            kd = np.where(stands, k * least, kd)
        return k, kd

    def _root_inertia(self, scene: Scene, model: mujoco.MjModel) -> tuple[float, float]:
        scene, model = self._learned(scene, model)
        part = scene.parts[self.character]
        mass = float(sum(model.body_mass[b] for b in part.bodies))
        return mass, float(gains.outboard_inertia(model, part)[0])

    def _root_controls(
        self, scene: Scene, model: mujoco.MjModel, reference: Sampled, times: Array, ctrl: Array
    ) -> None:
        part = scene.parts[self.character]
        address = list(part.root_controls)
        positions, ahead = reference.positions.copy(), np.zeros((len(times), 3))
        along, up, turn = self._root_frequency
        if turn > 0:
            ahead += reference.rates[:, 0] * (2.0 / turn)
        if self._feedforward == "inverse_dynamics":
            # For a led pelvis all that its motion needs, else what no ground can give it.
            force = _at(times, self.reference, self.need(scene, model).root)
            mass, inertia = self._root_inertia(scene, model)
            stiffness = mass * np.array([along, along, up]) ** 2
            if turn > 0 and (stiffness > 0).all():
                positions += force[:, :3] / stiffness
                ahead += force[:, 3:] / (inertia * turn**2)
        ctrl[:, address[0:6:2]] = positions
        ctrl[:, address[1:6:2]] = reference.velocities
        ctrl[:, address[6:]] = rot.multiply(
            reference.rotations[:, 0], rot.from_rotvec(_bounded(ahead))
        )


def _at(times: Array, clip: Clip, values: Array) -> Array:
    """Frame values interpolated linearly to `times`."""
    frame = np.clip(times * clip.rate, 0.0, clip.frames - 1)
    k = np.minimum(frame.astype(int), max(clip.frames - 2, 0))
    w = (frame - k).reshape(-1, *[1] * (values.ndim - 1))
    return values[k] * (1.0 - w) + values[np.minimum(k + 1, clip.frames - 1)] * w


def _bounded(ahead: Array) -> Array:
    """Rotation vectors shortened to just under half a turn, where the servo's error ends."""
    length = np.linalg.norm(ahead, axis=-1, keepdims=True)
    return ahead * np.minimum(1.0, 0.95 * np.pi / np.maximum(length, 1e-12))
