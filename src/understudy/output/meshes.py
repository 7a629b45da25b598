"""The visible surface of a model as triangles, body by body.

In: a compiled MuJoCo model. Out: for every body one triangle mesh in the body's own frame, so that
a rigid pose per frame is all that a player or a skinned file has to add.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from understudy.motion import rotations as rot
from understudy.motion.rotations import Array

# The engine's own convention: geometry groups 0 to 2 are shown, 3 and up are hidden.
_SHOWN_GROUPS = 3
_AROUND = 20  # corners of a round cross-section
_DOME = 5  # rings of half a sphere
# A polygon with the area of its circle is this much larger than the one inscribed.
_SWELL = np.sqrt(2.0 * np.pi / _AROUND / np.sin(2.0 * np.pi / _AROUND))
_PATCH = 20  # half side of a sloping plane's visible patch [m]
_CREASE = np.radians(50.0)  # sharper edges of meshes stay sharp


@dataclass(frozen=True, kw_only=True)
class Surface:
    """Triangles of one color that move with one body.

    Attributes:
        body: Body number in the model.
        points: Corners in the body's frame [m], shape (corners, 3).
        normals: Unit outward normals, shape (corners, 3).
        triangles: Corner numbers, counter-clockwise from outside, shape (triangles, 3).
        color: Red, green, blue, opacity in 0..1 (sRGB), shape (4,).
    """

    body: int
    points: Array
    normals: Array
    triangles: np.ndarray[Any, np.dtype[np.int32]]
    color: Array


def shown(model: mujoco.MjModel) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Which geometries of a model are to be seen, ground planes included; shape (ngeom,)."""
    return (model.geom_group < _SHOWN_GROUPS) & (colors(model)[:, 3] > 0.0)


def colors(model: mujoco.MjModel) -> Array:
    """Color of every geometry [0..1, sRGB and opacity], shape (ngeom, 4); materials included."""
    out = np.array(model.geom_rgba, float)
    with_material = np.flatnonzero(model.geom_matid >= 0)
    if len(with_material):
        out[with_material] = model.mat_rgba[model.geom_matid[with_material]]
    # The engine's default gray says that nobody chose a color.
    unchosen = np.all(np.abs(out - np.array([0.5, 0.5, 0.5, 1.0])) < 1e-6, axis=1)
    out[unchosen] = (0.80, 0.62, 0.45, 1.0)
    return out


