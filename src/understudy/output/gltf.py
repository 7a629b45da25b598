"""glTF 2.0 files (GLB): a skinned body on an animated skeleton.

glTF is y up and meters; (x, y, z) becomes (x, z, -y), so that a body that faces +x still does.
Structure follows the Khronos glTF 2.0 specification: one node per joint, one mesh bound to all of
them by a skin, one animation with a rotation channel per joint and a translation channel for the
root, all sampled at the clip's own times. A prop is a node of its own.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from understudy.character import Linkage
from understudy.errors import InvalidValue
from understudy.motion.clip import Clip
from understudy.motion.files import written
from understudy.motion.rotations import Array
from understudy.output import bones, meshes

if TYPE_CHECKING:
    from understudy.character import Character
    from understudy.take import Take

_FLOAT, _UINT, _USHORT, _UBYTE = 5126, 5125, 5123, 5121
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
_CORNERS, _INDICES = 34962, 34963
_BONE_COLOR = np.array([0.85, 0.55, 0.30, 1.0])


@dataclass(frozen=True, kw_only=True)
class Skin:
    """Triangles of one color bound to joints, in the rest pose, z up.

    Attributes:
        points: Corners in the world [m], shape (corners, 3).
        normals: Unit normals, shape (corners, 3).
        joints: Joint that carries each corner, shape (corners,).
        triangles: Corner numbers, shape (triangles, 3).
        color: sRGB and opacity 0..1, shape (4,).
    """

    points: Array
    normals: Array
    joints: np.ndarray
    triangles: np.ndarray
    color: Array


@dataclass(frozen=True, kw_only=True)
class Solid:
    """A rigid thing beside the body, a node of its own: a prop.

    Attributes:
        name: Of the node.
        surfaces: Its triangles, in its own frame.
        joint: Number of the joint that holds it, or None.
        positions: Place in the joint's frame or the world [m], z up: (3,), or (frames, 3) where it
            moves.
        rotations: Orientation, wxyz: (4,) or (frames, 4).
    """

    name: str
    surfaces: tuple[meshes.Surface, ...]
    joint: int | None = None
    positions: Array
    rotations: Array


def write_glb(
    clip: Clip,
    path: str | PathLike[str],
    *,
    character: Character | Linkage | None = None,
    solids: Sequence[Solid] = (),
) -> None:
    """Write a clip as a GLB file.

    Args:
        clip: The motion; with a character, on that character's skeleton.
        path: The file to write.
        character: Its visible shapes become the skin; without one, the bones do.
        solids: Things beside it; of a take see `solids_of`.

    Raises:
        InvalidValue: The clip's skeleton is not the character's, or the numbers are too large for
            the format.
        UnderstudyError: The file cannot be written.
    """
    data = encoded(clip, character=character, solids=solids)
    with written(path) as temporary:
        temporary.write_bytes(data)


def encoded(
    clip: Clip,
    *,
    character: Character | Linkage | None = None,
    solids: Sequence[Solid] = (),
) -> bytes:
    """A GLB file's bytes; see `write_glb`."""
    if max(np.abs(clip.root_positions).max(), np.abs(clip.skeleton.offsets).max()) > 1e30:
        raise InvalidValue("Positions beyond 1e30 m do not fit into a glTF file.")
    # The bones of a linkage are its shapes.
    if character is None or isinstance(character, Linkage):
        skins = _bone_skin(clip)
    else:
        skins = character_skin(clip, character)
    file = _File()
    names, parents = clip.skeleton.names, clip.skeleton.parents
    offsets = y_up(clip.skeleton.offsets)
    nodes: list[dict[str, Any]] = [
        {"name": name, "translation": _numbers(offset)}
        for name, offset in zip(names, offsets, strict=True)
    ]
    for i, parent in enumerate(parents):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(i)
    nodes.append({"name": f"{clip.name} body", "mesh": 0, "skin": 0})
    materials, primitives = [], []
    for skin in skins:
        primitives.append(_primitive(file, skin, len(materials)))
        materials.append(_material(skin.color, len(materials)))
    animation = _animation(file, clip)
    shapes, roots = [{"name": "body", "primitives": primitives}], [0, len(names)]
    for solid in solids:
        node = _solid(file, solid, materials, shapes)
        if solid.joint is None:
            roots.append(len(nodes))
        else:
            nodes[solid.joint].setdefault("children", []).append(len(nodes))
        if np.ndim(solid.positions) == 2:
            _animate(file, animation, solid, len(nodes))
        nodes.append(node)
    inverse = np.tile(np.eye(4), (len(names), 1, 1))
    inverse[:, 3, :3] = -y_up(clip.skeleton.rest_positions())  # column-major: row 3 translates
    document = {
        "asset": {"version": "2.0", "generator": "Understudy"},
        "scene": 0,
        "scenes": [{"name": clip.name, "nodes": roots}],
        "nodes": nodes,
        "meshes": shapes,
        "materials": materials,
        "skins": [
            {
                "name": "skeleton",
                "inverseBindMatrices": file.add(inverse.reshape(-1, 16), _FLOAT),
                "skeleton": 0,
                "joints": list(range(len(names))),
            }
        ],
        "animations": [animation],
    }
    return file.packed(document)


