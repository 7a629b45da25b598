"""A plain body for a clip that has none: a rod for every bone.

In: a skeleton. Out: a MuJoCo specification with the joint layout that characters have, so that a
clip alone can be drawn by everything that draws takes.
"""

from __future__ import annotations

import mujoco
import numpy as np

from understudy.motion import rotations as rot
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

_COLOR = (0.85, 0.55, 0.30, 1.0)
_SHORTEST = 1e-4  # m; shorter bones are not drawn


def bones(skeleton: Skeleton) -> list[tuple[int, Array]]:
    """The joint that carries each bone, and where the bone leads in that joint's frame [m], (3,).

    A bone leads to every child joint and every end site that is not at the joint itself. The root's
    own offset is a place in the world, not a bone.
    """
    out = [(p, skeleton.offsets[i]) for i, p in enumerate(skeleton.parents) if p >= 0]
    out += list(zip(skeleton.end_joints, skeleton.end_offsets, strict=True))
    return [(joint, tip) for joint, tip in out if np.linalg.norm(tip) > _SHORTEST]


def size_of(skeleton: Skeleton) -> float:
    """The longest extent of the rest pose [m], at least a millimeter."""
    rest = skeleton.rest_positions()
    tips = rest[list(skeleton.end_joints)] + skeleton.end_offsets
    every = np.concatenate((rest, tips))
    return max(float(np.ptp(every, axis=0).max()), 1e-3)


def spec_of(skeleton: Skeleton) -> mujoco.MjSpec:
    """Rods and a ground plane; joint number i of the skeleton is the ball joint `j{i}`.

    The root has the slide joints `root_x`, `root_y` and `root_z` before its ball joint.
    """
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(
        name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], rgba=[0.8, 0.8, 0.8, 1]
    )
    bodies = []
    for i, parent in enumerate(skeleton.parents):
        outer = spec.worldbody if parent < 0 else bodies[parent]
        body = outer.add_body(name=f"b{i}", pos=[0, 0, 0] if parent < 0 else skeleton.offsets[i])
        body.explicitinertial = True
        body.mass, body.inertia = 1.0, [0.01, 0.01, 0.01]
        if parent < 0:
            for axis, name in enumerate(("root_x", "root_y", "root_z")):
                body.add_joint(
                    name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=np.eye(3)[axis].tolist()
                )
        body.add_joint(name=f"j{i}", type=mujoco.mjtJoint.mjJNT_BALL)
        bodies.append(body)
    whole = size_of(skeleton)
    for joint, tip in bones(skeleton):
        length = float(np.linalg.norm(tip))
        bodies[joint].add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0, 0, 0, *tip],
            size=[float(np.clip(0.11 * length, 0.003 * whole, 0.022 * whole)), 0, 0],
            rgba=_COLOR,
            contype=0,
            conaffinity=0,
        )
    return spec


def octahedra(skeleton: Skeleton) -> tuple[Array, np.ndarray, np.ndarray]:
    """Bones as slim octahedra, in the rest pose.

    Returns:
        Corners of the triangles in the world [m], (n, 3); joint of each corner, (n,); triangles,
        counter-clockwise from outside, (n / 3, 3). A skeleton without bones gets one octahedron.
    """
    whole = size_of(skeleton)
    found = bones(skeleton) or [(0, np.array([0.0, 0.0, whole]))]
    rest = skeleton.rest_positions()
    waist = np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0]])
    points, joints, faces = [], [], []
    for number, (joint, tip) in enumerate(found):
        length = float(np.linalg.norm(tip))
        width = float(np.clip(0.12 * length, 0.004 * whole, 0.03 * whole))
        ring = waist * width + np.array([0.0, 0.0, 0.18 * length])
        along = np.concatenate((ring, [[0, 0, 0], [0, 0, length]]))
        turn = rot.shortest_arc(np.array([0.0, 0.0, 1.0]), tip)
        points.append(rest[joint] + rot.rotate(turn, along))
        joints += [joint] * 6
        for k in range(4):
            a, b = 6 * number + k, 6 * number + (k + 1) % 4
            faces += [(a, b, 6 * number + 5), (b, a, 6 * number + 4)]
    return np.concatenate(points), np.array(joints), np.array(faces)
