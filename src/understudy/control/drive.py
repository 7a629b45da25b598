"""The drive: makes rigid bodies follow a clip by velocity (Wilke & Semwal 2017).

The clip's velocities are central differences of an odd order n, scaled for all bodies by K_vc and
for single ones, at single frames, by K_v(j, f). Every body is pushed toward the velocity of the
next frame by a force K_f m (v* - v) and the analogous torque with the whole inertia tensor.

- `paper`: exactly that. Nothing holds a position and nothing holds gravity up, so that errors grow
  with time: under gravity g bodies sink with speed g / K_f.
- `modern`: gravity is fed forward and position and orientation are held by critically damped terms.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from understudy.character import Linkage
from understudy.character.linkage_model import equality_names
from understudy.control import drive_laws as laws
from understudy.control.differences import angular_velocities, checked_order, velocities
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.motion.skeleton import frozen_array
from understudy.scene import Scene

LAWS = ("modern", "paper")
FEEDFORWARDS = ("gravity", "none")
# Wilke & Semwal 2017, table 1: K_f and order n of the three linkages; the tree takes the third's.
PUBLISHED = {
    "independent": (98.5331, 5),
    "skeleton": (32.5875, 5),
    "constrained": (24.1933, 3),
    "tree": (24.1933, 3),
}
# K_f times the time step at which the modern law runs by default, and from which an explicit step
# is unstable: without and with the critically damped position term (2, and 4 sqrt(2) - 4).
MODERN_GAIN_STEPS = 0.8
_LIMIT, _LIMIT_WITH_POSITION = 2.0, 4.0 * np.sqrt(2.0) - 4.0


@dataclass(frozen=True, kw_only=True)
class Drive:
    """Pushes the bodies of one linkage along a clip; compiled, so it runs in the second gear.

    Frames are those of `reference`, bodies are numbered as its joints.

    Attributes:
        reference: The clip, on the linkage's skeleton.
        character: Which of the scene's characters.
        law: "modern" or "paper".
        gain: K_f [1/s]; by default 0.8 / time step (modern) or the paper's for the linkage.
        order: Odd order n of the central differences, 3 to 19; by default 3 (modern) or the
            paper's for the linkage.
        velocity_scale: K_vc over (frame rate x scale): 1 is the clip's own speed.
        scaling: K_v(j, f), shape (joints,) or (frames, joints); None is 1 everywhere.
        strength: Factor of a body's whole force and torque, 0 (uncontrolled) to 1, shape (joints,)
            or (frames, joints); None is 1 everywhere.
        position_gain: K_p [1/s^2]; by default K_f^2 / 4, critical damping (modern), or 0 (paper).
        following: Share of K_p per body, shape (joints,): less leaves scaled velocities more to
            show; None is 1 everywhere.
        feedforward: "gravity" or "none"; by default the first (modern) or the second (paper).
        scale: Size of the simulated model over the clip's in the paper's sense; it enters the
            reported K_vc, and `driven` divides the gravity by it, which is the same as scaling.
        captured: The clip as it was read, kept for reports.
    """

    reference: Clip
    character: int = 0
    law: str = "modern"
    gain: float | None = None
    order: int | None = None
    velocity_scale: float = 1.0
    scaling: Array | None = field(default=None, repr=False)
    strength: Array | None = field(default=None, repr=False)
    position_gain: float | None = None
    following: Array | None = field(default=None, repr=False)
    feedforward: str | None = None
    scale: float = 1.0
    captured: Clip | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise InvalidValue(f"law is {self.law!r}; it must be one of {LAWS}.")
        if self.feedforward not in (None, *FEEDFORWARDS):
            raise InvalidValue(
                f"feedforward is {self.feedforward!r}; it must be one of {FEEDFORWARDS}."
            )
        if self.law == "paper" and (self.position_gain or self.feedforward == "gravity"):
            raise InvalidValue(
                "The paper's law has no position term and no feedforward; use law='modern'."
            )
        if self.gain is not None and not (np.isfinite(self.gain) and 0 <= self.gain <= 1e6):
            raise InvalidValue(f"gain is {self.gain} /s; it must lie in 0 to 1e6.")
        if self.position_gain is not None and not (
            np.isfinite(self.position_gain) and 0 <= self.position_gain <= 1e10
        ):
            raise InvalidValue(
                f"position_gain is {self.position_gain} /s^2; it must lie in 0 to 1e10."
            )
        if not (np.isfinite(self.velocity_scale) and abs(self.velocity_scale) <= 100):
            raise InvalidValue(
                f"velocity_scale is {self.velocity_scale}; it must lie in -100 to 100."
            )
        if not (np.isfinite(self.scale) and self.scale > 0):
            raise InvalidValue(f"scale is {self.scale}; it must be a positive number.")
        if self.order is not None:
            checked_order(self.order, self.reference.frames)
        frames, joints = self.reference.frames, len(self.reference.skeleton)
        for name in ("scaling", "strength", "following"):
            value = getattr(self, name)
            if value is None:
                continue
            timed = name != "following" and np.ndim(value) == 2
            array = frozen_array(value, (frames, joints) if timed else (joints,), name)
            if name != "scaling" and ((array < 0).any() or (array > 1).any()):
                raise InvalidValue(f"{name} must lie in 0 to 1; it reaches {array.max():g}.")
            object.__setattr__(self, name, array)

    @property
    def facts(self) -> dict[str, Any]:
        """What a certificate says about this controller."""
        return {
            "law": self.law,
            "velocity_scale": self.velocity_scale,
            "K_vc": self.velocity_scale * self.reference.rate * self.scale,
            "scale": self.scale,
        }

    def settings(self, scene: Scene) -> dict[str, Any]:
        """Everything that the numbers of an error depend on, with its unit in the name."""
        linkage = self.linkage(scene)
        return {
            "kind": linkage.kind,
            "law": self.law,
            "K_f": self.gain_in(scene),
            "K_p": self.position_gain_in(scene),
            "K_vc": self.velocity_scale * self.reference.rate * self.scale,
            "K_vc_over_rate_and_scale": self.velocity_scale,
            "order": self.order_in(scene),
            "feedforward": self.feedforward_used,
            "gravity_m_per_s2": scene.gravity,
            "gravity_units_per_s2": scene.gravity * self.scale / linkage.unit,
            "scale": self.scale,
            "unit_m": linkage.unit,
            "timestep_s": scene.timestep,
            "clip_rate_hz": self.reference.rate,
        }

    # -- what is used where nothing was given --------------------------------------------------

    def linkage(self, scene: Scene) -> Linkage:
        """The linkage it drives.

        Raises:
            InvalidValue: The performer is no linkage, or of another skeleton than the reference.
        """
        linkage = scene.characters[self.character]
        if not isinstance(linkage, Linkage):
            raise InvalidValue(f"{linkage.name!r} is no linkage; a drive moves linkages only.")
        if linkage.names != self.reference.skeleton.names:
            raise InvalidValue(
                f"The clip {self.reference.name!r} is not on the skeleton of the linkage "
                f"{linkage.name!r}."
            )
        return linkage

    def gain_in(self, scene: Scene) -> float:
        """K_f [1/s]."""
        if self.gain is not None:
            return self.gain
        if self.law == "paper":
            return PUBLISHED[self.linkage(scene).kind][0]
        return MODERN_GAIN_STEPS / scene.timestep

    def position_gain_in(self, scene: Scene) -> float:
        """K_p [1/s^2]."""
        if self.law == "paper":
            return 0.0
        if self.position_gain is None:
            return 0.25 * self.gain_in(scene) ** 2
        return self.position_gain

    def order_in(self, scene: Scene) -> int:
        """Order n of the central differences."""
        if self.order is not None:
            return self.order
        return PUBLISHED[self.linkage(scene).kind][1] if self.law == "paper" else 3

    @property
    def feedforward_used(self) -> str:
        """ "gravity" or "none"."""
        return self.feedforward or ("none" if self.law == "paper" else "gravity")

    def check(self, scene: Scene) -> None:
        """Refuse gains that an explicit step cannot carry.

        Raises:
            InvalidValue: K_f or K_p is too large for the time step; the text says what would do.
                Or the performer is no linkage of the reference's skeleton.
        """
        self.linkage(scene)
        gain, position, dt = self.gain_in(scene), self.position_gain_in(scene), scene.timestep
        if gain * dt >= _LIMIT:
            raise InvalidValue(
                f"K_f = {gain:g} /s with a step of {1e3 * dt:.3g} ms is unstable: K_f dt = "
                f"{gain * dt:.3g}, and it must stay below 2. Use K_f < {_LIMIT / dt:.4g} /s or a "
                "shorter step."
            )
        if position > 0.0 and 2.0 * gain * dt + position * dt * dt >= 4.0:
            raise InvalidValue(
                f"K_f = {gain:g} /s and K_p = {position:g} /s^2 with a step of {1e3 * dt:.3g} ms "
                "are unstable: 2 K_f dt + K_p dt^2 must stay below 4. With critical damping use "
                f"K_f < {_LIMIT_WITH_POSITION / dt:.4g} /s, or a shorter step."
            )

    # -- Controller --------------------------------------------------------------------------

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Check the gains; under the modern law make the joints as stiff as the step allows.

        The paper's law keeps the engine's stiffest own setting, a time constant of two steps. For
        bodies that move freely the constraint solver can take away a gap within one step: with
        stiffness 1 / dt^2 and damping 1 / dt, a = -(x + dt v) / dt^2, which is just stable.

        Raises:
            InvalidValue: See `check` and `linkage`.
        """
        self.check(scene)
        if self.law != "modern":
            return
        prefix, dt = scene.parts[self.character].prefix, scene.timestep
        for name in equality_names(self.linkage(scene)):
            equality = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_EQUALITY, prefix + name)
            # The engine divides by the impedance's upper end, squared for the stiffness.
            most = model.eq_solimp[equality, 1]
            model.eq_solref[equality, :2] = -((most / dt) ** 2), -most / dt

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Begin in the reference's first pose and at its velocity, locked joints as locked."""
        part, linkage = scene.parts[self.character], self.linkage(scene)
        clip = linkage.held(self.reference) if linkage.locks else self.reference
        motion = self._motion(scene, clip)
        order = self.order_in(scene)
        positions, rotations = motion.positions[:1], motion.rotations[:1]
        linear = self.velocity_scale * motion.linear(order)[0]
        spin = self.velocity_scale * motion.angular(order)[0]
        data.qpos[part.qpos] = linkage.coordinates(positions, rotations)[0]
        data.qvel[part.dofs] = _speeds(linkage, rotations[0], linear, spin)

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, its gains, bodies and targets, and its scratch memory."""
        linkage = self.linkage(scene)
        law = laws.tree_law if linkage.kind == "tree" else laws.free_law
        parameters = np.concatenate(
            (
                self._header(scene, model),
                self._bodies(scene, model).ravel(),
                self.targets(scene).ravel(),
            )
        )
        return law, parameters, np.zeros(10 * len(linkage))

    # -- details -----------------------------------------------------------------------------

    def _steps_per_frame(self, scene: Scene) -> int:
        steps = 1.0 / (self.reference.rate * scene.timestep)
        if abs(steps - round(steps)) > 1e-6 * steps or round(steps) < 1:
            raise InvalidValue(
                f"The time step {scene.timestep:g} s does not divide the clip's frame period "
                f"{1 / self.reference.rate:g} s."
            )
        return round(steps)

    def _motion(self, scene: Scene, clip: Clip) -> BodyMotion:
        return _body_motion(_Same(clip), _Same(self.linkage(scene)), self._steps_per_frame(scene))

    def targets(self, scene: Scene) -> Array:
        """One row per step and body, shape (steps + 1, joints, 14), in the order of `drive_laws`.

        The row of a step holds the velocity of the next one, and the pose of its own: a velocity
        that leads by a step goes with a position that does not.
        """
        motion, order = self._motion(scene, self.reference), self.order_in(scene)
        every = self._steps_per_frame(scene)
        steps, joints = motion.positions.shape[:2]
        out = np.zeros((steps, joints, laws.ROW))
        faster = np.full((steps, joints), self.velocity_scale)
        if self.scaling is not None:
            faster *= _by_step(self.scaling, steps, every)
        out[:-1, :, 0:3] = (faster[..., None] * motion.linear(order))[1:]
        out[:-1, :, 3:6] = (faster[..., None] * motion.angular(order))[1:]
        if self.position_gain_in(scene) > 0.0:
            out[..., 6:9], out[..., 9:13] = motion.positions, motion.rotations
        out[..., 13] = 1.0 if self.strength is None else _by_step(self.strength, steps, every)
        return out

    def _header(self, scene: Scene, model: mujoco.MjModel) -> Array:
        lift = -float(model.opt.gravity[2]) if self.feedforward_used == "gravity" else 0.0
        rows = (self.reference.frames - 1) * self._steps_per_frame(scene) + 1
        gains = self.gain_in(scene), self.position_gain_in(scene)
        return np.array([len(self.linkage(scene)), rows, 1.0 / scene.timestep, *gains, lift])

    def _bodies(self, scene: Scene, model: mujoco.MjModel) -> Array:
        linkage, part = self.linkage(scene), scene.parts[self.character]
        ids = np.array(part.bodies)
        joints = model.body_jntadr[ids]
        out = np.zeros((len(ids), laws.BODY))
        out[:, 0], out[:, 1] = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
        out[:, 2], out[:, 3] = linkage.skeleton.parents, ids
        out[:, 4], out[:, 5:8] = model.body_mass[ids], model.body_inertia[ids]
        out[:, 8] = 1.0 if self.following is None else self.following
        out[:, 9:13], out[:, 13:16] = linkage.relative, linkage.anchors
        return out


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """Poses of a linkage's bodies along a clip, and their velocities of any order.

    Attributes:
        positions: Centers of mass [m], shape (steps, joints, 3).
        rotations: Orientations, wxyz, shape (steps, joints, 4).
        rate: Steps per second [Hz].
    """

    positions: Array
    rotations: Array
    rate: float
    _known: dict[Any, Array] = field(default_factory=dict, repr=False)

    def linear(self, order: int) -> Array:
        """Velocities of the centers of mass [m/s], shape (steps, joints, 3)."""
        if ("v", order) not in self._known:
            self._known["v", order] = velocities(self.positions, self.rate, order)
        return self._known["v", order]

    def angular(self, order: int) -> Array:
        """World angular velocities [rad/s], shape (steps, joints, 3)."""
        if ("w", order) not in self._known:
            self._known["w", order] = angular_velocities(self.rotations, self.rate, order)
        return self._known["w", order]


class _Same:
    """A key that is equal to itself only: clips compare by value, which is slow."""

    def __init__(self, value: Any):
        self.value = value

    def __hash__(self) -> int:
        return id(self.value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.value is self.value


@functools.lru_cache(maxsize=8)
def _body_motion(clip: _Same, linkage: _Same, steps_per_frame: int) -> BodyMotion:
    """Body poses at every step; a search over gains asks for the same ones many times."""
    motion: Clip = clip.value
    if steps_per_frame > 1:
        motion = motion.resampled(motion.rate * steps_per_frame, method="spline")
    pose = motion.forward_kinematics()
    positions, rotations = linkage.value.placed(pose.positions, pose.rotations)
    return BodyMotion(positions, rotations, motion.rate)


def _by_step(values: Array, steps: int, every: int) -> Array:
    """Frame values, shape (frames, joints) or (joints,), held over the steps of each frame."""
    if values.ndim == 1:
        return np.broadcast_to(values, (steps, len(values)))
    return values[np.minimum(np.arange(steps) // every, len(values) - 1)]


def _speeds(linkage: Linkage, rotations: Array, linear: Array, spin: Array) -> Array:
    """Engine velocities from world velocities of the bodies, shape (nv,)."""
    if linkage.kind != "tree":
        own = rot.rotate(rot.conjugate(rotations), spin)
        return np.concatenate((linear, own), axis=1).ravel()
    relative = np.array(spin)
    relative[1:] -= spin[list(linkage.skeleton.parents[1:])]
    own = rot.rotate(rot.conjugate(rotations), relative)
    return np.concatenate((linear[0], own[list(linkage.order)].ravel()))


def scaling_for(
    clip: Clip,
    joints: Iterable[str],
    factor: float,
    *,
    start: float = 0.0,
    end: float | None = None,
    base: Array | None = None,
) -> Array:
    """K_v(j, f) of 1 but for some joints over a stretch of time, shape (frames, joints).

    Args:
        clip: The clip that is driven.
        joints: Their names.
        factor: What multiplies their velocities (or strengths) then.
        start: Beginning [s].
        end: End, included [s]; by default that of the clip.
        base: Array to multiply, in place of ones.

    Raises:
        UnknownName: No such joint.
        InvalidValue: No frame of the clip lies between the times.
    """
    out = np.ones((clip.frames, len(clip.skeleton)))
    if base is not None:
        out *= base
    last = clip.duration if end is None else end
    slack = 1e-6 / clip.rate
    chosen = np.flatnonzero((clip.times >= start - slack) & (clip.times <= last + slack))
    if not len(chosen):
        raise InvalidValue(
            f"No frame of {clip.name!r} lies between {start:g} and {last:g} s; it lasts "
            f"0 .. {clip.duration:g} s."
        )
    for name in joints:
        out[chosen, clip.skeleton.index(name)] *= factor
    return out
