"""Servo gains from one overall stiffness.

Zordan & Hodgins 1999, section 3: each joint's gain is the character's overall stiffness times the
moment of inertia of what the joint moves; damping is one tenth of the gain. A leg that stands
carries the body above it, which its own outboard inertia does not say, so legs get at least what
standing needs.
"""

from __future__ import annotations

import mujoco
import numpy as np

from understudy.motion.rotations import Array
from understudy.scene import Part, Scene

# Least stiffness of a leg over ground [N m/rad] for 70 kg and 1.75 m. An ankle must exceed m g h of
# the body above it, 600 to 700 N m/rad, or the body topples over it (Loram & Lakie 2002 measure
# 91 % of it in quiet standing); twice that keeps stance legs within 2 degrees of a captured walk.
STANCE_STIFFNESS = {"hip": 1600.0, "knee": 1600.0, "ankle": 1200.0, "ball": 300.0}
# Damping over stiffness of those legs [s]. A foot is light: more makes a landing foot a hammer.
STANCE_DAMPING_TIME = 0.01
STANCE_REFERENCE = 70.0 * 9.81 * 1.75
# Soft servos [N m/rad], for 70 kg and 1.75 m, and their damping over stiffness [s]: a body that
# nothing holds gives way where it meets the floor, and what its servos do not hold a guidance does.
SOFT_STIFFNESS = {
    "lower_back": 1000.0,
    "upper_back": 800.0,
    "neck": 60.0,
    "shoulder": 150.0,
    "elbow": 80.0,
    "wrist": 8.0,
    "hip": 800.0,
    "knee": 800.0,
    "ankle": 600.0,
    "ball": 60.0,
}
SOFT_DAMPING_TIME = 0.04
# Rotor inertia of soft servos [kg m^2]: a foot or hand whose servo is at its limit has no damping,
# and with less rings at steps of some milliseconds.
SOFT_ARMATURE = 0.005
# Damping of a joint without a servo over the inertia outboard of it [1/s]: a hanging arm, whose
# swing has about 5 rad/s, loses nearly half of its amplitude in one period.
LIMP_DAMPING = 1.0
# Where a joint stops [deg from neutral] for which the character has no published limit: round
# figures of our own, no tighter than people's.
WEAK_STOPS = {"knee": 150.0, "ankle": 60.0, "ball": 60.0}
# Least stiffness of a locked joint over the inertia outboard of it [1/s^2], and over what its
# servo had; its damping is critical.
LOCKED_STIFFNESS, LOCKED_OVER_SERVO = 3e4, 40.0


def outboard_inertia(model: mujoco.MjModel, part: Part) -> Array:
    """Moment of inertia of everything outboard of each joint [kg m^2], mean of the three axes.

    Measured about the joint in the model's reference pose; shape (links,), the root's first.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    diagonal = np.diag(mass)[part.dofs][3:] - model.dof_armature[part.dofs][3:]
    return diagonal.reshape(-1, 3).mean(axis=1)


def joint_stiffness(scene: Scene, model: mujoco.MjModel, character: int, stiffness: float) -> Array:
    """Gain of every joint but the root [N m/rad], shape (links - 1,).

    `stiffness` is the overall stiffness [1/s^2]. With ground in the scene the legs get at least
    `STANCE_STIFFNESS`, scaled by the body's mass, height and gravity.
    """
    part, body = scene.parts[character], scene.characters[character]
    gains = stiffness * outboard_inertia(model, part)[1:]
    load = body.mass * abs(scene.gravity) * body.height / STANCE_REFERENCE
    least = [STANCE_STIFFNESS.get(joint, 0.0) * load for joint in stance_joints(scene, character)]
    return np.maximum(gains, least)


def soft_stiffness(scene: Scene, model: mujoco.MjModel, character: int, stiffness: float) -> Array:
    """Gain of every joint but the root where servos are soft [N m/rad], shape (links - 1,).

    Joints that people do not have get `stiffness` [1/s^2] times the inertia outboard of them.
    """
    part, body = scene.parts[character], scene.characters[character]
    load = body.mass * abs(scene.gravity) * body.height / STANCE_REFERENCE
    out = stiffness * outboard_inertia(model, part)[1:]
    for j, link in enumerate(body.links[1:]):
        role = link.role or ""
        soft = SOFT_STIFFNESS.get(role, SOFT_STIFFNESS.get(role.partition("_")[2]))
        if soft is not None:
            out[j] = soft * load
    return out


def stance_joints(scene: Scene, character: int) -> list[str]:
    """For every joint but the root "hip", "knee", "ankle" or "ball" if it stands, else ""."""
    links = scene.characters[character].links[1:]
    if scene.ground is None:
        return [""] * len(links)
    kinds = [(link.role or "").partition("_")[2] for link in links]
    return [kind if kind in STANCE_STIFFNESS else "" for kind in kinds]


def set_orientation_gain(model: mujoco.MjModel, actuator: int, k: float, kd: float) -> None:
    """Write stiffness k [N m/rad] and damping kd [N m s/rad] into an orientation servo."""
    model.actuator_gainprm[actuator, 0] = k
    model.actuator_biasprm[actuator, 1:3] = -k, -kd


def set_position_gain(model: mujoco.MjModel, actuator: int, k: float, kd: float) -> None:
    """Write stiffness k [N/m] and damping kd [N s/m] into a position and velocity servo."""
    model.actuator_biasprm[actuator, 1:3] = -k, -kd