def solids_of(take: Take, character: int = 0, *, rate: float) -> tuple[Solid, ...]:
    """The props of a take beside one of its characters, at a clip's rate [Hz].

    What that character holds hangs on its hand's node and moves with it; what is loose or held by
    another has an animation; what is fixed has a place. Planes are left out.
    """
    model, part = take.model, take.scene.parts[character]
    bodies = {body for one in take.scene.parts for body in one.bodies}
    by_body: dict[int, list[meshes.Surface]] = {}
    for surface in meshes.surfaces(model):
        if surface.body not in bodies:
            by_body.setdefault(surface.body, []).append(surface)
    _, placed, turned = take.poses(rate) if by_body else (None, np.zeros(0), np.zeros(0))
    joints = isinstance(take.scene.characters[character], Linkage)
    out = []
    for body, held in sorted(by_body.items()):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) if body else "ground"
        parent, joint = int(model.body_parentid[body]), None
        if parent in part.bodies and not joints:
            joint = part.bodies.index(parent)
            place, turn = np.array(model.body_pos[body]), np.array(model.body_quat[body])
        elif model.body_weldid[body] == 0:
            place, turn = placed[0, body], turned[0, body]
        else:
            place, turn = placed[:, body], turned[:, body]
        out.append(
            Solid(name=name, surfaces=tuple(held), joint=joint, positions=place, rotations=turn)
        )
    return tuple(out)


def character_skin(clip: Clip, character: Character) -> tuple[Skin, ...]:
    """The shapes of a character's links, one skin per color, bound to the joints of `clip`.

    Raises:
        InvalidValue: The clip is not on the character's skeleton.
    """
    joints = [link.joint for link in character.links]
    if list(clip.skeleton.names) != joints:
        raise InvalidValue(
            f"The clip has the joints {', '.join(clip.skeleton.names[:4])}, ...; the character "
            f"has {', '.join(joints[:4])}, .... Retarget the clip to the character first."
        )
    model = character.spec().compile()
    number = {int(model.body(link.name).id): k for k, link in enumerate(character.links)}
    rest = clip.skeleton.rest_positions()
    by_color: dict[bytes, list[tuple[int, meshes.Surface]]] = {}
    for surface in meshes.surfaces(model):
        if surface.body in number:
            key = np.round(surface.color, 4).tobytes()
            by_color.setdefault(key, []).append((number[surface.body], surface))
    if not by_color:
        return _bone_skin(clip)
    skins = []
    for parts in by_color.values():
        starts = np.cumsum([0] + [len(s.points) for _, s in parts])
        skins.append(
            Skin(
                points=np.concatenate([s.points + rest[k] for k, s in parts]),
                normals=np.concatenate([s.normals for _, s in parts]),
                joints=np.concatenate([np.full(len(s.points), k) for k, s in parts]),
                triangles=np.concatenate(
                    [s.triangles + start for start, (_, s) in zip(starts, parts, strict=False)]
                ),
                color=parts[0][1].color,
            )
        )
    return tuple(skins)


def y_up(vectors: Array) -> Array:
    """Vectors (..., 3) turned from z up to y up."""
    vectors = np.asarray(vectors)
    return np.stack((vectors[..., 0], vectors[..., 2], -vectors[..., 1]), axis=-1)


def y_up_xyzw(rotations: Array) -> Array:
    """Rotations wxyz (..., 4) between z-up frames as xyzw between y-up frames."""
    return np.concatenate((y_up(rotations[..., 1:]), rotations[..., :1]), axis=-1)


def _bone_skin(clip: Clip) -> tuple[Skin, ...]:
    points, joints, triangles = bones.octahedra(clip.skeleton)
    corners, normals, faces = meshes.flat(points, triangles)
    # `flat` keeps the order of triangles that have an area, and all octahedra's do.
    return (
        Skin(
            points=corners,
            normals=normals,
            joints=joints[triangles].reshape(-1),
            triangles=faces,
            color=_BONE_COLOR,
        ),
    )


def _primitive(file: _File, skin: Skin, material: int) -> dict[str, Any]:
    count = len(skin.points)
    carried = np.zeros((count, 4), int)
    carried[:, 0] = skin.joints
    weights = np.zeros((count, 4))
    weights[:, 0] = 1.0
    small = int(skin.joints.max(initial=0)) < 256
    return {
        "attributes": {
            "POSITION": file.add(y_up(skin.points), _FLOAT, target=_CORNERS, bounds=True),
            "NORMAL": file.add(_unit(y_up(skin.normals)), _FLOAT, target=_CORNERS),
            "JOINTS_0": file.add(carried, _UBYTE if small else _USHORT, target=_CORNERS),
            "WEIGHTS_0": file.add(weights, _FLOAT, target=_CORNERS),
        },
        "indices": file.add(
            skin.triangles.reshape(-1, 1), _USHORT if count < 65535 else _UINT, target=_INDICES
        ),
        "material": material,
    }


