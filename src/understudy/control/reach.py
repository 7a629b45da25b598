"""Hands where they are wanted: reaching a target, and resting on a surface.

A task controller in the sense of Zordan & Hodgins 1999, section 4.2, where section 5.1 changes the
clip beforehand: at every step the arm is bent, from where the simulated shoulder really is, so that
the palm is at the target. The elbow stays in the plane the clip has it in, and the hand keeps the
clip's orientation or faces the surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np

from understudy.character import Character
from understudy.control.quaternion import (
    arc,
    between,
    composed,
    exponential,
    inverse,
    mixed,
    orientation,
    quaternion_at,
    rotated,
)
from understudy.control.reference import sampled
from understudy.control.task import (
    JOINT,
    TIMES,
    Task,
    commanded,
    gravity_torque,
    joint_rows,
    put,
    site_number,
    weight_at,
)
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.motion.skeleton import frozen_array
from understudy.scene import Scene

_BEND = (0.0, 0.0, 1.0)  # a straight arm bends about this axis of the upper arm
_PALM = (0.0, 0.0, -1.0)  # where a palm faces, in the hand's frame
_HALF_HAND = 0.0135  # half the thickness of a hand at the palm, over the body's height
# A hand goes to a place this far off a surface [m] in this part of its ease, then to the surface.
# Where it starts lower than that, it first goes back so far [m], and up.
_HOVER, _ON_THE_WAY, _BACK = 0.15, 0.75, 0.12
_SMOOTHING = 0.004  # of the speed with which the wanted pose changes [s]


@dataclass(frozen=True, kw_only=True)
class Reach(Task):
    """Brings the palm of a hand to a target and keeps it there.

    Attributes:
        hand: "left" or "right".
        target: A point [m], world, 3 numbers, or a named site of the scene such as "drum/skin",
            which may move.
        facing: World direction the palm is to face, 3 numbers; None keeps the clip's orientation.
        reference: The clip the character tracks; `tracked` fills it in.
    """

    hand: str = "right"
    target: str | tuple[float, float, float]
    facing: tuple[float, float, float] | None = None
    reference: Clip | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.hand not in ("left", "right"):
            raise InvalidValue(f"{self.kind}: hand is {self.hand!r}; it must be 'left' or 'right'.")
        if not isinstance(self.target, str):
            point = frozen_array(self.target, (3,), f"{self.kind}: target")
            object.__setattr__(self, "target", tuple(point.tolist()))
        if self.facing is not None:
            facing = frozen_array(self.facing, (3,), f"{self.kind}: facing")
            if np.linalg.norm(facing) < 1e-9:
                raise InvalidValue(f"{self.kind}: facing is zero; it must be a direction.")
            object.__setattr__(self, "facing", tuple(facing.tolist()))

    @property
    def joints(self) -> tuple[str, ...]:
        """Shoulder, elbow and wrist."""
        return tuple(f"{self.hand}_{part}" for part in ("shoulder", "elbow", "wrist"))

    @property
    def pressing(self) -> tuple[float, float, float]:
        """Force of the hand on what it reaches [N], world."""
        return (0.0, 0.0, 0.0)

    @property
    def approach(self) -> tuple[float, float, float]:
        """Where the hand comes from at the end, from the target [m], world; zeros: straight."""
        return (0.0, 0.0, 0.0)

    def beside(self, body: Character) -> Array:
        """From the target to where the middle of the hand belongs [m], world, shape (3,)."""
        return np.zeros(3)

    def fitted(self, reference: Clip, body: Character) -> tuple[Reach, Clip]:
        """The task with the reference it bends.

        Raises:
            UnknownName: The body lacks the arm.
            InvalidValue: The target is a point, and too far away; says how far.
        """
        self.check_joints(body)
        if not isinstance(self.target, str):
            self._check_reach(np.array(self.target), reference, body)
        return replace(self, reference=reference), reference

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Check the joints, and a target that stands still.

        Raises:
            UnknownName: The scene has no such site, or the character lacks the arm.
            InvalidValue: The target is too far away, or the task was given no reference.
        """
        super().configure(scene, model)
        if self.reference is None:
            raise InvalidValue(f"{self.kind} needs the clip; give it to `tracked` as a task.")
        if isinstance(self.target, str):
            site = site_number(model, self.target, self.kind)
            self._check_other(scene, model, site)
            if model.body_weldid[model.site_bodyid[site]] == 0:
                data = mujoco.MjData(model)
                mujoco.mj_kinematics(model, data)
                body = scene.characters[self.character]
                self._check_reach(data.site_xpos[site], self.reference, body)

    def _check_other(self, scene: Scene, model: mujoco.MjModel, site: int) -> None:
        """Refuse a target that hangs on the arm that is to reach it."""
        body, part = scene.characters[self.character], scene.parts[self.character]
        arm = {part.bodies[body.index(joint)] for joint in self.joints}
        on = int(model.site_bodyid[site])
        while on > 0:
            if on in arm:
                raise InvalidValue(
                    f"{self.kind}: {self.target!r} is on the {self.hand} arm itself; name a place "
                    "that does not move with it."
                )
            on = int(model.body_parentid[on])

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, with the clip's arm at every step, and what it wanted last."""
        assert self.reference is not None
        body, prefix = scene.characters[self.character], scene.parts[self.character].prefix
        site, point = -1.0, np.zeros(3)
        if isinstance(self.target, str):
            site = float(site_number(model, self.target, self.kind))
        else:
            point = np.array(self.target)
        palm = model.site_pos[site_number(model, f"{prefix}{self.hand}_palm", self.kind)]
        facing = np.zeros(3) if self.facing is None else np.array(self.facing)
        last = round(self.reference.duration / scene.timestep)
        times = np.arange(last + 1, dtype=np.float64) * scene.timestep
        arm = [body.index(joint) for joint in self.joints]
        rotations = sampled(self.reference, times).rotations[:, arm]
        target = (site, *point, *self.beside(body))
        hand = (*palm, *facing, *self.pressing, *self.approach)
        head = (*self.times, scene.timestep, last, *target, *hand)
        wrist = model.body_jntadr[scene.parts[self.character].bodies[arm[2]]]
        stop = float(model.jnt_range[wrist, 1]) if model.jnt_limited[wrist] else np.pi
        lengths = [float(np.linalg.norm(body.links[i].offset)) for i in arm[1:]]
        rows = joint_rows(scene, model, self.character, self.joints)
        memory = np.zeros(1 + 3 * 7)
        return (
            _law,
            np.concatenate((head, (0.95 * stop,), lengths, rows.ravel(), rotations.ravel())),
            memory,
        )

    def _check_reach(self, target: Array, reference: Clip, body: Character) -> None:
        """Refuse a target that the arm cannot reach while the task has taken over."""
        target = target + self.beside(body)
        arm = [body.index(joint) for joint in self.joints]
        pose = reference.forward_kinematics()
        times = reference.times
        first, last = self.span[0] + self.ease, self.span[1] - self.ease
        inside = np.flatnonzero((times >= first - 1e-9) & (times <= last + 1e-9))
        if not len(inside):
            return
        shoulder = pose.positions[inside, arm[0]]
        palm = _palm_of(body, self.hand)
        hand = pose.rotations[inside, arm[2]]
        wrist = target - rot.rotate(hand, palm)
        if self.facing is not None:
            now = rot.rotate(hand, np.array(_PALM))
            turned = rot.multiply(rot.shortest_arc(now, np.array(self.facing)), hand)
            wrist = target - rot.rotate(turned, palm)
        away = np.linalg.norm(wrist - shoulder, axis=1)
        reach = float(sum(np.linalg.norm(body.links[i].offset) for i in arm[1:]))
        worst = int(np.argmax(away))
        if away[worst] > reach:
            raise InvalidValue(
                f"{self.kind}: at {times[inside[worst]]:.2f} s the {self.hand} wrist would have to "
                f"be {away[worst]:.2f} m from the shoulder, which is at {_place(shoulder[worst])}; "
                f"the arm reaches {reach:.2f} m. Bring the target {away[worst] - reach:.2f} m "
                "nearer to the shoulder, or change the span."
            )


