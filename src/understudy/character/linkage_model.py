"""A linkage as a MuJoCo model.

The bodies stand in the rest pose, so that the engine derives the anchors of its constraints from
poses in which the joints meet.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from understudy.character.body import SelfCollision
from understudy.character.linkage import Linkage, Lock
from understudy.character.model import GROUND_BIT
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    import mujoco

# The engine takes no time constant below two steps, so this asks for exactly two.
_SOLREF = (1e-5, 1.0)
# Lever of the constraints that lock single axes [m]: about the length of a bone.
_LEVER = 0.2
_LEFT, _RIGHT, _MIDDLE = (0.30, 0.50, 0.78, 1.0), (0.83, 0.45, 0.30, 1.0), (0.62, 0.62, 0.60, 1.0)


def spec(linkage: Linkage, *, self_collision: SelfCollision = "off") -> mujoco.MjSpec:
    """A fresh model of the bodies alone, in the rest pose: no ground, no light, no actuator.

    Raises:
        InvalidValue: Self-collision is asked for, which linkages do not have.
    """
    import mujoco

    if self_collision != "off":
        raise InvalidValue(f"self_collision is {self_collision!r}; a linkage has 'off' only.")
    out = mujoco.MjSpec()
    out.modelname = linkage.name
    out.compiler.degree = False
    out.compiler.boundmass = 0.0
    out.compiler.boundinertia = 0.0
    # As characters', so that the two can be attached to one another; a scene sets its own.
    out.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    out.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    rest = linkage.skeleton.rest_positions()[None]
    placed, turned = linkage.placed(rest, rot.identity(1, len(linkage)))
    bodies: dict[int, mujoco.MjsBody] = {}
    for j in linkage.order:
        name, parent = linkage.names[j], linkage.skeleton.parents[j]
        if linkage.kind == "tree" and parent >= 0:
            hinge = linkage.ends[parent] - rot.rotate(linkage.relative[j], linkage.anchors[j])
            body = bodies[parent].add_body(name=name, pos=hinge, quat=linkage.relative[j])
            body.add_joint(
                name=name,
                type=mujoco.mjtJoint.mjJNT_BALL,
                pos=linkage.anchors[j],
                damping=[0.0] * 3,
            )
        else:
            body = out.worldbody.add_body(name=name, pos=placed[0, j], quat=turned[0, j])
            body.add_freejoint(name=name)
        body.explicitinertial = True
        body.mass, body.inertia = linkage.masses[j], linkage.inertias[j]
        body.ipos, body.iquat = np.zeros(3), rot.identity()
        _add_shape(linkage, body, j)
        bodies[j] = body
    if linkage.kind == "constrained":
        for j, p in enumerate(linkage.skeleton.parents[1:], 1):
            _add_point(out, linkage, j, p)
    for lock in linkage.locks:
        joint = linkage.skeleton.index(lock.joint)
        for j in linkage.skeleton.children(joint):
            if len(lock.axes) == 3:
                _add_weld(out, linkage, lock, j, joint)
            else:
                _add_axes(out, linkage, lock, (j, joint), (bodies[j], bodies[joint]))
    return out


def equality_names(linkage: Linkage) -> tuple[str, ...]:
    """Names of its constraints in the model, without a scene's prefix."""
    return tuple(equality.name for equality in spec(linkage).equalities)


def _add_shape(linkage: Linkage, body: mujoco.MjsBody, j: int) -> None:
    import mujoco

    length, name = linkage.lengths[j], linkage.names[j]
    kinds = mujoco.mjtGeom
    geom = body.add_geom(name=name, type=kinds.mjGEOM_CAPSULE if length else kinds.mjGEOM_SPHERE)
    geom.size = (linkage.radii[j], 0.5 * length, 0.0)
    geom.contype, geom.conaffinity = 0, GROUND_BIT if linkage.contact else 0
    geom.density = 0.0
    side = name.lower()
    left = side.startswith(("left", "l_", "l-", "lhip", "lthumb"))
    right = side.startswith(("right", "r_", "r-", "rhip", "rthumb"))
    geom.rgba = _LEFT if left else _RIGHT if right else _MIDDLE


def _solimp(linkage: Linkage) -> tuple[float, ...]:
    """The engine's default impedance, with its width of 0.001 in the clip's unit."""
    return (0.9, 0.95, 0.001 * linkage.unit, 0.5, 2.0)