def _material(color: Array, number: int) -> dict[str, Any]:
    srgb = np.asarray(color[:3], float)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    out: dict[str, Any] = {
        "name": f"color {number + 1}",
        "pbrMetallicRoughness": {
            "baseColorFactor": _numbers(np.clip([*linear, color[3]], 0.0, 1.0)),
            "metallicFactor": 0.0,
            "roughnessFactor": 0.7,
        },
    }
    if color[3] < 1.0:
        out["alphaMode"] = "BLEND"
    return out


def _solid(
    file: _File, solid: Solid, materials: list[dict[str, Any]], shapes: list[dict[str, Any]]
) -> dict[str, Any]:
    """The node of a thing at its first place; its mesh and materials are added to the file."""
    primitives = []
    for surface in solid.surfaces:
        primitives.append(
            {
                "attributes": {
                    "POSITION": file.add(
                        y_up(surface.points), _FLOAT, target=_CORNERS, bounds=True
                    ),
                    "NORMAL": file.add(_unit(y_up(surface.normals)), _FLOAT, target=_CORNERS),
                },
                "indices": file.add(
                    np.array(surface.triangles, float).reshape(-1, 1),
                    _USHORT if len(surface.points) < 65535 else _UINT,
                    target=_INDICES,
                ),
                "material": len(materials),
            }
        )
        materials.append(_material(surface.color, len(materials)))
    shapes.append({"name": solid.name, "primitives": primitives})
    place, turn = np.atleast_2d(solid.positions)[0], np.atleast_2d(solid.rotations)[0]
    return {
        "name": solid.name,
        "mesh": len(shapes) - 1,
        "translation": _numbers(y_up(place)),
        "rotation": _numbers(_unit(y_up_xyzw(turn))),
    }


def _animate(file: _File, animation: dict[str, Any], solid: Solid, node: int) -> None:
    """Channels that move a loose thing along; its poses are at the clip's times."""
    samplers, channels = animation["samplers"], animation["channels"]
    times = samplers[0]["input"]
    moves = (
        ("translation", y_up(solid.positions)),
        ("rotation", _unit(y_up_xyzw(solid.rotations))),
    )
    for path, values in moves:
        channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
        samplers.append({"input": times, "output": file.add(values, _FLOAT)})


def _animation(file: _File, clip: Clip) -> dict[str, Any]:
    times = file.add(clip.times[:, None], _FLOAT, bounds=True)
    turned = _unit(y_up_xyzw(clip.rotations))
    samplers = [{"input": times, "output": file.add(y_up(clip.root_positions), _FLOAT)}]
    channels = [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]
    for joint in range(len(clip.skeleton)):
        channels.append({"sampler": len(samplers), "target": {"node": joint, "path": "rotation"}})
        samplers.append({"input": times, "output": file.add(turned[:, joint], _FLOAT)})
    return {"name": clip.name, "samplers": samplers, "channels": channels}


@dataclass
class _File:
    """Binary data of a GLB file and the accessors into it."""

    blocks: list[bytes] = field(default_factory=list)
    length: int = 0
    views: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)

    def add(
        self, values: Array, kind: int, *, target: int | None = None, bounds: bool = False
    ) -> int:
        """Append an array (count, components); the number of its accessor."""
        types = {_FLOAT: "<f4", _UINT: "<u4", _USHORT: "<u2", _UBYTE: "u1"}
        stored = np.ascontiguousarray(values, types[kind])
        view: dict[str, Any] = {
            "buffer": 0,
            "byteOffset": self.length,
            "byteLength": stored.nbytes,
        }
        if target is not None:
            view["target"] = target
        accessor: dict[str, Any] = {
            "bufferView": len(self.views),
            "componentType": kind,
            "count": len(stored),
            "type": _TYPES[stored.shape[1]],
        }
        if bounds:  # of the stored numbers, which are rounded to 32 bits
            accessor["min"] = [float(v) for v in stored.min(axis=0)]
            accessor["max"] = [float(v) for v in stored.max(axis=0)]
        block = stored.tobytes()
        block += b"\0" * (-len(block) % 4)
        self.blocks.append(block)
        self.length += len(block)
        self.views.append(view)
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def packed(self, document: dict[str, Any]) -> bytes:
        """The file: header, JSON chunk and binary chunk, each padded to four bytes."""
        document |= {
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.length}],
        }
        text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        body = b"".join(self.blocks)
        total = 12 + 8 + len(text) + 8 + len(body)
        if total >= 2**32:
            raise InvalidValue(f"The file would have {total} bytes; GLB ends at 4 GiB.")
        return b"".join(
            (
                struct.pack("<4sII", b"glTF", 2, total),
                struct.pack("<I4s", len(text), b"JSON"),
                text,
                struct.pack("<I4s", len(body), b"BIN\0"),
                body,
            )
        )


def _unit(vectors: Array) -> Array:
    """Vectors of unit length after rounding to 32 bits, which is what a validator measures."""
    vectors = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors.astype(np.float32).astype(float)


def _numbers(values: Any) -> list[float]:
    return [float(np.float32(v)) for v in values]
