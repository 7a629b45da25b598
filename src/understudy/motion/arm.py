"""Inverse kinematics of one arm: a point of the hand is placed and the hand keeps its orientation.

Zordan & Hodgins 1999, section 5.1: shoulder, elbow and wrist are turned by nine numbers, three
rotation vectors, found by BFGS on a sum of weighted squares. The gradient is analytic.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

# Shorter bones than this [m] are no bones: joints of one place, which some files have.
SHORT = 1e-4
# Weights: position in arm lengths, orientation and offsets in radians, elbow and wrist as sines and
# cosines. The hand's place decides, then its orientation and natural joints; the smallest offsets
# break the tie.
# Solved in stages of growing weight on the place, each from the last one's answer: the valley is
# too narrow to be entered from outside.
POSITION = (1e2, 1e4, 1e6)
ORIENTATION = 1.0
NATURAL = 1.0
SIZE = 1e-3 * np.repeat((1.0, 1.0, 3.0), 3)
# The elbow folds to this cosine between upper arm and forearm's direction (148 degrees) and opens
# to this sine short of straight (2 degrees); the wrist bends to this cosine between forearm and
# hand (75 degrees).
FOLDED, STRAIGHT, BENT = -0.85, 0.035, 0.26


@dataclass(frozen=True, kw_only=True)
class Arm:
    """Shoulder, elbow and wrist of a skeleton.

    Attributes:
        joints: Indices of shoulder, elbow and wrist.
        path: Indices of the joints from the shoulder to the wrist, both included; those between
            that are not in `joints` lie on top of the next that is.
        upper: The elbow in the shoulder's frame [m], (3,).
        lower: The wrist in the elbow's frame [m], (3,).
        hand: The middle of the palm in the wrist's frame [m], (3,); see `palm`.
        hinge: The axis the elbow bends about, a unit vector in the shoulder's frame, (3,).
    """

    joints: tuple[int, int, int]
    path: tuple[int, ...]
    upper: Array = field(repr=False)
    lower: Array = field(repr=False)
    hand: Array = field(repr=False)
    hinge: Array = field(repr=False)

    def reach(self, point: Array) -> float:
        """Distance from the shoulder to a point in the wrist's frame, all stretched out [m]."""
        return float(sum(np.linalg.norm(v) for v in (self.upper, self.lower, point)))


@dataclass(frozen=True, kw_only=True)
class Posture:
    """An arm at one moment.

    Attributes:
        shoulder: World position of the shoulder [m], (3,).
        upper: World orientation of the upper arm, a matrix (3, 3).
        elbow: Orientation of the forearm in the upper arm's frame, (3, 3).
        wrist: Orientation of the hand in the forearm's frame, (3, 3).
        point: The point of the hand in the hand's frame [m], (3,).
    """

    shoulder: Array
    upper: Array
    elbow: Array
    wrist: Array
    point: Array

    def hand(self) -> Array:
        """World orientation of the hand, (3, 3)."""
        return self.upper @ self.elbow @ self.wrist


def arm_of(clip: Clip, joint: str) -> Arm:
    """The arm that ends at a joint: it, its parent and its grandparent, past joints of no length.

    The elbow's axis is that about which the clip bends it.

    Raises:
        UnknownName: No such joint.
        InvalidValue: Fewer than two bones lead to it.
    """
    skeleton = clip.skeleton
    wrist = skeleton.index(joint)
    path, ends, bones = [wrist], [wrist], []
    while len(ends) < 3 and skeleton.parents[path[-1]] >= 0:
        offset = skeleton.offsets[path[-1]]
        path.append(skeleton.parents[path[-1]])
        if np.linalg.norm(offset) > SHORT:
            ends.append(path[-1])
            bones.append(offset)
    if len(ends) < 3 or skeleton.parents[ends[-1]] < 0:
        raise InvalidValue(
            f"{joint!r} cannot be placed: it needs an elbow, a shoulder and a body inboard of it."
        )
    joints = (ends[2], ends[1], ends[0])
    return Arm(
        joints=joints,
        path=tuple(reversed(path)),
        lower=bones[0],
        upper=bones[1],
        hand=palm(skeleton, joint),
        hinge=_hinge(clip, joints),
    )


def _hinge(clip: Clip, joints: tuple[int, int, int]) -> Array:
    """The axis about which the elbow bends over the clip, in the upper arm's frame, (3,)."""
    pose = clip.forward_kinematics()
    shoulder, elbow, wrist = joints
    upper = pose.positions[:, elbow] - pose.positions[:, shoulder]
    lower = pose.positions[:, wrist] - pose.positions[:, elbow]
    back = rot.conjugate(pose.rotations[:, shoulder])
    bend = np.cross(rot.rotate(back, upper), rot.rotate(back, lower)).mean(axis=0)
    along = rot.rotate(back[0], upper[0])
    area = float(np.linalg.norm(along) * np.linalg.norm(lower[0]))
    if np.linalg.norm(bend) < 0.02 * area:
        # Never bent: a person at rest faces +x, and elbows bend forward.
        bend = np.cross(along, [1.0, 0.0, 0.0])
        if np.linalg.norm(bend) < 0.1 * np.linalg.norm(along):
            bend = np.cross(along, [0.0, 0.0, 1.0])
    return bend / np.linalg.norm(bend)


