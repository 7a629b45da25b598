"""What every task controller shares: a span of time, the joints it owns, the servo it commands.

Zordan & Hodgins 1999, section 4.2: a task controller replaces some degrees of freedom of the
tracked motion by feedback; the rest of the body follows the clip. Here the clip's controls are laid
down first (`Tracking`), then each task changes the commands of its own joints, by a weight that
eases in and out of its span. A task never changes a gain: every torque a task wants is put into the
command of the joint's one servo, so that strength limits hold for it too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from numbers import Real
from typing import Any

import mujoco
import numpy as np

from understudy.character import Character
from understudy.control.quaternion import advanced, between, orientation, quaternion_at, turned
from understudy.errors import InvalidValue, UnknownName, shown
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.scene import Scene

# Numbers at the head of every task's parameters: begin, end, ease [s].
TIMES = 3
# What a law knows of a joint: its body, the parent's body, places in qpos, qvel and ctrl, servo
# stiffness [N m/rad] and damping [N m s/rad], weight outboard of it [N].
JOINT = 8


@dataclass(frozen=True, kw_only=True)
class Task:
    """Base of all tasks.

    Attributes:
        character: Which of the scene's characters.
        span: When it begins to take over, and when it has let go again [s]; by default always.
        ease: How long it takes to take over, and to let go [s].
    """

    character: int = 0
    span: tuple[float, float] = (0.0, math.inf)
    ease: float = 0.3

    def __post_init__(self) -> None:
        try:
            first, last = (float(time) for time in self.span)
        except (TypeError, ValueError):
            raise InvalidValue(
                f"{self.kind}: span is {shown(self.span)}; it must be two times [s]."
            ) from None
        if not 0.0 <= first < last:
            raise InvalidValue(
                f"{self.kind}: span is {first:g} to {last:g} s; it must begin at zero or later and "
                "end after it begins."
            )
        object.__setattr__(self, "span", (first, last))
        if not (isinstance(self.ease, Real) and 0.0 <= self.ease < math.inf):
            raise InvalidValue(
                f"{self.kind}: ease is {shown(self.ease)} s; it must be zero or positive."
            )

    @property
    def kind(self) -> str:
        """The task's name in messages."""
        return type(self).__name__

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints whose commands it replaces."""
        return ()

    @property
    def pelvis(self) -> str | None:
        """What should hold the pelvis where nobody says so: "free", or None for no opinion."""
        return None

    def fitted(self, reference: Clip, body: Character) -> tuple[Task, Clip]:
        """The task and the reference, made ready for each other before a performance.

        Args:
            reference: What the character will track, on its own skeleton.
            body: The character.

        Raises:
            UnknownName: The body lacks a joint that the task needs.
            InvalidValue: It cannot be done, for instance a target out of reach.
        """
        self.check_joints(body)
        return self, reference

    def check_joints(self, body: Character) -> None:
        """Refuse a body that lacks a joint of the task.

        Raises:
            UnknownName: Names the task, the joint and those there are.
        """
        known = [link.joint for link in body.links]
        for joint in self.joints:
            if joint not in known and body.plan.startswith("upper"):
                raise InvalidValue(
                    f"{self.kind} needs {joint!r}; {body.name!r} was made with plan "
                    f"{body.plan!r}, which has no legs: use 'full'."
                )
            if joint not in known:
                raise UnknownName(f"joint for {self.kind} in {body.name!r}", joint, known)

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Check that the character has the joints.

        Raises:
            UnknownName: It lacks one.
            InvalidValue: The scene has no such character.
        """
        if not 0 <= self.character < len(scene.characters):
            raise InvalidValue(
                f"{self.kind}: character is {self.character}; the scene has "
                f"{len(scene.characters)}, counted from 0."
            )
        body = scene.characters[self.character]
        if not isinstance(body, Character):
            raise InvalidValue(f"{self.kind}: {body.name!r} has no servos; tasks need a Character.")
        self.check_joints(body)

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Leave the first state as it is."""

    @property
    def times(self) -> tuple[float, float, float]:
        """Begin, end and ease [s]: the first numbers of every task's parameters."""
        return (*self.span, self.ease)


def check_overlaps(controllers: Iterable[Any]) -> None:
    """Refuse two tasks that command one joint at one time.

    Raises:
        InvalidValue: Names both tasks, the joint and the times.
    """
    tasks = [c for c in controllers if isinstance(c, Task)]
    for a, b in combinations(tasks, 2):
        if a.character != b.character:
            continue
        shared = [joint for joint in a.joints if joint in b.joints]
        first, last = max(a.span[0], b.span[0]), min(a.span[1], b.span[1])
        if shared and first < last:
            to = "the end" if math.isinf(last) else f"{last:g} s"
            raise InvalidValue(
                f"{a.kind} and {b.kind} both command {shared[0]!r} from {first:g} s to {to}; "
                "let one end before the other starts."
            )