@dataclass(frozen=True, kw_only=True)
class HandOn(Reach):
    """Lays a palm on a surface and presses.

    Attributes:
        hand, target: As for `Reach`; the target is the point of the surface under the palm. The
            hand goes up and along to 15 cm off it, then comes down.
        ease: As for every task, but longer: the way is longer.
        normal: Out of the surface, world, 3 numbers.
        force: How hard to press [N], within some 8 N: the arm is a stiff spring besides.
        thickness: From the middle of the hand to the palm's skin [m]; None for a person's of the
            body's height.
    """

    ease: float = 0.8
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    force: float = 10.0
    thickness: float | None = None

    def __post_init__(self) -> None:
        normal = frozen_array(self.normal, (3,), "HandOn: normal")
        length = float(np.linalg.norm(normal))
        if length < 1e-9:
            raise InvalidValue("HandOn: normal is zero; it must point out of the surface.")
        object.__setattr__(self, "normal", tuple((normal / length).tolist()))
        object.__setattr__(self, "facing", tuple((-normal / length).tolist()))
        for name, unit, most in (("force", "N", 1e3), ("thickness", "m", 0.1)):
            value = getattr(self, name)
            if value is not None and not 0.0 <= value <= most:
                raise InvalidValue(
                    f"HandOn: {name} is {value} {unit}; it must lie in 0 to {most:g}."
                )
        super().__post_init__()

    @property
    def pressing(self) -> tuple[float, float, float]:
        """Force of the hand on the surface [N], world."""
        x, y, z = self.normal
        return -self.force * x, -self.force * y, -self.force * z

    @property
    def approach(self) -> tuple[float, float, float]:
        """The hand comes down on the surface, not along it."""
        x, y, z = self.normal
        return _HOVER * x, _HOVER * y, _HOVER * z

    def beside(self, body: Character) -> Array:
        """The hand's half thickness out of the surface."""
        half = _HALF_HAND * body.height if self.thickness is None else self.thickness
        return half * np.array(self.normal)


