"""A clip's upper body on a runner: waist, neck and arms follow it, the legs stay the controller's.

    running(athlete_man(), Course.steady(3.5), duration=8.0, upper=read("punch.bvh"))

A clip of somebody who runs is locked to the runner's stride: one cycle of it, from the moment the
left thigh passes the right one to the next, is played as fast as the runner strides. Any other clip
plays at its own speed once, or over and over. The law comes after the runner's and takes over its
18 hinges of the upper body; balance stays with the legs. They carry a trunk that goes with the
pelvis and turns against the legs: so of the waist's lean and turn only a share is the clip's, and
sideways it does not bend.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np

from understudy.athletics import running_law as law
from understudy.athletics.running import NAMED_BODY, Running
from understudy.character import Athlete, athlete_man, retargeted
from understudy.character.hinged import UPPER, pointing, upper_angles
from understudy.control.trajectory import bounded, ease, servo
from understudy.errors import InvalidValue, expect
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.scene import Scene

# Parameters: where the body is, then the clip and how it is played, then gains, then its angles.
# fmt: off
(
    U_QPOS, U_QVEL, U_CTRL, U_DT, U_SCALE, U_ROWS, U_RATE, U_BEGIN, U_END, U_STRIDE, U_LOOP,
    U_TURN
) = range(12)
# fmt: on
U_GAINS = 12
U_TABLE = U_GAINS + 2 * UPPER
# Memory: of a stride its share and length, when it began, and whether the left thigh is ahead.
SHARE, PERIOD, SINCE, AHEAD = range(4)
MEMORY = 4

# Servos of waist, neck, shoulder, elbow and wrist for a body of 70 kg and 1.75 m: stiffness
# [N m/rad] and damping [N m s/rad], the waist's beside 30 of its tissue.
_WAIST, _NECK, _SHOULDER, _ELBOW, _WRIST = (900, 60), (150, 6), (300, 14), (160, 6), (15, 0.3)
_ARM = (_SHOULDER,) * 3 + (_ELBOW,) + (_WRIST,) * 2
_SERVOS = np.array((_WAIST,) * 3 + (_NECK,) * 3 + _ARM + _ARM, float)
# The upper body comes and goes over this time [s].
BLEND = 0.4
# Strides last between these [s]; the share played closes on the runner's at this rate [1/s].
_STRIDE, _CLOSING = (0.4, 1.4), 3.0
# A thigh has passed the other when it is so far ahead; in a walk or run they swing so far [rad].
_PASSED, _SWING = 0.1, 0.35
# The waist's hinge about z.
_TURN = 2
# Points of a cycle, and seconds over which a repeated clip's end becomes its beginning.
_CYCLE, _SEAM = 120, 0.3


def layered(time, state, ctrl, applied, p, m):  # type: ignore[no-untyped-def]
    """One step: servos of the upper body's hinges toward the clip, in place of the runner's."""
    q, v, c = int(p[U_QPOS]) + 7, int(p[U_QVEL]) + 6, int(p[U_CTRL])
    left, right = q + law.LEFT_LEG + law.HIP_Y, q + law.RIGHT_LEG + law.HIP_Y
    strode(time, state.qpos[left] - state.qpos[right], p, m)
    weight = weighed(time, p)
    if weight <= 0.0:
        return
    row, between, speed = played(time, p, m)
    for k in range(UPPER):
        angle, rate = desired(p, k, row, between, speed)
        stiffness, damping = p[U_GAINS + 2 * k], p[U_GAINS + 2 * k + 1]
        torque = servo(stiffness, damping, angle, state.qpos[q + k], rate, state.qvel[v + k])
        share = weight * p[U_TURN] if k == _TURN else weight
        ctrl[c + k] += share * (p[U_SCALE] * torque - ctrl[c + k])


def strode(time, ahead, p, m):  # type: ignore[no-untyped-def]
    """Keep the share of the runner's stride; `ahead` is the left hip's flexion less the right's."""
    if m[AHEAD] == 0.0 and ahead > _PASSED:
        m[AHEAD] = 1.0
        if m[SINCE] >= 0.0:
            lasted = bounded(time - m[SINCE], *_STRIDE)
            m[PERIOD] += 0.5 * (lasted - m[PERIOD])
        m[SINCE] = time
    elif m[AHEAD] == 1.0 and ahead < -_PASSED:
        m[AHEAD] = 0.0
    behind = (time - max(m[SINCE], 0.0)) / m[PERIOD] - m[SHARE]
    behind -= math.floor(behind + 0.5)
    m[SHARE] += p[U_DT] * (1.0 / m[PERIOD] + _CLOSING * behind)


