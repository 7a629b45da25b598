"""A skeleton: named joints in a tree, with the offset of each from its parent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from understudy.errors import InvalidValue, UnknownName
from understudy.motion.rotations import Array


def frozen_array(value: Any, shape: tuple[int | None, ...], name: str) -> Array:
    """A read-only float copy of `value`, checked to be finite and of `shape` (None: any length).

    Raises:
        InvalidValue: The shape is another, or a value is NaN or infinite.
    """
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InvalidValue(f"{name} must be numbers of shape {shape}: {error}") from None
    if array.size == 0 and 0 in [n for n in shape if n is not None] + [0]:
        array = array.reshape([0 if n is None else n for n in shape])
    if array.ndim != len(shape) or any(
        n is not None and n != m for n, m in zip(shape, array.shape, strict=True)
    ):
        raise InvalidValue(f"{name} has shape {array.shape}; expected {shape}.")
    if not np.isfinite(array).all():
        raise InvalidValue(f"{name} has values that are not finite.")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, kw_only=True)
class Skeleton:
    """Joints in a tree; the rest pose is every joint rotation at identity, z up.

    Attributes:
        names: One unique name per joint; the root is first.
        parents: Index of each joint's parent, always smaller than the joint's own; -1 for the root.
        offsets: Position of each joint in its parent's frame [m], shape (joints, 3). The root's is
            where the root rests in the world; a clip's root path replaces it.
        end_joints: For each end site, the joint that carries it.
        end_offsets: Position of each end site in that joint's frame [m], shape (ends, 3).
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: Array = field(repr=False)
    end_joints: tuple[int, ...] = ()
    end_offsets: Array = field(default_factory=lambda: np.zeros((0, 3)), repr=False)

    def __post_init__(self) -> None:
        names, parents = tuple(self.names), tuple(int(p) for p in self.parents)
        if not names:
            raise InvalidValue("A skeleton needs at least one joint.")
        if len(parents) != len(names):
            raise InvalidValue(f"{len(parents)} parents for {len(names)} joints.")
        if len(set(names)) != len(names):
            twice = next(n for n in names if names.count(n) > 1)
            raise InvalidValue(f"Two joints are named {twice!r}; names must be unique.")
        if parents[0] != -1 or any(not 0 <= p < i for i, p in enumerate(parents[1:], 1)):
            raise InvalidValue("The root must come first and every parent before its children.")
        ends = tuple(int(j) for j in self.end_joints)
        if any(not 0 <= j < len(names) for j in ends):
            raise InvalidValue("An end site belongs to a joint that does not exist.")
        set_ = object.__setattr__
        set_(self, "names", names)
        set_(self, "parents", parents)
        set_(self, "offsets", frozen_array(self.offsets, (len(names), 3), "offsets"))
        set_(self, "end_joints", ends)
        set_(self, "end_offsets", frozen_array(self.end_offsets, (len(ends), 3), "end_offsets"))

    def __len__(self) -> int:
        return len(self.names)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Skeleton):
            return NotImplemented
        return (
            self.names == other.names
            and self.parents == other.parents
            and self.end_joints == other.end_joints
            and np.array_equal(self.offsets, other.offsets)
            and np.array_equal(self.end_offsets, other.end_offsets)
        )

    def __hash__(self) -> int:
        return hash((self.names, self.parents, self.offsets.tobytes()))

    @cached_property
    def _indices(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.names)}

    def index(self, name: str) -> int:
        """Index of the joint called `name`.

        Raises:
            UnknownName: No joint has that name; the text suggests the nearest.
        """
        try:
            return self._indices[name]
        except KeyError:
            raise UnknownName("joint", name, self.names) from None

    def children(self, joint: int) -> tuple[int, ...]:
        """Indices of the joints attached directly to `joint`."""
        return self._children[joint]

    @cached_property
    def _children(self) -> tuple[tuple[int, ...], ...]:
        lists: list[list[int]] = [[] for _ in self.names]
        for i, p in enumerate(self.parents[1:], 1):
            lists[p].append(i)
        return tuple(tuple(c) for c in lists)

    def rest_positions(self) -> Array:
        """World position of every joint in the rest pose [m], shape (joints, 3)."""
        out = np.array(self.offsets)
        for i, p in enumerate(self.parents[1:], 1):
            out[i] += out[p]
        return out

    def scaled(self, factor: float) -> Skeleton:
        """The same skeleton with every length multiplied by `factor`."""
        if not (np.isfinite(factor) and factor > 0):
            raise InvalidValue(f"scale factor is {factor}; it must be a positive number.")
        return Skeleton(
            names=self.names,
            parents=self.parents,
            offsets=self.offsets * factor,
            end_joints=self.end_joints,
            end_offsets=self.end_offsets * factor,
        )


def joint_indices(skeleton: Skeleton, names: Sequence[str]) -> list[int]:
    """Indices of several joints, in the order of `names`; raises `UnknownName`."""
    return [skeleton.index(name) for name in names]
