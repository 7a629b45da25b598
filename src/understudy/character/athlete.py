"""The athlete's body: a person whose joints are hinges, each with a motor of human strength.

Hodgins et al. 1995 give their runner 17 segments and 30 controlled degrees of freedom, chosen "so
that each behavior can be completed in a natural-looking fashion": three at waist, neck, shoulders
and hips, two at the wrists, one at elbows, knees, ankles and the balls of the feet.

Segment masses, centers and inertias are those of a `Character` (de Leva 1996). The root has a free
joint; at zero every hinge stands as in quiet standing, arms hanging. Local rotations of a clip come
from the hinge angles, so what an athlete does is a clip on the same skeleton a character has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from understudy.character.bodies import adult_man, adult_woman
from understudy.character.body import Character, Limits, Link, SelfCollision
from understudy.character.model import add_shape
from understudy.character.strength import joint_kind, torque_limits
from understudy.errors import InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    import mujoco


@dataclass(frozen=True, kw_only=True)
class Hinge:
    """One degree of freedom.

    Attributes:
        axis: Direction at zero in the neutral standing pose, x forward, y left, z up.
        limits: Least and greatest angle [rad].
        damping: Of the tissue around it [N m s/rad].
        armature: Rotor inertia that keeps it from ringing [kg m2].
    """

    axis: tuple[float, float, float]
    limits: tuple[float, float]
    damping: float = 0.0
    armature: float = 0.01


_X, _Y, _Z, _BACK = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)

# Positive turns: flexion of hip, shoulder and elbow and dorsiflexion (about -y), flexion of the
# knee and forward lean of waist and neck (about +y). The leg's order (x, then y, then z) gives its
# inverse kinematics in closed form (`control.legs`).
HINGES: dict[str, tuple[Hinge, ...]] = {
    "back": (
        Hinge(axis=_X, limits=(-0.6, 0.6), damping=30.0),
        Hinge(axis=_Y, limits=(-0.8, 1.2), damping=30.0),
        Hinge(axis=_Z, limits=(-0.8, 0.8), damping=20.0),
    ),
    "neck": (
        Hinge(axis=_X, limits=(-0.7, 0.7), damping=3.0),
        Hinge(axis=_Y, limits=(-0.8, 0.8), damping=3.0),
        Hinge(axis=_Z, limits=(-1.2, 1.2), damping=2.0),
    ),
    "shoulder": (
        Hinge(axis=_BACK, limits=(-1.4, 3.0), damping=2.0),
        Hinge(axis=_X, limits=(-1.8, 1.8), damping=2.0),
        Hinge(axis=_Z, limits=(-1.4, 1.4), damping=1.0),
    ),
    "elbow": (Hinge(axis=_BACK, limits=(0.0, 2.6), damping=1.0),),
    "wrist": (
        Hinge(axis=_X, limits=(-1.2, 1.2), damping=0.2, armature=0.002),
        Hinge(axis=_BACK, limits=(-0.6, 0.6), damping=0.2, armature=0.002),
    ),
    "hip": (
        Hinge(axis=_X, limits=(-0.8, 0.8)),
        Hinge(axis=_BACK, limits=(-1.2, 2.2)),
        Hinge(axis=_Z, limits=(-0.8, 0.8)),
    ),
    "knee": (Hinge(axis=_Y, limits=(0.0, 2.6)),),
    "ankle": (Hinge(axis=_BACK, limits=(-1.0, 0.8)),),
    "ball": (Hinge(axis=_BACK, limits=(-0.3, 1.0), damping=0.6, armature=0.003),),
}

# A stretched muscle gives more than the isometric maximum of `strength`, and dynamometers
# understate one leg's: runners show 3 N m/kg at the ankle where Anderson's men reach 1.7. The
# factors are a judgment, the ankle's from that ratio.
IN_MOTION = {"ankle": 2.0, "hip": 1.5, "knee": 1.5, "ball": 1.5}

# Contact spheres of a foot over stature: place forward and sideways in the link, radius, and time
# constant of the contact [s]. The heel's is the pad under it: a rigid one gives a spike.
_HEEL, _BALL, _TOES = 0.0143, 0.0143, 0.0103
_PAD, _SOLE = 0.025, 0.012
# Sole geoms are felt at this weight against the ground's own time constant (`Ground`).
_OWN = 1000.0
# Touch sensors of one foot, in order.
TOUCHES = ("heel", "ball", "toes")


@dataclass(frozen=True, kw_only=True)
class Athlete(Character):
    """A person of 17 links and 30 hinges with motors; see the module.

    Made by `athlete_man` and `athlete_woman`. It takes no clips: `Tracking` needs ball joints.
    """

    @cached_property
    def rests(self) -> Array:
        """Local rotation of every link where its hinges are at zero, wxyz, shape (links, 4)."""
        out = rot.identity(len(self.links))
        half = np.sqrt(0.5)
        for i, link in enumerate(self.links):
            if (link.role or "").endswith("_shoulder"):
                out[i] = (half, -half if link.role == "left_shoulder" else half, 0.0, 0.0)
        return out

    @cached_property
    def hinges(self) -> tuple[tuple[Hinge, ...], ...]:
        """Hinges of every link, in link order; the root has none."""
        return tuple(() if i == 0 else HINGES[joint_kind(link.role or "")] for i, link in self._all)

    @property
    def controlled_dof(self) -> int:
        """Hinges, each with a motor of its own."""
        return sum(len(own) for own in self.hinges)

    @property
    def widths(self) -> tuple[int, int]:
        """How many numbers qpos and qvel hold for it."""
        return 7 + self.controlled_dof, 6 + self.controlled_dof

    def first_hinge(self, role: str) -> int:
        """Number of a joint's first hinge among all hinges.

        Raises:
            UnknownName: No joint has that role.
        """
        count = 0
        for (_, link), own in zip(self._all, self.hinges, strict=True):
            if link.role == role:
                return count
            count += len(own)
        raise UnknownName("joint", role, [link.role or "" for link in self.links])

    @cached_property
    def axes(self) -> tuple[Array, ...]:
        """Axes of every link's hinges in its own frame, each (hinges, 3)."""
        out, turned = [], rot.identity(len(self.links))
        for i, link in self._all:
            inboard = turned[link.parent] if i else rot.identity()
            turned[i] = rot.multiply(inboard, self.rests[i])
            given = np.array([hinge.axis for hinge in self.hinges[i]]).reshape(-1, 3)
            out.append(rot.rotate(rot.conjugate(turned[i]), given))
        return tuple(out)

    @cached_property
    def hinge_axes(self) -> Array:
        """Axis of every hinge at its joint, zero elsewhere, shape (hinges, joints, 3)."""
        out = np.zeros((self.controlled_dof, len(self.links) - 1, 3))
        number = 0
        for i, axes in enumerate(self.axes):
            for axis in axes:
                out[number, i - 1] = axis
                number += 1
        return out

    def torque_range(self, link: int, hinge: int) -> tuple[float, float]:
        """Least and greatest torque of a hinge [N m]: `strength`, times `IN_MOTION`."""
        role = self.links[link].role or ""
        limits = torque_limits(role, sex=self.sex, mass=self.mass, height=self.height)
        limits = limits * IN_MOTION.get(joint_kind(role), 1.0)
        axis = self.axes[link][hinge]
        along = int(np.argmax(np.abs(axis)))
        low, high = limits[along]
        return (-low, high) if axis[along] > 0 else (-high, low)

    def local_rotations(self, coordinates: Array) -> Array:
        """Local joint rotations from engine coordinates, the root's pose and 30 angles a row."""
        out = np.tile(self.rests, (len(coordinates), 1, 1))
        out[:, 0] = coordinates[:, 3:7]
        column = 7
        for i, axes in enumerate(self.axes):
            for axis in axes:
                turn = rot.from_rotvec(coordinates[:, column, None] * axis)
                out[:, i] = rot.multiply(out[:, i], turn)
                column += 1
        return out

    @property
    def _all(self) -> list[tuple[int, Link]]:
        return list(enumerate(self.links))

    def spec(
        self, *, self_collision: SelfCollision = "off", limits: Limits = "on"
    ) -> mujoco.MjSpec:
        """A fresh MuJoCo model of the body alone, with a motor per hinge and touch sensors.

        Raises:
            InvalidValue: Self-collision, which an athlete does not have.
        """
        import mujoco

        if self_collision != "off":
            raise InvalidValue("An athlete's links do not touch each other; use 'off'.")
        out = mujoco.MjSpec()
        out.modelname = self.name
        out.compiler.degree = False
        out.compiler.boundmass = 0.0
        out.compiler.boundinertia = 0.0
        out.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        out.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        out.option.iterations = 20
        bodies: list[mujoco.MjsBody] = []
        for i, link in self._all:
            parent = out.worldbody if i == 0 else bodies[link.parent]
            bodies.append(self._add_link(out, parent, i))
        for i, names in enumerate(self.hinge_names):
            for k, name in enumerate(names):
                motor = out.add_actuator(name=name, target=name)
                motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
                motor.set_to_motor()
                motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
                motor.forcerange = self.torque_range(i, k)
        for side in ("left", "right"):
            for part in TOUCHES:
                out.add_sensor(
                    name=f"{side}_{part}",
                    type=mujoco.mjtSensor.mjSENS_TOUCH,
                    objtype=mujoco.mjtObj.mjOBJ_SITE,
                    objname=f"{side}_{part}",
                )
        out.add_sensor(
            name="velocity",
            type=mujoco.mjtSensor.mjSENS_SUBTREELINVEL,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            objname=self.links[0].name,
        )
        return out

    @cached_property
    def hinge_names(self) -> tuple[tuple[str, ...], ...]:
        """Names of every link's hinges: its joint's, with the axis where there are several."""
        out = []
        for (_, link), own in zip(self._all, self.hinges, strict=True):
            letters = ["xyz"[int(np.argmax(np.abs(hinge.axis)))] for hinge in own]
            several = len(own) > 1
            out.append(tuple(f"{link.joint}_{a}" if several else link.joint for a in letters))
        return tuple(out)

    def _add_link(self, out: mujoco.MjSpec, parent: mujoco.MjsBody, i: int) -> mujoco.MjsBody:
        import mujoco

        link = self.links[i]
        body = parent.add_body(name=link.name, pos=link.offset, quat=self.rests[i])
        if i == 0:
            body.add_freejoint(name=link.joint)
        for hinge, axis, name in zip(
            self.hinges[i], self.axes[i], self.hinge_names[i], strict=True
        ):
            joint = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
            joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            joint.range = hinge.limits
            joint.solref_limit[:2] = (0.02, 1.0)
            joint.armature = hinge.armature
            joint.damping[0] = hinge.damping
        body.explicitinertial = True
        body.mass = link.mass
        body.ipos = link.com
        t = link.inertia
        body.fullinertia = (t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2])
        for k, shape in enumerate(link.shapes):
            if shape.use == "visible":
                add_shape(out, body, f"{link.name}_{k}", shape)
        side, _, kind = (link.role or "").partition("_")
        if kind == "ankle":
            heel = -0.25 * 0.152 * self.height + _HEEL * self.height
            self._add_pad(body, f"{side}_heel", (heel, 0.011), _HEEL, self.sole_height, _PAD)
            ball = 0.45 * 0.152 * self.height
            self._add_pad(body, f"{side}_ball", (ball, 0.020), _BALL, self.sole_height, _SOLE)
        if kind == "ball":
            tip = float(link.ends[0, 0]) - _TOES * self.height
            low = self.sole_height - float(link.offset[2])
            self._add_pad(body, f"{side}_toes", (tip, 0.014), _TOES, low, _SOLE)
        return body

    def _add_pad(
        self,
        body: mujoco.MjsBody,
        name: str,
        place: tuple[float, float],
        radius: float,
        low: float,
        time: float,
    ) -> None:
        """Two spheres side by side whose lowest points are at `low` [m], and a touch sensor's site.

        Args:
            body: The foot or the toes.
            name: Of the site; the spheres' have a number behind it.
            place: Forward [m], and half the distance sideways over stature.
            radius: Over stature.
            low: Height of the sole in the link [m].
            time: Time constant of the contact [s].
        """
        import mujoco

        r, half = radius * self.height, place[1] * self.height
        for k, y in enumerate((half, -half)):
            ball = body.add_geom(
                name=f"{name}_pad{k}",
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[r, 0.0, 0.0],
                pos=[place[0], y, low + r],
                contype=0,
                conaffinity=1,
                condim=3,
                mass=0.0,
                group=3,
            )
            # The ground's friction holds (the greater of the two), the sole's own give.
            ball.priority = 1
            ball.friction = [0.0, 0.005, 0.0001]
            ball.solref[:2] = (time, 0.9)
            ball.solmix = _OWN
        body.add_site(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=[place[0], 0.0, low + 0.5 * r],
            size=[1.6 * r, half + 1.2 * r, 1.5 * r],
            group=4,
        )