def palm(skeleton: Skeleton, joint: str) -> Array:
    """The middle of the hand in the wrist's frame [m], (3,): half way to the hand's far end.

    The far end is the most distant end site, or joint, that hangs on the wrist at rest; a wrist on
    which nothing hangs is its own palm.
    """
    wrist = skeleton.index(joint)
    rest = skeleton.rest_positions()
    hand = [wrist]
    for i in range(wrist + 1, len(skeleton)):
        if skeleton.parents[i] in hand:
            hand.append(i)
    points = [rest[i] for i in hand]
    points += [
        rest[j] + offset
        for j, offset in zip(skeleton.end_joints, skeleton.end_offsets, strict=True)
        if j in hand
    ]
    away = np.array(points) - rest[wrist]
    return 0.5 * away[int(np.linalg.norm(away, axis=1).argmax())]


def posture(arm: Arm, skeleton: Skeleton, local: Array, root: Array, point: Array) -> Posture:
    """An arm in one pose of the body.

    Args:
        arm: The arm.
        skeleton: The body's.
        local: Local rotations of all joints, (joints, 4).
        root: World position of the root [m], (3,).
        point: The point of the hand in the wrist's frame [m], (3,).
    """
    line = [arm.joints[0]]
    while skeleton.parents[line[0]] >= 0:
        line.insert(0, skeleton.parents[line[0]])
    turn, place = local[0], root
    for i in line[1:]:
        place = place + rot.rotate(turn, skeleton.offsets[i])
        turn = rot.multiply(turn, local[i])
    bend = rot.identity()
    steps = []
    for i in arm.path[1:]:
        bend = rot.multiply(bend, local[i])
        if i in arm.joints:
            steps.append(bend)
            bend = rot.identity()
    return Posture(
        shoulder=place,
        upper=rot.to_matrix(turn),
        elbow=rot.to_matrix(steps[0]),
        wrist=rot.to_matrix(steps[1]),
        point=np.asarray(point, float),
    )


def solved(arm: Arm, posture: Posture, goal: Array) -> Array:
    """Rotation vectors [rad], (3, 3), that turn shoulder, elbow and wrist to bring the hand there.

    Each is applied after the joint's own rotation: q exp(offset). `goal` is the world position [m],
    (3,), for the posture's point.
    """
    objective = Objective(arm, posture, goal)
    best = _guessed(arm, posture, np.asarray(goal, float)).reshape(9)
    for weight in POSITION:
        objective.weight = weight
        best = minimize(
            objective, best, jac=True, method="BFGS", options={"gtol": 1e-6, "maxiter": 200}
        ).x
    return best.reshape(3, 3)


def moved(posture: Posture, offsets: Array) -> Posture:
    """The arm with its three joints turned further by rotation vectors [rad], (3, 3)."""
    turns = [_exponential(v) for v in offsets]
    return Posture(
        shoulder=posture.shoulder,
        upper=posture.upper @ turns[0],
        elbow=posture.elbow @ turns[1],
        wrist=posture.wrist @ turns[2],
        point=posture.point,
    )


def place(arm: Arm, posture: Posture) -> Array:
    """World position of the posture's point [m], (3,)."""
    forearm = posture.upper @ posture.elbow
    hand = forearm @ posture.wrist
    return posture.shoulder + posture.upper @ arm.upper + forearm @ arm.lower + hand @ posture.point


def _guessed(arm: Arm, posture: Posture, goal: Array) -> Array:
    """Offsets (3, 3) to start from: the elbow folds, the shoulder swings, the hand turns back.

    A straight arm whose hand is to come straight in has no gradient to leave by; this leaves.
    """
    start, kept = posture.shoulder, posture.hand()
    wanted = goal - kept @ posture.point - start
    a, b = float(np.linalg.norm(arm.upper)), float(np.linalg.norm(arm.lower))
    far = float(np.clip(np.linalg.norm(wanted), abs(a - b) + 1e-3 * (a + b), 0.999 * (a + b)))
    upper, lower = arm.upper / a, posture.elbow @ arm.lower / b
    now = np.arctan2(lower @ _cross(arm.hinge, upper), lower @ upper)
    bend = float(np.arccos(np.clip((far**2 - a**2 - b**2) / (2.0 * a * b), -1.0, 1.0)) - now)
    fold = posture.elbow.T @ arm.hinge * bend
    forearm = posture.elbow @ _exponential(fold)
    swing = rot.to_matrix(
        rot.shortest_arc(posture.upper @ (arm.upper + forearm @ arm.lower), wanted)
    )
    upper_arm = swing @ posture.upper
    return np.stack(
        (
            _logarithm(posture.upper.T @ upper_arm),
            fold,
            _logarithm(posture.wrist.T @ (upper_arm @ forearm).T @ kept),
        )
    )


