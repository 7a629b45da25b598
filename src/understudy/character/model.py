"""A character as a MuJoCo model.

The root's three slides carry its world position and its ball joint the world orientation, so that
qpos is the root position followed by one quaternion (wxyz) per link in link order, and qvel the
root's linear velocity followed by one angular velocity per link in the link's own frame. Every
actuator is present with zero gains; a controller sets them in the compiled model.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from understudy.character.body import Character, Limits, Link, SelfCollision, Shape
from understudy.errors import InvalidValue

if TYPE_CHECKING:
    import mujoco

ROOT_AXES = ("root_x", "root_y", "root_z")
# Rotor inertia of every joint [kg m2] and mass of every slide [kg]: far below the lightest link's,
# enough to keep a torque-limited joint from ringing at the step size of a simulation.
ARMATURE = 1e-4
# Geom groups 0 to 2 are drawn by default, 3 to 5 are not.
_VISIBLE, _HIDDEN = 0, 3
# Collision bits: 1 is the ground and props. Shapes that touch it carry it as their affinity only,
# so that two characters' feet do not touch each other by it.
GROUND_BIT = 1
_SOLREF = (0.01, 1.0)
_FRICTION = (1.0, 0.005, 0.0001)


def spec(
    character: Character, *, self_collision: SelfCollision = "off", limits: Limits = "off"
) -> mujoco.MjSpec:
    """A fresh model of the body alone: no ground, no light.

    Args:
        character: The body.
        self_collision: "pairs" lets the character's listed pairs of links touch.
        limits: "on" gives joints their `motion_limit` as a stop.

    Raises:
        InvalidValue: Another choice.
    """
    import mujoco

    if self_collision not in ("off", "pairs"):
        raise InvalidValue(f"self_collision is {self_collision!r}; it must be 'off' or 'pairs'.")
    if limits not in ("off", "on"):
        raise InvalidValue(f"limits is {limits!r}; it must be 'off' or 'on'.")
    out = mujoco.MjSpec()
    out.modelname = character.name
    out.compiler.degree = False
    out.compiler.boundmass = 0.0
    out.compiler.boundinertia = 0.0
    out.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    out.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    bodies = []
    for link in character.links:
        parent = out.worldbody if link.parent < 0 else bodies[link.parent]
        bodies.append(_add_link(out, parent, link, limits))
    _add_sites(character, bodies)
    for link in character.links[1:]:
        _add_servo(out, link.joint, link.joint)
    for axis in ROOT_AXES:
        servo = out.add_actuator(name=axis, target=axis)
        servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
        servo.set_to_pid(kp=0.0, kv=0.0)
    _add_servo(out, "root", character.links[0].joint)
    if self_collision == "pairs":
        _add_pairs(out, character)
    return out


def _add_link(
    out: mujoco.MjSpec, parent: mujoco.MjsBody, link: Link, limits: Limits
) -> mujoco.MjsBody:
    import mujoco

    root = link.parent < 0
    body = parent.add_body(name=link.name, pos=np.zeros(3) if root else link.offset)
    if root:
        for k, axis in enumerate(ROOT_AXES):
            body.add_joint(
                name=axis,
                type=mujoco.mjtJoint.mjJNT_SLIDE,
                axis=np.eye(3)[k],
                limited=mujoco.mjtLimited.mjLIMITED_FALSE,
            )
    joint = body.add_joint(name=link.joint, type=mujoco.mjtJoint.mjJNT_BALL)
    joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    if not root:
        joint.armature = ARMATURE
        if limits == "on" and link.motion_limit is not None:
            joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            joint.range = (0.0, link.motion_limit)
    body.explicitinertial = True
    body.mass = link.mass
    body.ipos = link.com
    i = link.inertia
    body.fullinertia = (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])
    soled = any(shape.contact for shape in link.shapes)
    for k, shape in enumerate(link.shapes):
        geom = add_shape(out, body, f"{link.name}_{k}", shape)
        if shape.use == "collision" and not soled:
            # Trunk, limbs and head lie on the ground with the shapes they touch each other with.
            geom.conaffinity = GROUND_BIT
    return body


def add_shape(out: mujoco.MjSpec, body: mujoco.MjsBody, name: str, shape: Shape) -> mujoco.MjsGeom:
    """One shape as a geom of a body."""
    import mujoco

    kinds = {
        "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
        "box": mujoco.mjtGeom.mjGEOM_BOX,
        "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
        "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        "mesh": mujoco.mjtGeom.mjGEOM_MESH,
    }
    geom = body.add_geom(name=name, type=kinds[shape.kind], pos=shape.position)
    geom.quat = shape.rotation
    if shape.kind == "mesh":
        mesh = out.add_mesh(name=name)
        mesh.uservert = shape.vertices.ravel()
        mesh.userface = shape.faces.ravel().astype(np.int32)
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT
        mesh.needsdf = False
        geom.meshname = name
    else:
        geom.size = shape.size
    geom.density = shape.density
    geom.rgba = shape.rgba
    geom.group = _VISIBLE if shape.use == "visible" else _HIDDEN
    geom.contype = 0
    geom.conaffinity = GROUND_BIT if shape.contact else 0
    geom.condim = 3
    geom.friction = _FRICTION
    geom.solref[:2] = _SOLREF
    return geom


def _add_servo(out: mujoco.MjSpec, name: str, joint: str) -> None:
    import mujoco

    servo = out.add_actuator(name=name, target=joint)
    servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
    servo.set_to_orientation(kp=0.0, kv=0.0, ctrlspec=int(mujoco.mjtCtrlChart.mjCHART_QUAT))


def _add_sites(character: Character, bodies: list[mujoco.MjsBody]) -> None:
    """Soles below the ankles and palms half way along the hands."""
    for link, body in zip(character.links, bodies, strict=True):
        side, _, kind = (link.role or "").partition("_")
        if kind == "ankle":
            body.add_site(name=f"{side}_sole", pos=(0.0, 0.0, character.sole_height))
        if kind == "wrist":
            reach = 0.05 * character.height
            body.add_site(name=f"{side}_palm", pos=(0.0, reach if side == "left" else -reach, 0.0))


def _add_pairs(out: mujoco.MjSpec, character: Character) -> None:
    """Contact pairs between the shapes kept for collisions of the listed links."""
    names = {
        link.name: [f"{link.name}_{k}" for k, s in enumerate(link.shapes) if s.use == "collision"]
        for link in character.links
    }
    for a, b in character.self_collisions:
        for one in names[a]:
            for two in names[b]:
                out.add_pair(name=f"{one}-{two}", geomname1=one, geomname2=two)