def _athlete(base: Character, name: str) -> Athlete:
    given = {field: getattr(base, field) for field in base.__dataclass_fields__}
    return Athlete(**(given | {"name": name, "self_collisions": ()}))


def athlete_man(*, height: float = 1.75, mass: float = 70.0) -> Athlete:
    """A man; height [m], mass [kg]."""
    return _athlete(adult_man(plan="full16", height=height, mass=mass), "athlete_man")


def athlete_woman(*, height: float = 1.65, mass: float = 58.0) -> Athlete:
    """A woman; height [m], mass [kg]."""
    return _athlete(adult_woman(plan="full16", height=height, mass=mass), "athlete_woman")


ATHLETES: dict[str, Callable[..., Athlete]] = {"man": athlete_man, "woman": athlete_woman}


def athlete(name: str, *, height: float | None = None, mass: float | None = None) -> Athlete:
    """A ready-made athlete by name: "man" or "woman".

    Args:
        name: Which.
        height: [m]; by default 1.75 and 1.65.
        mass: [kg]; by default that of the usual body, times the cube of the height over its own.

    Raises:
        UnknownName: No such athlete.
    """
    if name not in ATHLETES:
        raise UnknownName("athlete", name, ATHLETES)
    usual = ATHLETES[name]()
    tall = usual.height if height is None else height
    heavy = usual.mass * (tall / usual.height) ** 3 if mass is None else mass
    return usual if height is None and mass is None else ATHLETES[name](height=tall, mass=heavy)
