"""Closed surfaces drawn from cross-sections, and the capsules that stand in for them in contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from understudy.character.body import Shape, ShapeUse
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array

_AROUND = 20
_DOME = 4


@dataclass(frozen=True)
class Section:
    """An elliptic cross-section of a loft.

    Attributes:
        center: Its middle [m], shape (3,).
        across: Half axis along the loft's first cross direction [m].
        deep: Half axis along the second [m].
    """

    center: Array
    across: float
    deep: float


def loft(
    sections: Sequence[Section],
    *,
    across: Array,
    start_dome: float,
    end_dome: float,
    roundness: float = 2.0,
    floor: float | None = None,
) -> tuple[Array, Array]:
    """A closed surface through cross-sections, rounded at both ends.

    Args:
        sections: From start to end; at least two.
        across: Direction of each section's first half axis, shape (3,).
        start_dome: Height of the rounding before the first section [m].
        end_dome: Height of the rounding after the last [m].
        roundness: 2 is an ellipse, larger is boxier (a superellipse).
        floor: Height below which nothing reaches [m]: a flat sole; None for none.

    Returns:
        Vertices [m], shape (n, 3), and triangles, shape (m, 3), counter-clockwise from outside.
    """
    centers = np.array([s.center for s in sections])
    along = centers[-1] - centers[0]
    along = along / np.linalg.norm(along)
    u = across - along * (across @ along)
    u = u / np.linalg.norm(u)
    v = np.cross(along, u)
    angles = np.linspace(0.0, 2 * np.pi, _AROUND, endpoint=False)
    power = 2.0 / roundness
    x = np.sign(np.cos(angles)) * np.abs(np.cos(angles)) ** power
    y = np.sign(np.sin(angles)) * np.abs(np.sin(angles)) ** power
    first, last = sections[0], sections[-1]
    rounds = np.linspace(0.0, np.pi / 2, _DOME + 1)[1:-1]
    stack = [
        (
            first.center - along * start_dome * np.sin(a),
            np.cos(a) * first.across,
            np.cos(a) * first.deep,
        )
        for a in rounds[::-1]
    ]
    stack += [(s.center, s.across, s.deep) for s in sections]
    stack += [
        (last.center + along * end_dome * np.sin(a), np.cos(a) * last.across, np.cos(a) * last.deep)
        for a in rounds
    ]
    rings = [
        center + np.outer(x * half_u, u) + np.outer(y * half_v, v)
        for center, half_u, half_v in stack
    ]
    poles = [first.center - along * start_dome, last.center + along * end_dome]
    vertices = np.concatenate([*rings, np.array(poles)])
    if floor is not None:
        vertices[:, 2] = np.maximum(vertices[:, 2], floor)
    return vertices, _faces(len(rings))


def _faces(rings: int) -> Array:
    n = _AROUND
    k = np.arange(n)
    after = (k + 1) % n
    faces = []
    for r in range(rings - 1):
        a, b = r * n, (r + 1) * n
        faces.append(np.stack([a + k, a + after, b + after], axis=-1))
        faces.append(np.stack([a + k, b + after, b + k], axis=-1))
    start, end, last = rings * n, rings * n + 1, (rings - 1) * n
    faces.append(np.stack([np.full(n, start), after, k], axis=-1))
    faces.append(np.stack([np.full(n, end), last + k, last + after], axis=-1))
    return np.concatenate(faces)


def capsule(start: Array, end: Array, radius: float, **details) -> Shape:
    """A capsule between two points [m]; a sphere where they coincide."""
    way = end - start
    length = float(np.linalg.norm(way))
    if length < 1e-6:
        return Shape(kind="sphere", position=start, size=np.array([radius, 0, 0]), **details)
    return Shape(
        kind="capsule",
        position=0.5 * (start + end),
        rotation=rot.shortest_arc(np.array([0.0, 0.0, 1.0]), way),
        size=np.array([radius, 0.5 * length, 0.0]),
        **details,
    )


def box(low: Array, high: Array, *, use: ShapeUse, **details) -> Shape:
    """A box along the link's axes between two corners [m]."""
    return Shape(
        kind="box", position=0.5 * (low + high), size=0.5 * (high - low), use=use, **details
    )