def joint_rows(scene: Scene, model: mujoco.MjModel, character: int, joints: Sequence[str]) -> Array:
    """What laws need to know of joints, shape (joints, JOINT)."""
    part, body = scene.parts[character], scene.characters[character]
    gravity = abs(float(model.opt.gravity[2]))
    out = np.zeros((len(joints), JOINT))
    for row, name in zip(out, joints, strict=True):
        i = body.index(name)
        own, actuator = part.bodies[i], part.joint_actuators[i - 1]
        row[:] = (
            own,
            model.body_parentid[own],
            part.qpos.start + 3 + 4 * i,
            part.dofs.start + 3 + 3 * i,
            part.joint_controls[i - 1],
            model.actuator_gainprm[actuator, 0],
            -model.actuator_biasprm[actuator, 2],
            model.body_subtreemass[own] * gravity,
        )
    return out


def site_number(model: mujoco.MjModel, name: str, who: str) -> int:
    """Number of a named site.

    Raises:
        UnknownName: The scene has no such site; the text suggests the nearest.
    """
    kind = mujoco.mjtObj.mjOBJ_SITE
    number = mujoco.mj_name2id(model, kind, name)
    if number < 0:
        names = (mujoco.mj_id2name(model, kind, k) for k in range(model.nsite))
        raise UnknownName(f"site for {who}", name, [n for n in names if n])
    return number


# -- parts of laws -----------------------------------------------------------------------------


def weight_at(time, parameters):  # type: ignore[no-untyped-def]
    """How far a task has taken over, 0 to 1: sinusoidal ease in and out (equation 4's)."""
    start, end, ease = parameters[0], parameters[1], parameters[2]
    inside = min(time - start, end - time)
    if inside <= 0.0:
        return 0.0
    if inside >= ease:
        return 1.0
    return 0.5 - 0.5 * math.cos(math.pi * inside / ease)


def gravity_torque(state, body, weight):  # type: ignore[no-untyped-def]
    """Torque about a joint that holds what hangs on it, in the joint's body frame [N m]."""
    x = state.subtree_com[body, 0] - state.xpos[body, 0]
    y = state.subtree_com[body, 1] - state.xpos[body, 1]
    w, i, j, k = orientation(state.xquat, body)
    return turned(w, -i, -j, -k, y * weight, -x * weight, 0.0)


def spin_of(state, dof):  # type: ignore[no-untyped-def]
    """Angular velocity of a ball joint in its body's frame [rad/s]."""
    return state.qvel[dof], state.qvel[dof + 1], state.qvel[dof + 2]


def commanded(state, parameters, row, wanted, torque):  # type: ignore[no-untyped-def]
    """The command with which a joint's servo pulls to `wanted` and gives `torque` besides.

    `row` is where the joint's numbers begin in the parameters; `torque` is in the body frame.
    """
    k = parameters[row + 5]
    if k <= 0.0:
        return wanted
    return advanced(wanted, torque[0] / k, torque[1] / k, torque[2] / k)


def given_torque(state, parameters, row, torque):  # type: ignore[no-untyped-def]
    """The command with which a joint's servo gives exactly `torque`, damping included."""
    k, kd = parameters[row + 5], parameters[row + 6]
    q = quaternion_at(state.qpos, int(parameters[row + 2]))
    if k <= 0.0:
        return q
    x, y, z = spin_of(state, int(parameters[row + 3]))
    return advanced(q, (torque[0] + kd * x) / k, (torque[1] + kd * y) / k, (torque[2] + kd * z) / k)


def error_of(state, parameters, row, wanted):  # type: ignore[no-untyped-def]
    """Rotation vector from a joint to what is wanted of it, in its body's frame [rad]."""
    return between(quaternion_at(state.qpos, int(parameters[row + 2])), wanted)


def put(ctrl, parameters, row, command, weight):  # type: ignore[no-untyped-def]
    """Replace a joint's command in `ctrl` by `command`, by a weight from 0 to 1."""
    c = int(parameters[row + 4])
    if weight < 1.0:
        a, b, d = between(quaternion_at(ctrl, c), command)
        command = advanced(quaternion_at(ctrl, c), weight * a, weight * b, weight * d)
    ctrl[c], ctrl[c + 1], ctrl[c + 2], ctrl[c + 3] = command
