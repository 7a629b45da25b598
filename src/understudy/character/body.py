"""The values a character is made of: links, shapes, and the character itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from understudy.character.anthropometry import Sex
from understudy.character.roles import Roles
from understudy.errors import InvalidValue, UnknownName
from understudy.motion.rotations import Array, identity
from understudy.motion.skeleton import Skeleton, frozen_array

if TYPE_CHECKING:
    import mujoco

    from understudy.character.mapping import Mapping
    from understudy.motion.clip import Clip

Plan = Literal["full", "full16", "upper", "upper8"]
ShapeKind = Literal["capsule", "box", "sphere", "ellipsoid", "mesh"]
ShapeUse = Literal["visible", "contact", "collision"]
SelfCollision = Literal["off", "pairs"]
Limits = Literal["off", "on"]

SKIN = (0.80, 0.66, 0.55, 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Shape:
    """A solid fixed to a link.

    Attributes:
        kind: "capsule" (along its z axis), "box", "sphere", "ellipsoid" or "mesh".
        use: "visible" is drawn and touches nothing; "contact" touches the ground and props (feet,
            toes, hands); "collision" touches only other links, when a scene asks for it. The last
            two are not drawn by default.
        position: Center in the link frame [m], shape (3,).
        rotation: Orientation in the link frame, wxyz, shape (4,).
        size: Half sizes as MuJoCo takes them [m], shape (3,): capsule radius and half length of its
            straight part, box and ellipsoid half axes, sphere radius; unused entries are zero.
        vertices: Corners of a mesh in the link frame [m], shape (n, 3).
        faces: Triangles of a mesh, corners counter-clockwise seen from outside, shape (m, 3).
        density: For inertia="geometry" [kg/m3]; zero adds nothing.
        rgba: Color and opacity, 0 to 1.
    """

    kind: ShapeKind
    use: ShapeUse = "visible"
    position: Array = field(default_factory=lambda: np.zeros(3))
    rotation: Array = field(default_factory=identity)
    size: Array = field(default_factory=lambda: np.zeros(3))
    vertices: Array = field(default_factory=lambda: np.zeros((0, 3)), repr=False)
    faces: Any = field(default_factory=lambda: np.zeros((0, 3), int), repr=False)
    density: float = 0.0
    rgba: tuple[float, float, float, float] = SKIN

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        for name, length in (("position", 3), ("rotation", 4), ("size", 3)):
            set_(self, name, frozen_array(getattr(self, name), (length,), name))
        set_(self, "vertices", frozen_array(self.vertices, (None, 3), "vertices"))
        set_(self, "faces", _faces(self.faces, len(self.vertices)))
        if (self.kind == "mesh") != (len(self.faces) > 0):
            raise InvalidValue(f"A shape of kind {self.kind!r} has {len(self.faces)} faces.")

    @property
    def contact(self) -> bool:
        """Whether it touches the ground."""
        return self.use == "contact"


def _faces(value: Any, corners: int) -> Any:
    """Triangles as whole numbers that cannot be changed, each of a corner of the mesh."""
    given = np.asarray(value)
    fits = given.shape[1:] == (3,) and (given.dtype.kind in "iu" or not given.size)
    if not (fits and (given >= 0).all() and (given < corners).all()):
        raise InvalidValue(
            f"faces has shape {given.shape} and {given.dtype} values; it must be whole numbers of "
            f"shape (m, 3), each from 0 to the last of {corners} vertices."
        )
    faces = np.array(given, int)
    faces.setflags(write=False)
    return faces


@dataclass(frozen=True, kw_only=True, eq=False)
class Link:
    """A rigid part and the ball joint that hangs it on its parent.

    The link frame has its origin at that joint. In the neutral T-pose it is aligned with the world:
    x forward, y left, z up.

    Attributes:
        name: Such as "left_thigh".
        joint: Name of its ball joint, such as "left_hip".
        role: The same for a person's joints; None in other skeletons.
        parent: Index of the inboard link, -1 for the root.
        offset: Origin in the parent's frame [m], shape (3,).
        ends: Outboard points in the link frame [m], shape (n, 3).
        mass: [kg].
        com: Center of mass in the link frame [m], shape (3,).
        inertia: About the center of mass, link axes [kg m2], shape (3, 3).
        shapes: What is seen and what touches.
        torque_limit: Human maximum per axis, the stronger direction [N m], shape (3,), or None.
        motion_limit: Largest angle from neutral [rad], or None for no limit.
        clip_joint: The clip joint whose orientation it takes, or None.
        origin_joint: The clip joint at whose position its origin lies, or None.
        alignment: World orientation of the link = that of the clip joint times this, shape (4,).
    """

    name: str
    joint: str
    role: str | None
    parent: int
    offset: Array
    ends: Array = field(default_factory=lambda: np.zeros((0, 3)))
    mass: float
    com: Array
    inertia: Array
    shapes: tuple[Shape, ...] = field(default=(), repr=False)
    torque_limit: Array | None = None
    motion_limit: float | None = None
    clip_joint: str | None = None
    origin_joint: str | None = None
    alignment: Array = field(default_factory=identity)

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "offset", frozen_array(self.offset, (3,), "offset"))
        set_(self, "ends", frozen_array(self.ends, (None, 3), "ends"))
        set_(self, "com", frozen_array(self.com, (3,), "com"))
        set_(self, "inertia", frozen_array(self.inertia, (3, 3), "inertia"))
        set_(self, "alignment", frozen_array(self.alignment, (4,), "alignment"))
        if self.torque_limit is not None:
            set_(self, "torque_limit", frozen_array(self.torque_limit, (3,), "torque_limit"))
        set_(self, "shapes", tuple(self.shapes))
        if not self.mass > 0:
            raise InvalidValue(f"Link {self.name!r} has mass {self.mass} kg; it must be positive.")
        moments = np.linalg.eigvalsh(self.inertia)
        if moments[0] <= 0 or moments[0] + moments[1] < moments[2] * (1 - 1e-9):
            raise InvalidValue(
                f"Link {self.name!r} has principal inertias {moments} kg m2; they must be positive "
                "and each at most the sum of the other two."
            )


@dataclass(frozen=True, kw_only=True)
class Character:
    """An articulated body that can perform clips.

    Attributes:
        name: Short name.
        links: Depth-first, root first; the order of MuJoCo's bodies and of `skeleton`'s joints.
        plan: Which links of a person are simulated.
        sex: Whose tables were used.
        mass: Mass of the whole body [kg]; an upper body's links add up to less.
        height: Stature [m].
        sole_height: Height of the soles in the foot frame [m], negative: below the ankle.
        source: Skeleton of the clip it was made from; its clips go over exactly.
        roles: Which clip joint is which, and why; empty for other skeletons.
        self_collisions: Pairs of link names that touch when a scene asks for it.
        notes: What was assumed or estimated, one sentence each.
    """

    name: str
    links: tuple[Link, ...] = field(repr=False)
    plan: str = "full"
    sex: Sex = "male"
    mass: float
    height: float
    sole_height: float = 0.0
    source: Skeleton | None = field(default=None, repr=False)
    roles: Roles = field(default_factory=Roles, repr=False)
    self_collisions: tuple[tuple[str, str], ...] = field(default=(), repr=False)
    notes: tuple[str, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        names = [link.name for link in self.links]
        if len(set(names)) != len(names):
            raise InvalidValue("Two links have the same name.")
        if not self.links or self.links[0].parent != -1:
            raise InvalidValue("The root link must come first.")
        if any(not 0 <= link.parent < i for i, link in enumerate(self.links[1:], 1)):
            raise InvalidValue("Every link's parent must come before it.")

    @classmethod
    def from_clip(
        cls,
        clip: Clip,
        *,
        plan: Plan = "full",
        sex: Sex = "male",
        mass: float | None = None,
        height: float | None = None,
        mapping: Mapping | None = None,
        inertia: Literal["anthropometry", "geometry"] = "anthropometry",
        segment_parameters: Literal["de_leva", "dempster"] = "de_leva",
        name: str | None = None,
    ) -> Character:
        """A character with the bones of a clip; see `understudy.character.build.from_clip`."""
        from understudy.character.build import from_clip

        return from_clip(
            clip,
            plan=plan,
            sex=sex,
            mass=mass,
            height=height,
            mapping=mapping,
            inertia=inertia,
            segment_parameters=segment_parameters,
            name=name,
        )

    @property
    def humanoid(self) -> bool:
        """Whether its joints have roles."""
        return self.links[0].role is not None

    @property
    def controlled_dof(self) -> int:
        """Degrees of freedom with a servo of their own: three per joint, the root not counted."""
        return 3 * (len(self.links) - 1)

    @property
    def simulated_mass(self) -> float:
        """Sum of the links' masses [kg]."""
        return float(sum(link.mass for link in self.links))

    def index(self, name: str) -> int:
        """Index of a link by its own name or its joint's; raises `UnknownName`."""
        for i, link in enumerate(self.links):
            if name in (link.name, link.joint):
                return i
        raise UnknownName("link", name, [link.name for link in self.links])

    def link(self, name: str) -> Link:
        """A link by its own name or its joint's; raises `UnknownName`."""
        return self.links[self.index(name)]

    @cached_property
    def skeleton(self) -> Skeleton:
        """The joints in the neutral T-pose, feet on z = 0; names are the joints'."""
        ends = [(i, end) for i, link in enumerate(self.links) for end in link.ends]
        return Skeleton(
            names=tuple(link.joint for link in self.links),
            parents=tuple(link.parent for link in self.links),
            offsets=np.array([link.offset for link in self.links]),
            end_joints=tuple(i for i, _ in ends),
            end_offsets=np.array([end for _, end in ends]).reshape(-1, 3),
        )

    def local_rotations(self, coordinates: Array) -> Array:
        """Local joint rotations from engine coordinates.

        Args:
            coordinates: Rows of the character's part of qpos, shape (frames, numbers).

        Returns:
            wxyz, shape (frames, links, 4).
        """
        return coordinates[:, 3:].reshape(len(coordinates), -1, 4)

    def spec(
        self, *, self_collision: SelfCollision = "off", limits: Limits = "off"
    ) -> mujoco.MjSpec:
        """A fresh MuJoCo model of the body alone; see `understudy.character.model.spec`."""
        from understudy.character.model import spec

        return spec(self, self_collision=self_collision, limits=limits)
