"""A scene: one or more characters, the ground and props, compiled to one model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import mujoco
import numpy as np

from understudy.character import Athlete, Character, Linkage
from understudy.character.body import SelfCollision
from understudy.errors import InvalidValue, expect
from understudy.scene import touching
from understudy.scene.ground import Ground
from understudy.scene.props import Prop
from understudy.scene.touching import Contacts

_INTEGRATORS = {
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "discrete": mujoco.mjtIntegrator.mjINT_DISCRETE,
    "euler": mujoco.mjtIntegrator.mjINT_EULER,
}


@dataclass(frozen=True)
class Part:
    """Where one character lives in the arrays of a scene's model.

    Attributes:
        prefix: Put before its names in the model; empty for the first character.
        qpos: Its slice of qpos: root position (3), then one quaternion per link. For a linkage see
            `Linkage.coordinates`; of an athlete the root's pose, then one angle per hinge.
        dofs: Its slice of qvel: root velocity (3, world), then 3 per link (link frame).
        bodies: Body id of each link, in link order (of a linkage: in joint order).
        joint_controls: Address of the quaternion control of each joint but the root, in link order;
            of an athlete the address of each hinge's torque.
        joint_actuators: Actuator id of each joint but the root.
        root_controls: Addresses of the root servo's controls: x, vx, y, vy, z, vz, then the
            quaternion.
        root_actuators: Actuator ids of the root servo: x, y, z, rotation. Linkages have none.
    """

    prefix: str
    qpos: slice
    dofs: slice
    bodies: tuple[int, ...]
    joint_controls: tuple[int, ...]
    joint_actuators: tuple[int, ...]
    root_controls: tuple[int, ...]
    root_actuators: tuple[int, ...]


def timestep_for(rate: float, *, near: float = 0.002) -> float:
    """The step nearest `near` [s] that divides the frame period of a clip at `rate` [Hz]."""
    return 1.0 / (rate * max(1, round(1.0 / (rate * near))))


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Characters, ground and props; no time.

    Attributes:
        characters: Characters or linkages, at least one. The first keeps its names in the model;
            the others' are prefixed "b/", "c/" and so on.
        ground: The floor, or None for free space.
        props: Things that attach themselves; each has a name of its own.
        contacts: What collides besides soles and loose props with the ground: pairs of names of
            links and props, such as ("right_hand", "drum"); of a second character
            "b/right_hand". "all": every prop with every link and other prop, and links of
            different characters with each other. None by default.
        timestep: Physics step [s].
        gravity: Downward acceleration [m/s^2].
        self_collision: Which of a character's own link pairs collide; see `Character.spec`.
        integrator: "implicitfast", which takes servo damping implicitly, "discrete", which takes
            servo stiffness so too and stands longer steps, or "euler", the semi-implicit step; by
            default the last where all who perform are linkages, else the first.
    """

    characters: tuple[Any, ...]
    ground: Ground | None = field(default_factory=Ground)
    props: tuple[Prop, ...] = ()
    contacts: Contacts = ()
    timestep: float = 0.002
    gravity: float = 9.81
    self_collision: SelfCollision = "off"
    integrator: Literal["implicitfast", "discrete", "euler"] | None = None

    def __post_init__(self) -> None:
        characters = self.characters
        if isinstance(characters, Character | Linkage):
            characters = (characters,)
        object.__setattr__(self, "characters", tuple(characters))
        object.__setattr__(self, "props", tuple(self.props))
        if not self.characters:
            raise InvalidValue("A scene needs at least one character.")
        if len(self.characters) > 24:
            raise InvalidValue(f"{len(self.characters)} characters; a scene holds at most 24.")
        for name in ("timestep", "gravity"):
            expect(getattr(self, name), (int, float, np.number), name, "a number")
        if not 1e-5 <= self.timestep <= 0.05:
            raise InvalidValue(f"timestep is {self.timestep} s; it must lie in 1e-5 to 0.05.")
        if not np.isfinite(self.gravity):
            raise InvalidValue(f"gravity is {self.gravity}; it must be a finite number.")
        if self.integrator not in (None, *_INTEGRATORS):
            raise InvalidValue(
                f"integrator is {self.integrator!r}; it must be one of {tuple(_INTEGRATORS)}."
            )
        self._check_names()

    def _check_names(self) -> None:
        """Refuse props of one name, and contacts of names that do not exist."""
        named = [p.name for p in self.props if isinstance(getattr(p, "name", None), str)]  # type: ignore[attr-defined]
        links = touching.link_names(self.characters, self._prefixes)
        taken = set(links)
        for name in named:
            if name in taken:
                what = "link" if name in links else "prop"
                raise InvalidValue(
                    f"A prop is named {name!r}, as a {what} of the scene is; give it another name."
                )
            taken.add(name)
        contacts = touching.checked(self.contacts, (*links, *named))
        object.__setattr__(self, "contacts", contacts)

    @property
    def _prefixes(self) -> tuple[str, ...]:
        return tuple(self.prefix(k) for k in range(len(self.characters)))

    def prefix(self, character: int = 0) -> str:
        """Name prefix of a character in the model."""
        return "" if character == 0 else f"{chr(ord('a') + character)}/"

    def spec(self) -> mujoco.MjSpec:
        """A fresh, editable MuJoCo specification of the whole scene."""
        spec = self.characters[0].spec(self_collision=self.self_collision)
        for k, character in enumerate(self.characters[1:], 1):
            child = character.spec(self_collision=self.self_collision)
            spec.attach(child, prefix=self.prefix(k), frame=spec.worldbody.add_frame())
        if self.ground is not None:
            self.ground.attach(spec)
        for prop in self.props:
            prop.attach(spec)
        option = spec.option
        option.timestep = self.timestep
        if self.contacts:
            touching.add_pairs(spec, self.contacts, self.characters, self._prefixes, self.props)
        option.gravity = [0.0, 0.0, -self.gravity]
        linkages = all(isinstance(character, Linkage) for character in self.characters)
        # Euler does not take the servos' damping implicitly.
        chosen = self.integrator or ("euler" if linkages else "implicitfast")
        option.integrator = _INTEGRATORS[chosen]
        if chosen == "euler":
            option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
        # The sparse Newton solver of MuJoCo 4.0.0 can have a wrong Hessian where there are
        # contacts; without them it is right, and faster on many free bodies.
        sparse = linkages and not any(character.contact for character in self.characters)
        jacobian = mujoco.mjtJacobian
        option.jacobian = jacobian.mjJAC_SPARSE if sparse else jacobian.mjJAC_DENSE
        # Joined bodies are one island. Looking for it costs a tenth of a linkage's step, a
        # twentieth of a body's, and changes no bit.
        alone = len(self.characters) == 1 and not linkages and not self.props
        if sparse or alone:
            option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
        return spec

    @cached_property
    def model(self) -> mujoco.MjModel:
        """The compiled model; treat it as read-only and copy it to change it.

        Raises:
            InvalidValue: The engine refuses the scene; the text is its reason.
        """
        try:
            return self.spec().compile()
        except InvalidValue:
            raise
        except ValueError as error:
            raise InvalidValue(f"The engine refuses this scene: {error}") from error

    def check_start(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Refuse a first state in which a loose prop is deep inside something it collides with.

        Args:
            model: The scene's model.
            data: Its first state, with contacts computed.

        Raises:
            InvalidValue: Names both and how deep.
        """
        loose = touching.loose_bodies(model, self.props)
        for contact in data.contact[: data.ncon] if loose else ():
            pair = [int(model.geom_bodyid[geom]) for geom in contact.geom]
            if contact.dist < -touching.DEEP and loose.intersection(pair):
                first = next(body for body in pair if body in loose)
                other = pair[1 - pair.index(first)]
                geom = int(contact.geom[pair.index(other)])
                within = touching.name_of(model, other, geom)
                raise InvalidValue(
                    f"{touching.name_of(model, first, -1)!r} begins {-1e3 * contact.dist:.0f} mm "
                    f"inside {within!r}; put it where it touches nothing."
                )

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """Where each character lives in the model's arrays."""
        return tuple(self._part(k) for k in range(len(self.characters)))

    def _part(self, k: int) -> Part:
        model, character, prefix = self.model, self.characters[k], self.prefix(k)

        def ids(kind: mujoco.mjtObj, names: Iterable[str]) -> tuple[int, ...]:
            return tuple(mujoco.mj_name2id(model, kind, prefix + name) for name in names)

        if isinstance(character, Linkage):
            bodies = ids(mujoco.mjtObj.mjOBJ_BODY, character.names)
            joint = int(model.body_jntadr[bodies[0]])
            q, v = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
            nq, nv = character.widths
            return Part(prefix, slice(q, q + nq), slice(v, v + nv), bodies, (), (), (), ())
        links = character.links
        root = links[0].joint
        if isinstance(character, Athlete):
            joint = ids(mujoco.mjtObj.mjOBJ_JOINT, [root])[0]
            q, v = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
            nq, nv = character.widths
            motors = ids(
                mujoco.mjtObj.mjOBJ_ACTUATOR, [n for own in character.hinge_names for n in own]
            )
            controls = tuple(int(model.actuator_ctrladr[a]) for a in motors)
            bodies = ids(mujoco.mjtObj.mjOBJ_BODY, [link.name for link in links])
            return Part(
                *(prefix, slice(q, q + nq), slice(v, v + nv), bodies, controls, motors, (), ())
            )
        joints = ids(mujoco.mjtObj.mjOBJ_JOINT, ["root_x", root])
        qpos, dofs = int(model.jnt_qposadr[joints[0]]), int(model.jnt_dofadr[joints[0]])
        servos = ids(mujoco.mjtObj.mjOBJ_ACTUATOR, [link.joint for link in links[1:]])
        drives = ids(mujoco.mjtObj.mjOBJ_ACTUATOR, ["root_x", "root_y", "root_z", "root"])
        address = model.actuator_ctrladr
        return Part(
            prefix=prefix,
            qpos=slice(qpos, qpos + 3 + 4 * len(links)),
            dofs=slice(dofs, dofs + 3 + 3 * len(links)),
            bodies=ids(mujoco.mjtObj.mjOBJ_BODY, [link.name for link in links]),
            joint_controls=tuple(int(address[a]) for a in servos),
            joint_actuators=servos,
            root_controls=tuple(
                int(address[a]) + i
                for a, n in zip(drives, (2, 2, 2, 4), strict=True)
                for i in range(n)
            ),
            root_actuators=drives,
        )
