"""Small bodies whose mechanics is known in closed form, and takes of them."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np

from understudy.motion.clip import Clip
from understudy.motion.skeleton import Skeleton

STEP = 0.002


def body_spec(
    *,
    ground: bool = True,
    foot: bool = False,
    root_mass: float = 10.0,
    arm_mass: float = 3.0,
    hold: float = 0.0,
    servo: float = 0.0,
    pinned: bool = False,
    step: float = STEP,
    integrator: mujoco.mjtIntegrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    cone: mujoco.mjtCone = mujoco.mjtCone.mjCONE_PYRAMIDAL,
) -> mujoco.MjSpec:
    """A box (the root) with an arm on a ball joint, and a servo for every joint.

    The layout is a character's: three slides and a ball for the root, one ball per joint.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = step
    spec.option.integrator = integrator
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    spec.option.cone = cone
    if ground:
        spec.worldbody.add_geom(
            name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], solref=[0.01, 1]
        )
    # Armature resists motion and weighs nothing.
    root = spec.worldbody.add_body(name="pelvis")
    armature = 1e12 if pinned else 0.0
    for name, axis in (("x", [1, 0, 0]), ("y", [0, 1, 0]), ("z", [0, 0, 1])):
        root.add_joint(
            name=f"root_{name}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis, armature=armature
        )
    root.add_joint(name="pelvis", type=mujoco.mjtJoint.mjJNT_BALL, armature=armature)
    touching = {"contype": 0, "conaffinity": 0} if foot else {}
    root.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.15, 0.1, 0.05], mass=root_mass, **touching
    )
    if foot:
        arm = root.add_body(name="left_foot", pos=[0, 0, -0.1])
        arm.add_joint(name="left_ankle", type=mujoco.mjtJoint.mjJNT_BALL)
        arm.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.2, 0.1, 0.05], pos=[0, 0, -0.05], mass=arm_mass
        )
    else:
        arm = root.add_body(name="arm", pos=[0, 0, 0.05])
        arm.add_joint(name="shoulder", type=mujoco.mjtJoint.mjJNT_BALL)
        arm.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0, 0, 0.05, 0.1, 0.05, 0.5],
            size=[0.04, 0, 0],
            mass=arm_mass,
            contype=0,
            conaffinity=0,
        )
    joint = "left_ankle" if foot else "shoulder"
    quaternion = int(mujoco.mjtCtrlChart.mjCHART_QUAT)
    kind = mujoco.mjtTrn.mjTRN_JOINT
    spec.add_actuator(name=joint, target=joint, trntype=kind).set_to_orientation(
        kp=servo, kv=0.1 * servo, ctrlspec=quaternion
    )
    for name in ("root_x", "root_y", "root_z"):
        spec.add_actuator(name=name, target=name, trntype=kind).set_to_pid(kp=hold, kv=0.1 * hold)
    spec.add_actuator(name="root", target="pelvis", trntype=kind).set_to_orientation(
        kp=0.1 * hold, kv=0.01 * hold, ctrlspec=quaternion
    )
    return spec


def simulated(
    spec: mujoco.MjSpec,
    duration: float,
    *,
    qpos: Any = None,
    qvel: Any = None,
    control: Callable[[float, Any], None] | None = None,
    reference: Clip | None = None,
    foot: bool = False,
    **facts: Any,
) -> Any:
    """Run the body and record it the way a take does: one frame per step and the first state."""
    model = spec.compile()
    data = mujoco.MjData(model)
    if qpos is not None:
        data.qpos[: len(qpos)] = qpos
    if qvel is not None:
        data.qvel[: len(qvel)] = qvel
    rows: list[list[Any]] = [[], [], [], [], []]
    step = spec.option.timestep
    for k in range(round(duration / step) + 1):
        data.ctrl[:] = 0.0
        data.ctrl[0] = data.ctrl[10] = 1.0
        data.qfrc_applied[:], data.xfrc_applied[:] = 0.0, 0.0
        if control is not None:
            control(k * step, data)
        live = (data.qpos, data.qvel, data.ctrl, data.qfrc_applied, data.xfrc_applied)
        for row, now in zip(rows, live, strict=True):
            row.append(now.copy())
        mujoco.mj_step(model, data)
    second = "left_ankle" if foot else "shoulder"
    links = (
        SimpleNamespace(name="pelvis", joint="pelvis", role="pelvis", torque_limit=None),
        SimpleNamespace(
            name="left_foot" if foot else "arm",
            joint=second,
            role=second if foot else None,
            torque_limit=np.array([50.0, 100.0, 50.0]),
        ),
    )
    skeleton = Skeleton(
        names=("pelvis", second),
        parents=(-1, 0),
        offsets=np.array([[0, 0, 0.0], model.body_pos[2]]),
        end_joints=(1,),
        end_offsets=np.array([[0.1, 0.05, 0.5]]),
    )
    part = SimpleNamespace(
        bodies=(1, 2), qpos=slice(0, 11), dofs=slice(0, 9), root_actuators=(1, 2, 3, 4)
    )
    character = SimpleNamespace(
        name="box",
        links=links,
        skeleton=skeleton,
        height=1.5,
        local_rotations=lambda rows: rows[:, 3:].reshape(len(rows), -1, 4),
    )
    qpos_, qvel_, ctrl, applied, outside = (np.array(row) for row in rows)
    return SimpleNamespace(
        scene=SimpleNamespace(
            characters=(character,),
            parts=(part,),
            props=(),
            prefix=lambda character=0: "",
            ground=True if model.ngeom and model.geom_type[0] == 0 else None,
        ),
        model=model,
        performance=None,
        rate=1.0 / step,
        times=np.arange(len(qpos_)) * step,
        qpos=qpos_,
        qvel=qvel_,
        ctrl=ctrl,
        qfrc_applied=applied,
        xfrc_applied=outside,
        references=(reference,),
        captured=(None,),
        seed=7,
        diverged=None,
        duration=duration,
        frames=len(qpos_),
        facts=facts,
    )