def _place(point: Array) -> str:
    """A point as people write it [m]."""
    return "(" + ", ".join(f"{value:.2f}" for value in point) + ")"


def _palm_of(body: Character, hand: str) -> Array:
    """The middle of the palm in the hand's frame [m]; the model's site of that name."""
    reach = 0.05 * body.height
    return np.array([0.0, reach if hand == "left" else -reach, 0.0])


# Places in the parameters after begin, end and ease.
_DT, _LAST, _SITE, _POINT, _BESIDE, _AT_PALM, _FACING = (TIMES + k for k in (0, 1, 2, 3, 6, 9, 12))
_FORCE, _APPROACH, _STOP, _LENGTHS, _ROWS = (TIMES + k for k in (15, 18, 21, 22, 24))
_CLIP = _ROWS + 3 * JOINT


def _law(time, state, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
    """Bend the arm of the clip to the target; hold its weight; press."""
    weight = weight_at(time, parameters)
    if weight == 0.0:
        memory[0] = 0.0
        return
    dt = parameters[_DT]
    step = min(int(time / dt + 0.5), int(parameters[_LAST]))
    at = _CLIP + 12 * step
    chest = orientation(state.xquat, int(parameters[_ROWS + 1]))
    # The clip's arm on the simulated shoulder.
    upper = composed(chest, quaternion_at(parameters, at))
    lower = composed(upper, quaternion_at(parameters, at + 4))
    hand = composed(lower, quaternion_at(parameters, at + 8))
    shoulder_body = int(parameters[_ROWS])
    shoulder = (
        state.xpos[shoulder_body, 0],
        state.xpos[shoulder_body, 1],
        state.xpos[shoulder_body, 2],
    )
    side = -1.0 if parameters[_AT_PALM + 1] < 0.0 else 1.0
    a, b = parameters[_LENGTHS], parameters[_LENGTHS + 1]
    ux, uy, uz = rotated(upper, (0.0, side * a, 0.0))
    lx, ly, lz = rotated(lower, (0.0, side * b, 0.0))
    palm = (parameters[_AT_PALM], parameters[_AT_PALM + 1], parameters[_AT_PALM + 2])
    # Where the palm is to be, and how turned: on the way from the clip's to the target's.
    weight, landed = phases(parameters, weight)
    goal = target_of(state, parameters, 1.0 - landed)
    away = (goal[0] - shoulder[0], goal[1] - shoulder[1], goal[2] - shoulder[2])
    # The palm has turned before it is over a surface's edge.
    turn = weight if landed == weight else smooth(2.5 * weight - 0.75)
    wanted_hand = faced(hand, parameters, turn, away)
    px, py, pz = rotated(hand, palm)
    now = (shoulder[0] + ux + lx + px, shoulder[1] + uy + ly + py, shoulder[2] + uz + lz + pz)
    gx, gy, gz = on_the_way(now, goal, parameters, weight)
    most, first, second = parameters[_STOP], upper, lower
    twist = twist_of(quaternion_at(parameters, at + 8))
    for _ in range(3):
        # The palm goes first: a wrist that would turn past its stop gives up the orientation.
        px, py, pz = rotated(wanted_hand, palm)
        wx, wy, wz = gx - px - shoulder[0], gy - py - shoulder[1], gz - pz - shoulder[2]
        upper, lower = bent(first, second, (ux, uy, uz), (lx, ly, lz), (wx, wy, wz), a, b)
        lower = pronated(lower, wanted_hand, twist)
        x, y, z = between(lower, wanted_hand)
        angle = math.sqrt(x * x + y * y + z * z)
        if angle <= most:
            break
        share = most / angle
        wanted_hand = composed(lower, exponential(share * x, share * y, share * z))
    wanted = (
        composed(inverse(chest), upper),
        composed(inverse(upper), lower),
        composed(inverse(lower), wanted_hand),
    )
    for k in range(3):
        row = _ROWS + JOINT * k
        ahead = changing(memory, 1 + 7 * k, wanted[k], memory[0] > 0.0, dt)
        body = int(parameters[row])
        kd = parameters[row + 6]
        tx, ty, tz = gravity_torque(state, body, parameters[row + 7])
        fx, fy, fz = leverage(state, body, goal, parameters)
        torque = (
            tx + kd * ahead[0] + landed * fx,
            ty + kd * ahead[1] + landed * fy,
            tz + kd * ahead[2] + landed * fz,
        )
        command = commanded(state, parameters, row, wanted[k], torque)
        put(ctrl, parameters, row, command, weight)
    memory[0] = 1.0


def phases(parameters, weight):  # type: ignore[no-untyped-def]
    """How far a hand has come on its way, and in coming down on a surface, each 0 to 1."""
    a = _APPROACH
    if parameters[a] == 0.0 and parameters[a + 1] == 0.0 and parameters[a + 2] == 0.0:
        return weight, weight
    return min(1.0, weight / _ON_THE_WAY), max(0.0, (weight - _ON_THE_WAY) / (1.0 - _ON_THE_WAY))


def on_the_way(now, goal, parameters, weight):  # type: ignore[no-untyped-def]
    """Where the palm is to be between the clip's place and the goal [m].

    To a surface it goes back and up first where it is lower, then along: not into its edge.
    """
    x, y, z = goal[0] - now[0], goal[1] - now[1], goal[2] - now[2]
    a = _APPROACH
    nx, ny, nz = parameters[a] / _HOVER, parameters[a + 1] / _HOVER, parameters[a + 2] / _HOVER
    up = x * nx + y * ny + z * nz
    rise, along = weight, weight
    if up > 0.0:
        far = math.sqrt(max((x - up * nx) ** 2 + (y - up * ny) ** 2 + (z - up * nz) ** 2, 1e-6))
        back = _BACK / far * (smooth(5.0 * weight) - smooth(2.5 * weight - 1.5))
        rise, along = smooth(2.5 * weight - 0.25), smooth(2.5 * weight - 1.5) - back
    return (
        now[0] + along * (x - up * nx) + rise * up * nx,
        now[1] + along * (y - up * ny) + rise * up * ny,
        now[2] + along * (z - up * nz) + rise * up * nz,
    )


def smooth(share):  # type: ignore[no-untyped-def]
    """0 to 1 as the share goes from 0 to 1, at rest at both ends."""
    s = min(1.0, max(0.0, share))
    return s * s * (3.0 - 2.0 * s)


def target_of(state, parameters, off):  # type: ignore[no-untyped-def]
    """Where the middle of the hand belongs now [m], `off` (0 to 1) of the approach away."""
    site = int(parameters[_SITE])
    x, y, z = parameters[_POINT], parameters[_POINT + 1], parameters[_POINT + 2]
    if site >= 0:
        x, y, z = state.site_xpos[site, 0], state.site_xpos[site, 1], state.site_xpos[site, 2]
    b, a = _BESIDE, _APPROACH
    return (
        x + parameters[b] + off * parameters[a],
        y + parameters[b + 1] + off * parameters[a + 1],
        z + parameters[b + 2] + off * parameters[a + 2],
    )


def faced(hand, parameters, weight, away):  # type: ignore[no-untyped-def]
    """The hand's world orientation, its palm turned to where it is to face.

    The fingers point away from the shoulder (`away`, world), and up along a wall.
    """
    x, y, z = parameters[_FACING], parameters[_FACING + 1], parameters[_FACING + 2]
    size = math.sqrt(x * x + y * y + z * z)
    if size == 0.0:
        return hand
    x, y, z = x / size, y / size, z / size
    nx, ny, nz = rotated(hand, _PALM)
    turned = composed(arc(nx, ny, nz, x, y, z), hand)
    far = math.sqrt(away[0] ** 2 + away[1] ** 2 + away[2] ** 2)
    wx, wy, wz = away[0], away[1], away[2] + 0.5 * far
    over = wx * x + wy * y + wz * z
    wx, wy, wz = wx - over * x, wy - over * y, wz - over * z
    side = -1.0 if parameters[_AT_PALM + 1] < 0.0 else 1.0
    fx, fy, fz = rotated(turned, (0.0, side, 0.0))
    across = x * (fy * wz - fz * wy) + y * (fz * wx - fx * wz) + z * (fx * wy - fy * wx)
    angle = math.atan2(across, fx * wx + fy * wy + fz * wz)
    turned = composed(exponential(angle * x, angle * y, angle * z), turned)
    return mixed(hand, turned, weight)


def bent(upper, lower, u, v, wanted, a, b):  # type: ignore[no-untyped-def]
    """World orientations of upper arm and forearm that bring the wrist to `wanted`.

    `u` and `v` are the arm's two bones now, `wanted` the wrist from the shoulder, all world [m];
    `a` and `b` the bones' lengths. The arm opens or closes in its own plane and then swings.
    """
    now = math.sqrt((u[0] + v[0]) ** 2 + (u[1] + v[1]) ** 2 + (u[2] + v[2]) ** 2)
    far = math.sqrt(wanted[0] ** 2 + wanted[1] ** 2 + wanted[2] ** 2)
    far = min(max(far, abs(a - b) + 1e-4), 0.9995 * (a + b))
    fold = bend_at(far, a, b) - bend_at(min(now, a + b), a, b)
    nx, ny, nz = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    # A straight arm bends about its own axis.
    hx, hy, hz = rotated(upper, _BEND)
    if u[0] * v[1] == 0.0 and size == 0.0:
        nx, ny, nz, size = hx, hy, hz, 1.0
    share = min(1.0, size / (0.05 * a * b))
    if nx * hx + ny * hy + nz * hz < 0.0:
        hx, hy, hz = -hx, -hy, -hz
    nx = share * nx / size + (1.0 - share) * hx
    ny = share * ny / size + (1.0 - share) * hy
    nz = share * nz / size + (1.0 - share) * hz
    size = max(math.sqrt(nx * nx + ny * ny + nz * nz), 1e-12)
    turn = exponential(fold * nx / size, fold * ny / size, fold * nz / size)
    x, y, z = rotated(turn, v)
    swing = arc(u[0] + x, u[1] + y, u[2] + z, wanted[0], wanted[1], wanted[2])
    return composed(swing, upper), composed(swing, composed(turn, lower))


def twist_of(q):  # type: ignore[no-untyped-def]
    """Angle of the part of a rotation that turns about y, along the bone of an arm [rad]."""
    return 2.0 * math.atan2(q[2], q[0])


def pronated(lower, hand, twist):  # type: ignore[no-untyped-def]
    """The forearm, rolled about its length so that the wrist keeps a twist [rad] of its own."""
    roll = twist_of(composed(inverse(lower), hand)) - twist
    roll -= 2.0 * math.pi * math.floor(roll / (2.0 * math.pi) + 0.5)
    return composed(lower, exponential(0.0, roll, 0.0))


def bend_at(distance, a, b):  # type: ignore[no-untyped-def]
    """Angle between two bones of lengths a and b when their ends are so far apart [rad]."""
    cosine = (distance * distance - a * a - b * b) / (2.0 * a * b)
    return math.acos(min(1.0, max(-1.0, cosine)))


def changing(memory, at, wanted, known, dt):  # type: ignore[no-untyped-def]
    """How fast what is wanted of a joint changes [rad/s], in its frame, smoothed; remembers it."""
    if known:
        x, y, z = between(quaternion_at(memory, at), wanted)
        share = dt / (dt + _SMOOTHING)
        memory[at + 4] += share * (x / dt - memory[at + 4])
        memory[at + 5] += share * (y / dt - memory[at + 5])
        memory[at + 6] += share * (z / dt - memory[at + 6])
    else:
        memory[at + 4], memory[at + 5], memory[at + 6] = 0.0, 0.0, 0.0
    memory[at], memory[at + 1], memory[at + 2], memory[at + 3] = wanted
    return memory[at + 4], memory[at + 5], memory[at + 6]


def leverage(state, body, goal, parameters):  # type: ignore[no-untyped-def]
    """Torque about a joint with which the hand presses at the goal, in the joint's frame [N m]."""
    fx, fy, fz = parameters[_FORCE], parameters[_FORCE + 1], parameters[_FORCE + 2]
    x = goal[0] - state.xpos[body, 0]
    y = goal[1] - state.xpos[body, 1]
    z = goal[2] - state.xpos[body, 2]
    arm = (y * fz - z * fy, z * fx - x * fz, x * fy - y * fx)
    return rotated(inverse(orientation(state.xquat, body)), arm)
