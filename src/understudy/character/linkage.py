"""A clip's whole skeleton as rigid bodies (Wilke & Semwal 2017, section 1): four linkages.

- `independent`: a sphere at every joint, held by nothing;
- `skeleton`: a capsule from the parent joint to every joint, held by nothing;
- `constrained`: the same capsules, joined by point-to-point constraints at their parent joints;
- `tree`: the same capsules as one articulated tree of ball joints, which cannot come apart.

Body number j belongs to joint number j and has its name. A capsule is oriented as its parent joint,
at which it begins; the root and bones of no length are spheres. Every body frame lies at the center
of mass with z along the capsule, so that the inertia tensor is diagonal in it, and a free body's
velocities are those of its center of mass: linear in the world, angular in the body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from understudy.character.body import SelfCollision
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton, frozen_array

if TYPE_CHECKING:
    import mujoco

Kind = Literal["independent", "skeleton", "constrained", "tree"]
KINDS: tuple[Kind, ...] = ("independent", "skeleton", "constrained", "tree")
# 0.3 units of the BVH conversion of the CMU motions (5.644 cm) [m].
RADIUS = 0.3 * 0.0254 / 0.45
# Bones shorter than this are spheres [m].
_SHORTEST = 1e-6


@dataclass(frozen=True, kw_only=True)
class Lock:
    """A joint that does not turn about some axes: a generic six-axis joint with these locked.

    Attributes:
        joint: Name of the joint, such as "LeftLeg" for a knee: it locks the bones that begin there.
        axes: Which rotations are locked, any of "x", "y" and "z"; the axes are those of the world
            in the rest pose (x forward or left by the file, z up). "xyz" is a weld.
        rotation: Local joint rotation at which it is locked, wxyz, shape (4,); the rest pose
            (a straight leg) by default.
    """

    joint: str
    axes: str = "xyz"
    rotation: Array = field(default_factory=rot.identity, compare=False)

    def __post_init__(self) -> None:
        if not self.axes or set(self.axes) - set("xyz") or len(set(self.axes)) < len(self.axes):
            raise InvalidValue(f"axes is {self.axes!r}; it must be some of 'x', 'y' and 'z'.")
        turn = rot.normalized(frozen_array(self.rotation, (4,), "rotation"))
        object.__setattr__(self, "axes", "".join(sorted(self.axes)))
        object.__setattr__(self, "rotation", frozen_array(turn, (4,), "rotation"))


@dataclass(frozen=True, kw_only=True, eq=False)
class Linkage:
    """Rigid bodies made of a clip's full skeleton; compares by identity.

    Attributes:
        name: Short name.
        kind: "independent", "skeleton", "constrained" or "tree"; see the module.
        skeleton: The clip's.
        unit: Meters per unit in which errors are also reported: that of the clip's file.
        masses: Mass of every body [kg], shape (joints,); the paper's is 1.
        radii: Radius of every body [m], shape (joints,).
        locks: Joints that do not turn about some axes (constrained and tree).
        contact: Whether the bodies touch the ground and props; the paper's do not.
    """

    name: str
    kind: Kind = "constrained"
    skeleton: Skeleton = field(repr=False)
    unit: float = 0.01
    masses: Array = field(repr=False)
    radii: Array = field(repr=False)
    locks: tuple[Lock, ...] = ()
    contact: bool = False

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InvalidValue(f"kind is {self.kind!r}; it must be one of {', '.join(KINDS)}.")
        if not (np.isfinite(self.unit) and self.unit > 0):
            raise InvalidValue(f"unit is {self.unit} m; it must be a positive number.")
        for name in ("masses", "radii"):
            array = frozen_array(getattr(self, name), (len(self.skeleton),), name)
            object.__setattr__(self, name, array)
            for body, value in zip(self.skeleton.names, array, strict=True):
                if not value > 0:
                    raise InvalidValue(f"{name} of {body!r} is {value}; it must be positive.")
        object.__setattr__(self, "locks", tuple(self.locks))
        if self.locks and self.kind not in ("constrained", "tree"):
            raise InvalidValue(f"Bodies of kind {self.kind!r} have no joints that can be locked.")
        for lock in self.locks:
            if not self.skeleton.children(self.skeleton.index(lock.joint)):
                raise InvalidValue(
                    f"No bone begins at {lock.joint!r}; nothing there can be locked."
                )
        if len({lock.joint for lock in self.locks}) < len(self.locks):
            raise InvalidValue("A joint is locked twice; give it one lock with all its axes.")

    @classmethod
    def from_clip(
        cls,
        clip: Clip,
        kind: Kind = "constrained",
        *,
        unit: float | None = None,
        masses: Literal["one", "anthropometry"] | Mapping[str, float] = "one",
        mass: float | None = None,
        radius: float = RADIUS,
        locks: Sequence[Lock] = (),
        contact: bool = False,
        name: str | None = None,
    ) -> Linkage:
        """The bodies of any clip's skeleton.

        Args:
            clip: Any clip.
            kind: "independent", "skeleton", "constrained" or "tree".
            unit: Meters per reported unit; by default per unit of the clip's file.
            masses: "one" (1 kg each, the paper's), "anthropometry" (a person's, for a clip whose
                joints can be recognized), or kg by joint name, 1 for the others.
            mass: Whole mass with "anthropometry" [kg]; by default by height.
            radius: Radius of every body [m].
            locks: See `Lock`.
            contact: Whether the bodies touch the ground.
            name: By default the clip's.

        Raises:
            InvalidValue: A value that is not positive, or an unknown kind.
            UnknownName: A joint that does not exist.
        """
        from understudy.character.linkage_masses import anthropometric_masses

        if masses == "anthropometry":
            each = anthropometric_masses(clip, mass)
        else:
            each = np.ones(len(clip.skeleton))
        out = cls(
            name=name or clip.name,
            kind=kind,
            skeleton=clip.skeleton,
            unit=clip.conventions.unit if unit is None else unit,
            masses=each,
            radii=np.full(len(clip.skeleton), radius, float),
            locks=tuple(locks),
            contact=contact,
        )
        return out.weighing(masses) if isinstance(masses, Mapping) else out

    # -- edits -------------------------------------------------------------------------------

    def weighing(self, masses: Mapping[str, float]) -> Linkage:
        """The same with other masses [kg], by joint name."""
        changed = np.array(self.masses)
        for name, value in masses.items():
            changed[self.skeleton.index(name)] = value
        return replace(self, masses=changed)

    def locked(self, *joints: str, axes: str = "xyz", rotation: Array | None = None) -> Linkage:
        """The same with joints locked, in place of locks they had; see `Lock`."""
        turn = rot.identity() if rotation is None else rotation
        kept = [lock for lock in self.locks if lock.joint not in joints]
        more = [Lock(joint=joint, axes=axes, rotation=turn) for joint in joints]
        return replace(self, locks=(*kept, *more))

    # -- geometry ----------------------------------------------------------------------------

    def __len__(self) -> int:
        return len(self.skeleton)

    def index(self, name: str) -> int:
        """Number of a body, by its joint's name; raises `UnknownName`."""
        return self.skeleton.index(name)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies: those of their joints."""
        return self.skeleton.names

    @property
    def source(self) -> Skeleton:
        """Skeleton of the clip it was made from, all of which it has."""
        return self.skeleton

    @property
    def mass(self) -> float:
        """Mass of all bodies [kg]."""
        return float(self.masses.sum())

    @cached_property
    def height(self) -> float:
        """Extent of the rest pose along its longest side [m]."""
        return float(max(np.ptp(self.skeleton.rest_positions(), axis=0).max(), 2 * self.radii[0]))

    @cached_property
    def lengths(self) -> Array:
        """Length of every capsule's straight part [m], shape (joints,); 0 is a sphere."""
        out = np.linalg.norm(self.skeleton.offsets, axis=1)
        out[0] = 0.0
        if self.kind == "independent":
            out[:] = 0.0
        return np.where(out > _SHORTEST, out, 0.0)

    @cached_property
    def alignments(self) -> Array:
        """Body orientation = that of the joint it is oriented as times this, shape (joints, 4)."""
        out = rot.identity(len(self))
        bones = np.flatnonzero(self.lengths)
        out[bones] = rot.shortest_arc([0.0, 0.0, 1.0], self.skeleton.offsets[bones])
        return out

    @cached_property
    def oriented_as(self) -> tuple[int, ...]:
        """For every body, the joint whose orientation it takes: its parent joint, but for spheres.

        Independent bodies and the root take their own joint's.
        """
        parents = self.skeleton.parents
        if self.kind == "independent":
            return tuple(range(len(self)))
        return (0, *parents[1:])

    @cached_property
    def inertias(self) -> Array:
        """Principal moments of solid capsules about their centers [kg m2], shape (joints, 3)."""
        r, length, m = self.radii, self.lengths, self.masses
        # Cylinder and ball of one density; the two half balls sit at the cylinder's ends.
        cylinder = m * length / (length + 4.0 / 3.0 * r)
        ball = m - cylinder
        across = cylinder * (length**2 / 12.0 + r**2 / 4.0)
        across += ball * (0.4 * r**2 + length**2 / 4.0 + 0.375 * r * length)
        along = 0.5 * cylinder * r**2 + 0.4 * ball * r**2
        return np.stack((across, across, along), axis=1)

    @cached_property
    def anchors(self) -> Array:
        """Parent end of every body in its own frame [m], shape (joints, 3)."""
        return np.stack((0 * self.lengths, 0 * self.lengths, -0.5 * self.lengths), axis=1)

    @cached_property
    def ends(self) -> Array:
        """Far end of every body in its own frame, where its joint lies [m], shape (joints, 3).

        Equation 4 measures a body's error there; for spheres it is the center of mass.
        """
        return -self.anchors

    @cached_property
    def relative(self) -> Array:
        """Rest orientation of every body in its parent body's frame, shape (joints, 4)."""
        out = np.array(self.alignments)
        for j, p in enumerate(self.skeleton.parents[1:], 1):
            out[j] = rot.multiply(rot.conjugate(self.alignments[p]), self.alignments[j])
        return out

    @cached_property
    def order(self) -> tuple[int, ...]:
        """Body numbers in the order in which the engine holds them: depth first in a tree."""
        if self.kind != "tree":
            return tuple(range(len(self)))
        out, stack = [], [0]
        while stack:
            joint = stack.pop()
            out.append(joint)
            stack += reversed(self.skeleton.children(joint))
        return tuple(out)

    def placed(self, positions: Array, rotations: Array) -> tuple[Array, Array]:
        """World poses of the bodies from those of the joints.

        Args:
            positions: Joint positions [m], shape (frames, joints, 3).
            rotations: Joint orientations, wxyz, shape (frames, joints, 4).

        Returns:
            Centers of mass [m], shape (frames, joints, 3), and body orientations (frames, joints,
            4), signs continuous over the frames.
        """
        turned = rot.multiply(rotations[:, list(self.oriented_as)], self.alignments)
        start = positions[:, list(self.oriented_as)]
        return start - rot.rotate(turned, self.anchors), rot.continuous(turned)

    # -- from and to the engine's coordinates --------------------------------------------------

    @property
    def widths(self) -> tuple[int, int]:
        """How many numbers qpos and qvel hold for it."""
        n = len(self)
        return (7 + 4 * (n - 1), 6 + 3 * (n - 1)) if self.kind == "tree" else (7 * n, 6 * n)

    def coordinates(self, positions: Array, rotations: Array) -> Array:
        """Engine coordinates of body poses, shape (frames, nq); a tree keeps the rotations only."""
        order = list(self.order)
        if self.kind != "tree":
            both = np.concatenate((positions, rotations), axis=2)
            return both.reshape(len(both), -1)
        local = np.array(rotations)
        for j, p in enumerate(self.skeleton.parents[1:], 1):
            rest = rot.multiply(rotations[:, p], self.relative[j])
            local[:, j] = rot.multiply(rot.conjugate(rest), rotations[:, j])
        return np.concatenate((positions[:, 0], local[:, order].reshape(len(local), -1)), axis=1)

    def poses(self, coordinates: Array) -> tuple[Array, Array]:
        """World poses of the bodies from engine coordinates, the inverse of `coordinates`.

        Returns:
            Centers of mass [m], shape (frames, joints, 3), and orientations (frames, joints, 4).
        """
        frames, n = len(coordinates), len(self)
        if self.kind != "tree":
            both = np.asarray(coordinates).reshape(frames, n, 7)
            return both[..., :3], both[..., 3:]
        local = np.asarray(coordinates)[:, 3:].reshape(frames, n, 4)
        turned, placed = np.empty((frames, n, 4)), np.empty((frames, n, 3))
        row = {body: k for k, body in enumerate(self.order)}
        turned[:, 0], placed[:, 0] = local[:, 0], coordinates[:, :3]
        for j, p in enumerate(self.skeleton.parents[1:], 1):
            rest = rot.multiply(turned[:, p], self.relative[j])
            turned[:, j] = rot.multiply(rest, local[:, row[j]])
            hinge = placed[:, p] + rot.rotate(turned[:, p], self.ends[p])
            placed[:, j] = hinge - rot.rotate(turned[:, j], self.anchors[j])
        return placed, turned

    def joint_rotations(self, rotations: Array, leaves: Array | None = None) -> Array:
        """Local joint rotations from body orientations (frames, joints, 4), same shape.

        A joint takes the orientation of the longest bone that begins there, since several may
        differ where nothing holds them together. A joint without bones has no body that shows its
        rotation and takes its row of `leaves`, the clip's local rotations.
        """
        shown = rot.multiply(rotations, rot.conjugate(self.alignments))
        world, parents = np.array(shown), self.skeleton.parents
        if self.kind != "independent":
            for joint in range(1, len(self)):
                bones = self.skeleton.children(joint)
                if bones:
                    longest = max(bones, key=lambda j: (self.lengths[j], -j))
                    world[:, joint] = shown[:, longest]
        out = np.array(world)
        for joint, p in enumerate(parents[1:], 1):
            if self.kind == "independent" or self.skeleton.children(joint):
                out[:, joint] = rot.multiply(rot.conjugate(world[:, p]), world[:, joint])
            else:
                out[:, joint] = rot.identity() if leaves is None else leaves[:, joint]
        return out

    def held(self, clip: Clip) -> Clip:
        """The clip with the locked joints as they are locked; others and the root path as captured.

        One locked axis loses its angle in the Euler order that has it in the middle; two leave the
        twist about the third.
        """
        turned = np.array(clip.rotations)
        for lock in self.locks:
            joint = self.skeleton.index(lock.joint)
            if joint == 0:
                continue
            away = rot.multiply(rot.conjugate(lock.rotation), turned[:, joint])
            turned[:, joint] = rot.multiply(lock.rotation, _without(away, lock.axes))
        return replace(clip, rotations=turned)

    def spec(self, *, self_collision: SelfCollision = "off") -> mujoco.MjSpec:
        """A fresh MuJoCo model of the bodies in the rest pose; see `linkage_model.spec`."""
        from understudy.character.linkage_model import spec

        return spec(self, self_collision=self_collision)


def _without(q: Array, axes: str) -> Array:
    """Rotations without their turns about the locked axes, as the constraints measure them."""
    if len(axes) == 3:
        return rot.identity(*q.shape[:-1])
    if len(axes) == 2:
        free = 1 + "xyz".index((set("xyz") - set(axes)).pop())
        kept = np.zeros_like(q)
        kept[..., [0, free]] = q[..., [0, free]]
        return rot.normalized(kept)
    k = "XYZ".index(axes.upper())
    order = "XYZ"[(k + 1) % 3] + "XYZ"[k] + "XYZ"[(k + 2) % 3]
    angles = rot.to_euler(q, order)
    angles[..., 1] = 0.0
    return rot.from_euler(order, angles)