def weighed(time, p):  # type: ignore[no-untyped-def]
    """How much of the upper body is the clip's, 0 to 1."""
    return ease((time - p[U_BEGIN]) / BLEND) * ease((p[U_END] - time) / BLEND)


def played(time, p, m):  # type: ignore[no-untyped-def]
    """Row of the clip's table, how far to the next, and rows per second."""
    rows = int(p[U_ROWS])
    if p[U_STRIDE] > 0.0:
        at, speed = (m[SHARE] - math.floor(m[SHARE])) * (rows - 1), (rows - 1) / m[PERIOD]
    else:
        at, speed = (time - p[U_BEGIN]) * p[U_RATE], p[U_RATE]
        if p[U_LOOP] > 0.0:
            at -= math.floor(at / (rows - 1)) * (rows - 1)
    at = bounded(at, 0.0, rows - 1.001)
    return int(at), at - int(at), speed


def desired(p, hinge, row, share, speed):  # type: ignore[no-untyped-def]
    """Angle and rate of a hinge [rad, rad/s]."""
    a = U_TABLE + UPPER * row + hinge
    step = p[a + UPPER] - p[a]
    return p[a] + share * step, step * speed


@dataclass(frozen=True, kw_only=True)
class UpperBody:
    """Controller of a runner's upper body; comes after `Running` among a performance's controllers.

    Attributes:
        clip: Of a person, on any skeleton.
        begin: When the clip begins [s].
        loop: Whether it is repeated; a clip of running always is.
        stride: Whether it is locked to the runner's stride; None: if its legs walk or run.
        lean: Share of the waist's forward lean that the runner shows, 0 to 1.
        turn: Share of the waist's turn that is the clip's, 0 to 1; the rest is the runner's own,
            which turns against his legs.
        character: Which of the scene's characters.
    """

    clip: Clip = field(repr=False)
    begin: float = 0.5
    loop: bool = False
    stride: bool | None = None
    lean: float = 0.25
    turn: float = 0.0
    character: int = 0

    def __post_init__(self) -> None:
        expect(self.clip, Clip, "upper", "a Clip, as `read` gives")
        if not 0.0 <= self.begin < np.inf:
            raise InvalidValue(f"begin is {self.begin} s; it must be zero or more.")
        for name in ("lean", "turn"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InvalidValue(f"{name} is {getattr(self, name)}; it must lie in 0 to 1.")
        if self.stride and not self.strides:
            raise InvalidValue(
                f"{self.clip.name}: no whole stride of somebody who walks or runs was found; leave "
                "stride out to play it at its own speed."
            )

    @cached_property
    def strides(self) -> tuple[tuple[int, int, int], ...]:
        """Strides of somebody who walks or runs: first, last and middle frame of each."""
        return _strides(self.clip)

    @property
    def locked(self) -> bool:
        """Whether the clip is locked to the stride."""
        return bool(self.strides) if self.stride is None else self.stride

    @property
    def facts(self) -> dict[str, Any]:
        """What a take keeps of it."""
        return {"upper": self.clip.name, "upper_stride": self.locked}

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Check that the character is an athlete."""
        self.athlete(scene)

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Leave the first state as it is."""

    def athlete(self, scene: Scene) -> Athlete:
        """The body it drives.

        Raises:
            InvalidValue: The scene's character is no athlete.
        """
        return Running(character=self.character).athlete(scene)

    def table(self, athlete: Athlete) -> tuple[Array, float]:
        """Angles to play [rad], shape (rows, 18), and how many a second (of a stride 0)."""
        angles = upper_angles(self.clip, athlete)
        angles[:, :2] *= (0.0, self.lean)
        if self.locked:
            return _cycle(angles, self.strides), 0.0
        return (_closed(angles, self.clip.rate) if self.loop else angles), self.clip.rate

    def away(self, athlete: Athlete) -> Array:
        """How far the hinges can at best point arms from the clip's [rad]; see `pointing`."""
        return pointing(self.clip, athlete, upper_angles(self.clip, athlete))

    def asked(self, scene: Scene, qpos: Array) -> tuple[Array, Array]:
        """What it asked for through a run: angles [rad], (steps, 18), and how much of them.

        Args:
            scene: Of the run.
            qpos: Its states, one a step, shape (steps, nq).
        """
        p, m = self._played(scene)
        at = scene.parts[self.character].qpos.start + 7
        left, right = (qpos[:, at + leg + law.HIP_Y] for leg in (law.LEFT_LEG, law.RIGHT_LEG))
        rows, weights = np.zeros(len(qpos)), np.zeros(len(qpos))
        for step, ahead in enumerate((left - right).tolist()):
            time = step * scene.timestep
            strode(time, ahead, p, m)
            row, share, _ = played(time, p, m)
            rows[step], weights[step] = row + share, weighed(time, p)
        table = p[U_TABLE:].reshape(-1, UPPER)
        every = np.arange(len(table))
        angles = [np.interp(rows, every, table[:, k]) for k in range(UPPER)]
        return np.stack(angles, axis=1), weights

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, the clip's angles, and a stride that begins."""
        return layered, *self._played(scene)

    def _played(self, scene: Scene) -> tuple[Array, Array]:
        """Parameters, and memory at time zero."""
        body, part = self.athlete(scene), scene.parts[self.character]
        table, rate = self.table(body)
        head = np.zeros(U_GAINS)
        head[U_QPOS], head[U_QVEL] = part.qpos.start, part.dofs.start
        head[U_CTRL], head[U_DT] = part.joint_controls[0], scene.timestep
        head[U_SCALE] = body.mass * body.height / NAMED_BODY
        head[U_ROWS], head[U_RATE], head[U_BEGIN] = len(table), rate, self.begin
        ends = not (self.locked or self.loop)
        head[U_END] = self.begin + self.clip.duration if ends else 1e9
        head[U_STRIDE], head[U_LOOP], head[U_TURN] = self.locked, self.loop, self.turn
        memory = np.zeros(MEMORY)
        memory[PERIOD], memory[SINCE] = 0.72, -1.0
        return np.concatenate((head, _SERVOS.ravel(), table.ravel())), memory


def _strides(clip: Clip) -> tuple[tuple[int, int, int], ...]:
    """First, last and middle frame of every stride.

    It begins where the left thigh passes the right one, by the rule of `strode`, or half a stride
    later where the right one does; the middle is where the left one does within it.
    """
    ahead = _thighs(clip)
    left, right = _passes(ahead), _passes(-ahead)
    found = [(a, b, a) for a, b in pairwise(left)]
    found += [(a, b, m) for a, b in pairwise(right) for m in left if a < m < b]
    return tuple(
        (a, b, m)
        for a, b, m in found
        if _STRIDE[0] <= (b - a) / clip.rate <= _STRIDE[1] and np.ptp(ahead[a:b]) > 2.0 * _SWING
    )


def _passes(ahead: Array) -> list[int]:
    """Frames at which a thigh has passed the other."""
    out, before = [], ahead[0] > -_PASSED
    for frame, value in enumerate(ahead):
        if not before and value > _PASSED:
            out.append(frame)
            before = True
        elif before and value < -_PASSED:
            before = False
    return out


def _thighs(clip: Clip) -> Array:
    """How far the left thigh is ahead of the right one in the pelvis's frame [rad]."""
    moved = retargeted(clip.repaired(), athlete_man())
    turns = [moved.rotations[:, moved.skeleton.index(f"{side}_hip")] for side in ("left", "right")]
    ways = [rot.rotate(turn, np.array([0.0, 0.0, -1.0])) for turn in turns]
    left, right = (np.arctan2(way[:, 0], -way[:, 2]) for way in ways)
    return left - right


def _cycle(angles: Array, strides: tuple[tuple[int, int, int], ...]) -> Array:
    """The mean stride from where the left thigh passes, its end its beginning, (points + 1, 18)."""
    share, frames = np.linspace(0.0, 1.0, _CYCLE + 1), np.arange(len(angles))
    rows = []
    for first, last, middle in strides:
        whole = last - first
        # What does not come back to where it was is spread over the stride.
        drift = (angles[last] - angles[first]) / whole
        at = first + (middle - first + share * whole) % whole
        row = np.stack([np.interp(at, frames, angles[:, k]) for k in range(UPPER)], axis=1)
        rows.append(row - (at - first - 0.5 * whole)[:, None] * drift)
    return np.mean(rows, axis=0)


def _closed(angles: Array, rate: float) -> Array:
    """A clip to be repeated: its last part goes over into its first."""
    seam = min(round(_SEAM * rate), len(angles) // 3)
    share = np.arange(seam)[:, None] / max(seam, 1)
    weight = share * share * (3.0 - 2.0 * share)
    out = angles[: len(angles) - seam].copy()
    out[:seam] = (1.0 - weight) * angles[len(angles) - seam :] + weight * angles[:seam]
    return np.vstack((out, out[:1]))