def planes(model: mujoco.MjModel) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Numbers of the geometries that are infinite ground planes and are shown."""
    return np.flatnonzero((model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE) & shown(model))


def level(model: mujoco.MjModel, plane: int) -> bool:
    """Whether a plane of a model is horizontal."""
    return bool(abs(rot.rotate(model.geom_quat[plane], np.array([0.0, 0.0, 1.0]))[2]) > 1.0 - 1e-12)


def tiles(model: mujoco.MjModel, plane: int, near: Array) -> tuple[Surface, ...]:
    """A patch of an infinite plane about a point (3,) [m], as square meters of two shades."""
    turn, place = model.geom_quat[plane], model.geom_pos[plane]
    middle = np.round(rot.rotate(rot.conjugate(turn), near - place)[:2])
    corner = np.arange(-_PATCH, _PATCH)
    x, y = (axis.ravel() + m for axis, m in zip(np.meshgrid(corner, corner), middle, strict=True))
    paint, out = colors(model)[plane], []
    for shade, odd in ((1.0, 0), (0.9, 1)):
        chosen = (x + y) % 2 == odd
        starts = np.stack((x[chosen], y[chosen], np.zeros(chosen.sum())), axis=-1)
        square = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
        points = (starts[:, None] + square).reshape(-1, 3)
        first = 4 * np.arange(len(starts), dtype=np.int32)[:, None]
        faces = (first + np.array([0, 1, 2, 0, 2, 3], np.int32)).reshape(-1, 3)
        out.append(
            Surface(
                body=int(model.geom_bodyid[plane]),
                points=rot.rotate(turn, points) + place,
                normals=np.tile(rot.rotate(turn, np.array([0.0, 0.0, 1.0])), (len(points), 1)),
                triangles=faces.astype(np.int32),
                color=np.array([*(shade * paint[:3]), paint[3]]),
            )
        )
    return tuple(out)


def surfaces(model: mujoco.MjModel) -> tuple[Surface, ...]:
    """The shown geometries of a model as triangles, without planes and height fields."""
    visible, paint = shown(model), colors(model)
    out = []
    for geom in np.flatnonzero(visible):
        shape = _triangulated(model, int(geom))
        if shape is None:
            continue
        points, normals, triangles = shape
        turn = np.array(model.geom_quat[geom])
        out.append(
            Surface(
                body=int(model.geom_bodyid[geom]),
                points=rot.rotate(turn, points) + model.geom_pos[geom],
                normals=rot.rotate(turn, normals),
                triangles=triangles,
                color=paint[geom],
            )
        )
    return tuple(out)


def outline(
    model: mujoco.MjModel, fixed: Collection[int] = ()
) -> tuple[np.ndarray[Any, np.dtype[np.int64]], Array]:
    """A few outermost points of every moving body: body numbers (n,) and points (n, 3) [m].

    A picture that holds these points holds the body. Of bodies that do not move only the `fixed`
    ones are taken.
    """
    axis = np.array([-1.0, 0.0, 1.0])
    directions = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3)
    bodies, points = [], []
    for geom in np.flatnonzero(shown(model)):
        body = int(model.geom_bodyid[geom])
        seen = model.body_weldid[body] != 0 or body in fixed
        corners = _corners(model, int(geom)) if seen else None
        if corners is None:
            continue
        corners = rot.rotate(model.geom_quat[geom], corners) + model.geom_pos[geom]
        far = np.unique(np.argmax(corners @ directions.T, axis=0))
        bodies += [body] * len(far)
        points.append(corners[far])
    if not points:
        return np.zeros(0, np.int64), np.zeros((0, 3))
    return np.array(bodies, np.int64), np.concatenate(points)


def sphere(radii: Array, half_length: float = 0.0) -> tuple[Array, Array, np.ndarray]:
    """An ellipsoid with half-axes `radii` (3,) [m], or a capsule along z when `half_length` > 0."""
    polar = np.linspace(0.0, np.pi / 2, _DOME + 1)
    rings = np.concatenate((polar, np.pi / 2 + polar)) if half_length > 0 else None
    if rings is None:
        rings = np.linspace(0.0, np.pi, 2 * _DOME + 1)
    turn = np.arange(_AROUND) * (2 * np.pi / _AROUND)
    unit = np.stack(
        (
            np.sin(rings)[:, None] * np.cos(turn),
            np.sin(rings)[:, None] * np.sin(turn),
            np.broadcast_to(np.cos(rings)[:, None], (len(rings), _AROUND)),
        ),
        axis=-1,
    )
    points = unit * radii * _SWELL
    if half_length > 0:
        points[: _DOME + 1, :, 2] += half_length
        points[_DOME + 1 :, :, 2] -= half_length
    normals = unit / radii
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return points.reshape(-1, 3), normals.reshape(-1, 3), _grid(len(rings), _AROUND)


def box(half: Array) -> tuple[Array, Array, np.ndarray]:
    """A box with half sizes `half` (3,) [m], flat shaded."""
    points, normals, triangles = [], [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (1.0, -1.0):
            corners = np.zeros((4, 3))
            corners[:, axis] = side
            corners[:, u] = np.array([-1.0, 1.0, 1.0, -1.0]) * side
            corners[:, v] = (-1.0, -1.0, 1.0, 1.0)
            normal = np.zeros(3)
            normal[axis] = side
            start = 4 * len(points)
            points.append(corners * half)
            normals.append(np.broadcast_to(normal, (4, 3)))
            triangles += [(start, start + 1, start + 2), (start, start + 2, start + 3)]
    return np.concatenate(points), np.concatenate(normals), np.array(triangles, np.int32)


def cylinder(radius: float, half_length: float) -> tuple[Array, Array, np.ndarray]:
    """A cylinder along z [m] with flat caps."""
    turn = np.arange(_AROUND) * (2 * np.pi / _AROUND)
    rim = np.stack((np.cos(turn), np.sin(turn), np.zeros(_AROUND)), axis=-1)
    up = np.array([0.0, 0.0, half_length])
    wall = np.concatenate((rim * radius * _SWELL + up, rim * radius * _SWELL - up))
    points, normals, triangles = [wall], [np.concatenate((rim, rim))], [_grid(2, _AROUND)]
    fan = np.stack(
        (np.zeros(_AROUND - 2), np.arange(1, _AROUND - 1), np.arange(2, _AROUND)), -1
    ).astype(np.int32)
    for side in (1.0, -1.0):
        start = sum(len(p) for p in points)
        points.append(rim * radius * _SWELL + up * side)
        normals.append(np.broadcast_to(np.array([0.0, 0.0, side]), (_AROUND, 3)))
        triangles.append(start + (fan if side > 0 else fan[:, ::-1]))
    return np.concatenate(points), np.concatenate(normals), np.concatenate(triangles)


def flat(points: Array, faces: np.ndarray) -> tuple[Array, Array, np.ndarray]:
    """Triangles with their own corners and flat normals; slivers without an area are dropped."""
    corners = points[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=-1)
    kept = length > 1e-14
    corners, normal = corners[kept], normal[kept] / length[kept, None]
    return (
        corners.reshape(-1, 3),
        np.repeat(normal, 3, axis=0),
        np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3),
    )


def creased(points: Array, faces: np.ndarray) -> tuple[Array, Array, np.ndarray]:
    """Triangles shaded smoothly, except across edges sharper than `_CREASE`.

    The normal of a corner is the mean of the faces around it, by area, that differ from its own
    face by less than the crease angle. Corners that end up equal are shared.
    """
    from scipy.sparse import csr_array

    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=-1)
    kept = length > 1e-14
    faces, cross, length = faces[kept], cross[kept], length[kept]
    if not len(faces):
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3), np.int32)
    _, place = np.unique(np.round(points, 6), axis=0, return_inverse=True)
    at = place.reshape(-1)[faces.reshape(-1)]
    face = np.repeat(np.arange(len(faces)), 3)
    around = csr_array((np.ones(len(at)), (at, np.arange(len(at)))))
    own, other = (around.T @ around).nonzero()  # pairs of corners at one place
    unit = cross / length[:, None]
    near = np.einsum("ij,ij->i", unit[face[own]], unit[face[other]]) > np.cos(_CREASE)
    own, other = own[near], other[near]
    normals = np.stack(
        [np.bincount(own, cross[face[other], k], minlength=len(at)) for k in range(3)], axis=-1
    )
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    key = np.column_stack((faces.reshape(-1), np.round(normals * 500).astype(np.int64)))
    _, first, number = np.unique(key, axis=0, return_index=True, return_inverse=True)
    shared = number.reshape(-1, 3).astype(np.int32)
    return points[faces.reshape(-1)[first]], normals[first], shared


def _grid(rings: int, around: int) -> np.ndarray:
    """Triangles between successive rings, counter-clockwise seen from outside, poles included."""
    ring, corner = np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij")
    a = ring * around + corner
    b = ring * around + (corner + 1) % around
    quads = np.stack((a, a + around, b + around, b), axis=-1).reshape(-1, 4)
    return np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]])).astype(np.int32)


def _triangulated(model: mujoco.MjModel, geom: int) -> tuple[Array, Array, np.ndarray] | None:
    """Points, normals and triangles of one geometry in its own frame; None for planes."""
    kinds, size = mujoco.mjtGeom, np.array(model.geom_size[geom])
    match int(model.geom_type[geom]):
        case kinds.mjGEOM_SPHERE:
            return sphere(np.full(3, size[0]))
        case kinds.mjGEOM_ELLIPSOID:
            return sphere(size)
        case kinds.mjGEOM_CAPSULE:
            return sphere(np.full(3, size[0]), float(size[1]))
        case kinds.mjGEOM_CYLINDER:
            return cylinder(float(size[0]), float(size[1]))
        case kinds.mjGEOM_BOX:
            return box(size)
        case kinds.mjGEOM_MESH:
            return _mesh(model, int(model.geom_dataid[geom]))
    return None


def _corners(model: mujoco.MjModel, geom: int) -> Array | None:
    """Points of one geometry's surface in its own frame [m]; None for planes."""
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first = model.mesh_vertadr[mesh]
        return np.array(model.mesh_vert[first : first + model.mesh_vertnum[mesh]], float)
    shape = _triangulated(model, geom)
    return None if shape is None else shape[0]


def _mesh(model: mujoco.MjModel, mesh: int) -> tuple[Array, Array, np.ndarray]:
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    points = np.array(model.mesh_vert[first : first + count], float)
    return creased(points, np.array(model.mesh_face[faces[0] : faces[0] + faces[1]], np.int32))