def _solimp_of_lock(linkage: Linkage) -> tuple[float, ...]:
    """Near-rigid: a lock stands against the drive, which a point constraint need not."""
    return (0.9999, 0.9999, 0.001 * linkage.unit, 0.5, 2.0)


def _add_point(out: mujoco.MjSpec, linkage: Linkage, j: int, p: int) -> None:
    """A point-to-point constraint at the parent joint of body j."""
    import mujoco

    point = out.add_equality(
        name=linkage.names[j],
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=linkage.names[p],
        name2=linkage.names[j],
    )
    point.data[:3] = linkage.ends[p]
    point.solref[:], point.solimp[:] = _SOLREF, _solimp(linkage)


def _add_weld(out: mujoco.MjSpec, linkage: Linkage, lock: Lock, j: int, p: int) -> None:
    """All rotations locked: body j keeps its pose relative to body p."""
    import mujoco

    weld = out.add_equality(
        name=f"{lock.joint}:{linkage.names[j]}",
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=linkage.names[p],
        name2=linkage.names[j],
    )
    turn = _locked_orientation(linkage, lock, j)
    # The engine takes these as they are: the point in body 2, in body 1, and the orientation.
    weld.data[0:3], weld.data[3:6] = linkage.anchors[j], linkage.ends[p]
    weld.data[6:10] = turn
    weld.data[10] = 1.0
    weld.solref[:], weld.solimp[:] = _SOLREF, _solimp_of_lock(linkage)


def _locked_orientation(linkage: Linkage, lock: Lock, j: int) -> Array:
    """Orientation of body j in the frame of its parent body where the joint is locked."""
    p = linkage.skeleton.parents[j]
    turn = rot.identity() if p == 0 else lock.rotation
    inward = rot.conjugate(linkage.alignments[p])
    return rot.multiply(inward, rot.multiply(turn, linkage.alignments[j]))


def _add_axes(
    out: mujoco.MjSpec,
    linkage: Linkage,
    lock: Lock,
    which: tuple[int, int],
    bodies: tuple[mujoco.MjsBody, mujoco.MjsBody],
) -> None:
    """One or two rotations locked, each by two directions that stay at right angles.

    A direction fixed to the parent and one fixed to the body are at right angles as long as the
    body does not turn about their normal. The distance between points at the lever's length along
    them is then constant, which is a constraint on the length of a tendon.
    """
    import mujoco

    j, p = which
    name = f"{lock.joint}:{linkage.names[j]}"
    if len(lock.axes) == 1:
        k = "xyz".index(lock.axes)
        pairs = [((k + 1) % 3, (k + 2) % 3)]
    else:
        (free,) = set(range(3)) - {"xyz".index(axis) for axis in lock.axes}
        pairs = [(free, k) for k in range(3) if k != free]
    outward = rot.conjugate(linkage.alignments[j])
    inward = rot.conjugate(linkage.alignments[p])
    turn = rot.identity() if p == 0 else lock.rotation
    for n, (of_parent, of_body) in enumerate(pairs):
        # Axes of the joint where it is locked, in each body's frame.
        a = rot.rotate(inward, rot.rotate(turn, np.eye(3)[of_parent]))
        b = rot.rotate(outward, np.eye(3)[of_body])
        sites = [f"{name}:{n}:parent", f"{name}:{n}:body"]
        bodies[1].add_site(name=sites[0], pos=linkage.ends[p] + _LEVER * a, group=5)
        bodies[0].add_site(name=sites[1], pos=linkage.anchors[j] + _LEVER * b, group=5)
        tendon = out.add_tendon(name=f"{name}:{n}", group=5)
        for site in sites:
            tendon.wrap_site(site)
        rest = rot.rotate(inward, np.eye(3)[of_body])
        length = _LEVER * float(np.linalg.norm(a - rest))
        equality = out.add_equality(
            name=f"{name}:{n}",
            type=mujoco.mjtEq.mjEQ_TENDON,
            objtype=mujoco.mjtObj.mjOBJ_TENDON,
            name1=f"{name}:{n}",
        )
        equality.data[:5] = 0.0
        equality.data[0] = np.sqrt(2.0) * _LEVER - length
        equality.solref[:], equality.solimp[:] = _SOLREF, _solimp_of_lock(linkage)
