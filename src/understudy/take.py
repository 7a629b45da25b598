"""What happened: states, controls and time of one performance; turns back into a clip."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np

from understudy.character import Athlete, Linkage, retargeted
from understudy.control import Tracking
from understudy.control.reference import sampled as sampled_reference
from understudy.errors import InvalidValue
from understudy.motion.clip import Clip, Conventions
from understudy.motion.edits import sampled
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.scene import Scene

# Frames per second of an athlete's clip, which follows none [Hz]; or the nearest that divides.
_ATHLETE_RATE = 120.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Take:
    """The record of a simulation, one frame per physics step and the first state.

    Attributes:
        scene: Where it happened.
        performance: What was asked for; None for a take read from disk.
        model: The model with the gains the controllers set.
        rate: Frames per second [Hz], the inverse of the time step.
        times: Time of each frame [s], shape (frames,).
        qpos: Positions, shape (frames, nq); see `Part` for each character's slice.
        qvel: Velocities, shape (frames, nv).
        ctrl: Control applied from each frame to the next, shape (frames, nu); the last row is a
            copy of the one before.
        qfrc_applied: Generalized forces applied besides the servos [N, N m], shape (frames, nv).
        xfrc_applied: Pushes: world force [N] at every body's center of mass, then torque [N m],
            shape (frames, nbody, 6); zeros by default.
        references: The tracked clip of each character, on its own skeleton, or None.
        captured: The clip of each character as it was read, or None.
        seed: Seed of the performance.
        diverged: Time of divergence [s], or None.
        facts: Plain values worth keeping (law, pelvis, CPU seconds, ...), JSON-able.
    """

    scene: Scene
    model: mujoco.MjModel = field(repr=False)
    performance: Performance | None = field(default=None, repr=False)
    rate: float
    times: Array = field(repr=False)
    qpos: Array = field(repr=False)
    qvel: Array = field(repr=False)
    ctrl: Array = field(repr=False)
    qfrc_applied: Array = field(repr=False)
    xfrc_applied: Array = field(default_factory=lambda: np.zeros((0, 0, 6)), repr=False)
    references: tuple[Clip | None, ...] = field(default=(), repr=False)
    captured: tuple[Clip | None, ...] = field(default=(), repr=False)
    seed: int = 0
    diverged: float | None = None
    facts: dict[str, Any] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        frames = len(self.times)
        if not np.any(self.xfrc_applied):  # nobody pushed, for however long
            still = np.broadcast_to(0.0, (frames, self.model.nbody, 6))
            object.__setattr__(self, "xfrc_applied", still)
        for name in ("times", "qpos", "qvel", "ctrl", "qfrc_applied", "xfrc_applied"):
            array = np.asarray(getattr(self, name), float)
            if len(array) != frames:
                raise InvalidValue(f"{name} has {len(array)} frames; times has {frames}.")
            if array.flags.writeable:
                array = array.view()
                array.flags.writeable = False
            object.__setattr__(self, name, array)
        for name in ("references", "captured"):
            values = tuple(getattr(self, name)) or (None,) * len(self.scene.characters)
            object.__setattr__(self, name, values)

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.times)

    @property
    def duration(self) -> float:
        """Simulated time [s]."""
        return float(self.times[-1] - self.times[0])

    def stride(self, rate: float | None) -> int:
        """Frames from one sample to the next at `rate` [Hz] or the nearest that divides evenly."""
        if rate is None:
            return 1
        if not (np.isfinite(rate) and rate > 0):
            raise InvalidValue(f"rate is {rate} Hz; it must be positive.")
        return max(1, round(self.rate / rate))

    def clip(self, character: int = 0, *, rate: float | None = None) -> Clip:
        """The simulated motion as a clip on the character's skeleton.

        Args:
            character: Which of the scene's characters.
            rate: Frames per second [Hz]; by default that of the tracked clip, an athlete 120. The
                nearest that divides the take's evenly is used: every frame is a simulated state.
        """
        reference, body = self.references[character], self.scene.characters[character]
        if rate is None and reference is not None:
            rate = reference.rate
        elif rate is None and isinstance(body, Athlete):
            rate = _ATHLETE_RATE
        every = self.stride(rate)
        part = self.scene.parts[character]
        state = self.qpos[::every, part.qpos]
        if isinstance(body, Linkage):
            return self._linkage_clip(body, state, reference, every)
        return Clip(
            skeleton=body.skeleton,
            rotations=body.local_rotations(state),
            root_positions=state[:, :3],
            rate=self.rate / every,
            name=f"{reference.name}_sim" if reference is not None else body.name,
            synthetic=True,
            notes=("Simulated motion.",),
        )

    def _linkage_clip(
        self, linkage: Linkage, state: Array, reference: Clip | None, every: int
    ) -> Clip:
        placed, turned = linkage.poses(state)
        leaves = None
        if reference is not None:
            times = np.minimum(self.times[::every], reference.duration)
            leaves, _ = sampled(reference, times, method="slerp")
        return Clip(
            skeleton=linkage.skeleton,
            rotations=linkage.joint_rotations(turned, leaves),
            root_positions=placed[:, 0],
            rate=self.rate / every,
            name=f"{reference.name}_sim" if reference is not None else linkage.name,
            synthetic=True,
            notes=("Simulated motion of rigid bodies.",),
            conventions=Conventions() if reference is None else reference.conventions,
        )

    def poses(self, rate: float | None = None) -> tuple[Array, Array, Array]:
        """World poses of every body of the model.

        Returns:
            Times [s] (frames,), body positions [m] (frames, bodies, 3) and body orientations wxyz
            (frames, bodies, 4).
        """
        every = self.stride(rate)
        states = self.qpos[::every]
        data = mujoco.MjData(self.model)
        placed = np.empty((len(states), self.model.nbody, 3))
        turned = np.empty((len(states), self.model.nbody, 4))
        for k, state in enumerate(states):
            data.qpos[:] = state
            mujoco.mj_kinematics(self.model, data)
            placed[k], turned[k] = data.xpos, data.xquat
        return self.times[::every], placed, turned


def posed(performance: Performance, *, character: int = 0) -> Take:
    """What a character is to track, as a take in which nothing was simulated.

    Its frames are the prepared clip's, its reference the clip as it was read, on the same body and
    raised or lowered by one constant to the same height: pictures and players show both.

    Args:
        performance: As `tracked` gives.
        character: Which of the scene's characters; props and others rest.

    Raises:
        InvalidValue: That character tracks no clip.
    """
    followed = [c for c in performance.controllers if isinstance(c, Tracking)]
    tracking = next((c for c in followed if c.character == character), None)
    if tracking is None:
        raise InvalidValue(f"Character {character} tracks no clip; there is nothing to pose.")
    clip, scene = tracking.reference, performance.scene
    captured = clip if tracking.captured is None else tracking.captured
    raw = retargeted(captured, scene.characters[character])
    common = min(raw.frames, clip.frames)
    away = clip.root_positions[:common, 2] - raw.root_positions[:common, 2]
    raw = replace(raw, root_positions=raw.root_positions + np.array([0.0, 0.0, np.median(away)]))
    reference = sampled_reference(clip, clip.times)
    qpos = np.tile(scene.model.qpos0, (clip.frames, 1))
    qpos[:, scene.parts[character].qpos] = reference.qpos()
    shown: list[Clip | None] = [None] * len(scene.characters)
    shown[character] = raw
    return Take(
        scene=scene,
        performance=performance,
        model=scene.model,
        rate=clip.rate,
        times=clip.times,
        qpos=qpos,
        qvel=np.zeros((clip.frames, scene.model.nv)),
        ctrl=np.zeros((clip.frames, scene.model.nu)),
        qfrc_applied=np.zeros((clip.frames, scene.model.nv)),
        references=tuple(shown),
        facts={"posed": True},
    )