class Objective:
    """Sum of weighted squares of nine offsets [rad], (9,), and its gradient.

    `weight` is that of the place, in arm lengths squared.
    """

    def __init__(self, arm: Arm, posture: Posture, goal: Array):
        self.arm, self.posture, self.goal = arm, posture, np.asarray(goal, float)
        self.weight = POSITION[-1]
        self._kept = posture.hand()
        self._length = arm.reach(posture.point)
        upper = arm.upper / np.linalg.norm(arm.upper)
        self._lower = arm.lower / np.linalg.norm(arm.lower)
        # Components of the forearm's direction: out of the bending plane, in it across the upper
        # arm, and along it.
        self._rows = np.stack((arm.hinge, _cross(arm.hinge, upper), upper))
        side, straight, fold = self._rows @ posture.elbow @ self._lower
        # A hand of no length has no direction and no limit.
        self._hand = arm.hand / max(float(np.linalg.norm(arm.hand)), SHORT)
        bend = float(self._lower @ posture.wrist @ self._hand)
        # What the clip itself does with elbow and wrist may stay.
        self._allowed = np.array((side, min(straight, STRAIGHT), min(fold, FOLDED)))
        self._allowed_bend = min(bend, BENT)

    def __call__(self, x: Array) -> tuple[float, Array]:
        """Value, and gradient (9,)."""
        offsets, now = x.reshape(3, 3), self.posture
        turns = [_exponential(v) for v in offsets]
        upper = now.upper @ turns[0]
        elbow = now.elbow @ turns[1]
        forearm = upper @ elbow
        wrist = now.wrist @ turns[2]
        hand = forearm @ wrist
        # From each joint to the point.
        far = [np.zeros(3), np.zeros(3), hand @ now.point]
        far[1] = far[2] + forearm @ self.arm.lower
        far[0] = far[1] + upper @ self.arm.upper
        off = (now.shoulder + far[0] - self.goal) / self._length
        twist = _logarithm(self._kept.T @ hand)
        bent = self._rows @ elbow @ self._lower - self._allowed
        bent[1:] = np.minimum(bent[1:], 0.0)
        over = min(float(self._lower @ wrist @ self._hand) - self._allowed_bend, 0.0)
        value = self.weight * off @ off + ORIENTATION * twist @ twist
        value += NATURAL * (bent @ bent + over * over)
        # By a small turn of each joint in its own frame; then by the offsets.
        pull = 2.0 * self.weight / self._length * off
        torque = 2.0 * ORIENTATION * (hand @ twist)
        small = [
            frame.T @ (_cross(arm, pull) + torque)
            for frame, arm in zip((upper, forearm, hand), far, strict=True)
        ]
        small[1] = small[1] + 2.0 * NATURAL * _cross(self._lower, elbow.T @ self._rows.T @ bent)
        small[2] = small[2] + 2.0 * NATURAL * over * _cross(self._hand, wrist.T @ self._lower)
        slopes = [_right_jacobian(v).T @ d for v, d in zip(offsets, small, strict=True)]
        return float(value + SIZE @ (x * x)), np.concatenate(slopes) + 2.0 * SIZE * x


def _cross(a: Array, b: Array) -> Array:
    """Cross product of two vectors (3,); NumPy's costs many times as much for one pair."""
    x, y, z = a.tolist()
    u, v, w = b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def _skew(v: Array) -> Array:
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _exponential(v: Array) -> Array:
    """Rotation matrix of a rotation vector [rad]."""
    angle, cross = float(np.sqrt(v @ v)), _skew(v)
    if angle < 1e-6:
        return np.eye(3) + cross + 0.5 * cross @ cross
    half = np.sin(0.5 * angle) / (0.5 * angle)
    return np.eye(3) + np.sin(angle) / angle * cross + 0.5 * half * half * cross @ cross


def _logarithm(m: Array) -> Array:
    """Rotation vector [rad] of a rotation matrix."""
    cosine = 0.5 * (float(np.trace(m)) - 1.0)
    if cosine < -0.9:
        return rot.to_rotvec(rot.from_matrix(m))
    axis = 0.5 * np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    sine = float(np.sqrt(axis @ axis))
    return axis if sine < 1e-9 else axis * (np.arctan2(sine, cosine) / sine)


def _right_jacobian(v: Array) -> Array:
    """J with exp(v + d) = exp(v) exp(J d) for small d, (3, 3)."""
    angle, cross = float(np.sqrt(v @ v)), _skew(v)
    if angle < 1e-4:
        return np.eye(3) - 0.5 * cross + cross @ cross / 6.0
    return (
        np.eye(3)
        - (1.0 - np.cos(angle)) / angle**2 * cross
        + (angle - np.sin(angle)) / angle**3 * cross @ cross
    )
