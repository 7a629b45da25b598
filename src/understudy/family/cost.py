"""What a variation cost: change of force and torque joint by joint (Wilke & Semwal 2017, Table 3).

The paper gives the mean squared change of the force and torque on each body. For an articulated
body the force is the one that passes through the joint and the torque its servo's.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from understudy.evaluate.measure import Measured, measured
from understudy.motion.rotations import Array
from understudy.take import Take

RATE = 30.0  # Hz


@dataclass(frozen=True, kw_only=True, eq=False)
class Effort:
    """Force and torque of every joint of one character, the root's (help from outside) first.

    Attributes:
        joints: Names.
        times: Time over the whole planned duration, 0 to 1, shape (frames,).
        force: Force through the joint [N], world, shape (frames, joints, 3).
        torque: Servo torque [N m], outboard frame, shape (frames, joints, 3).
    """

    joints: tuple[str, ...]
    times: Array = field(repr=False)
    force: Array = field(repr=False)
    torque: Array = field(repr=False)


def effort(take: Take, planned: float, m: Measured | None = None, character: int = 0) -> Effort:
    """Force and torque at the joints of one character of a take.

    Args:
        take: The take.
        planned: How long it was to be [s]; one that diverged is shorter.
        m: What `measured(take, rate=RATE)` gave.
        character: Which character.
    """
    m = measured(take, rate=RATE) if m is None else m
    who, model = m.performer(character), take.model
    data = mujoco.MjData(model)
    bodies = list(who.bodies)
    force = np.empty((m.frames, len(bodies), 3))
    for f, step in enumerate(m.steps):
        data.qpos[:], data.qvel[:] = take.qpos[step], take.qvel[step]
        data.ctrl[:], data.qfrc_applied[:] = take.ctrl[step], take.qfrc_applied[step]
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        force[f] = data.cfrc_int[bodies, 3:]
    force[:, 0] = m.root_force(character)
    torque = np.concatenate((m.root_torque(character)[:, None], m.joint_torques(character)), axis=1)
    times = m.times / planned if planned > 0 else np.zeros(m.frames)
    return Effort(joints=who.joints, times=times, force=force, torque=torque)


def changed(before: Effort, after: Effort) -> dict[str, dict[str, float]]:
    """The paper's Table 3: per joint, mean squared change, and root mean squares as a ratio.

    A performance of another speed is compared at the same share of its duration.
    """
    rows: dict[str, dict[str, float]] = {}
    at = np.clip(np.searchsorted(before.times, after.times - 1e-9), 0, len(before.times) - 1)
    for j, joint in enumerate(after.joints):
        row: dict[str, float] = {}
        for name, unit in (("force", "n"), ("torque", "nm")):
            old, new = getattr(before, name)[at, j], getattr(after, name)[:, j]
            row[f"{name}_change_{unit}2"] = float(((new - old) ** 2).sum(axis=1).mean())
            usual = float(np.sqrt((old**2).sum(axis=1).mean()))
            now = float(np.sqrt((new**2).sum(axis=1).mean()))
            row[f"{name}_rms_{unit}"] = now
            row[f"{name}_rms_unvaried_{unit}"] = usual
        rows[joint] = row
    return rows


def total(cost: dict[str, dict[str, float]]) -> dict[str, Any]:
    """Sums over the joints but the root: how much more or less torque, and where most changed."""
    joints = list(cost)[1:] or list(cost)
    now = np.sqrt(sum(cost[j]["torque_rms_nm"] ** 2 for j in joints))
    usual = np.sqrt(sum(cost[j]["torque_rms_unvaried_nm"] ** 2 for j in joints))
    most = max(joints, key=lambda j: cost[j]["torque_change_nm2"])
    return {
        "torque_ratio": float(now / usual) if usual > 0 else None,
        "torque_change_nm2": float(sum(cost[j]["torque_change_nm2"] for j in joints)),
        "force_change_n2": float(sum(cost[j]["force_change_n2"] for j in joints)),
        "most_changed": most,
    }
