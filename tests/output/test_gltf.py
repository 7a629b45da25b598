"""GLB files read back: structure, bounds, and the same motion."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.skeleton import Skeleton
from understudy.output.gltf import encoded, write_glb, y_up
from understudy.take import Take

KINDS = {5126: "<f4", 5125: "<u4", 5123: "<u2", 5121: "u1"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Glb:
    """A GLB file taken apart by the letter of the specification."""

    def __init__(self, data: bytes):
        magic, version, length = struct.unpack_from("<4sII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        size, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON" and size % 4 == 0
        self.json: dict[str, Any] = json.loads(data[20 : 20 + size])
        body, kind = struct.unpack_from("<I4s", data, 20 + size)
        assert kind == b"BIN\0" and 28 + size + body == len(data)
        self.bin = data[28 + size :]
        assert self.json["buffers"] == [{"byteLength": body}]

    def array(self, number: int) -> np.ndarray:
        accessor = self.json["accessors"][number]
        view = self.json["bufferViews"][accessor["bufferView"]]
        width = WIDTHS[accessor["type"]]
        kind = np.dtype(KINDS[accessor["componentType"]])
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] == accessor["count"] * width * kind.itemsize
        assert view["byteOffset"] + view["byteLength"] <= len(self.bin)
        flat = np.frombuffer(self.bin, kind, accessor["count"] * width, view["byteOffset"])
        return flat.reshape(-1, width)

    def primitives(self) -> list[dict[str, Any]]:
        return self.json["meshes"][0]["primitives"]

    def joint_matrices(self, frame: int | None) -> np.ndarray:
        """World matrices of the joints at a frame, or at rest, by the nodes alone; y up."""
        nodes, skin = self.json["nodes"], self.json["skins"][0]
        local = {}
        for i in skin["joints"]:
            local[i] = [np.array(nodes[i]["translation"]), np.array([0.0, 0.0, 0.0, 1.0])]
        animation = self.json["animations"][0]
        for channel in animation["channels"] if frame is not None else []:
            values = self.array(animation["samplers"][channel["sampler"]]["output"])
            slot = {"translation": 0, "rotation": 1}[channel["target"]["path"]]
            local[channel["target"]["node"]][slot] = values[frame]
        world = {}

        def visit(node: int, parent: np.ndarray) -> None:
            matrix = np.eye(4)
            shift, turn = local[node]
            matrix[:3, :3] = rot.to_matrix(np.roll(turn, 1))
            matrix[:3, 3] = shift
            world[node] = parent @ matrix
            for child in nodes[node].get("children", []):
                visit(child, world[node])

        visit(self.json["scenes"][0]["nodes"][0], np.eye(4))
        return np.array([world[i] for i in skin["joints"]])


@pytest.fixture(scope="module")
def file(take: Take) -> Glb:
    return Glb(encoded(take.clip(), character=take.scene.characters[0]))


def test_nodes_move_the_joints_as_the_clip_does(file: Glb, take: Take) -> None:
    clip = take.clip()
    pose = clip.forward_kinematics()
    for frame in (0, 37, clip.frames - 1):
        positions = file.joint_matrices(frame)[:, :3, 3]
        assert positions == pytest.approx(y_up(pose.positions[frame]), abs=2e-6)


def test_times_are_exact_at_the_rate_of_the_clip(file: Glb, take: Take) -> None:
    clip = take.clip()
    for sampler in file.json["animations"][0]["samplers"]:
        times = file.array(sampler["input"])[:, 0]
        assert np.array_equal(times, clip.times.astype(np.float32))


def test_every_joint_turns_and_only_the_root_travels(file: Glb, take: Take) -> None:
    channels = file.json["animations"][0]["channels"]
    joints = set(file.json["skins"][0]["joints"])
    turned = {c["target"]["node"] for c in channels if c["target"]["path"] == "rotation"}
    moved = {c["target"]["node"] for c in channels if c["target"]["path"] == "translation"}
    assert turned == joints and moved == {0}
    names = tuple(file.json["nodes"][i]["name"] for i in file.json["skins"][0]["joints"])
    assert names == take.scene.characters[0].skeleton.names


def test_rotations_are_unit_and_take_no_long_way_round(file: Glb) -> None:
    animation = file.json["animations"][0]
    for channel in animation["channels"]:
        if channel["target"]["path"] == "rotation":
            turned = file.array(animation["samplers"][channel["sampler"]]["output"])
            assert np.linalg.norm(turned, axis=1) == pytest.approx(1.0, abs=1e-6)
            assert (np.sum(turned[1:] * turned[:-1], axis=1) > 0).all()


def test_inverse_bind_matrices_undo_the_rest_pose(file: Glb) -> None:
    inverse = file.array(file.json["skins"][0]["inverseBindMatrices"]).reshape(-1, 4, 4)
    rest = file.joint_matrices(None)
    product = rest @ inverse.transpose(0, 2, 1)
    assert product == pytest.approx(np.broadcast_to(np.eye(4), product.shape), abs=1e-5)


def test_skin_is_complete_and_within_its_bounds(file: Glb) -> None:
    joints = len(file.json["skins"][0]["joints"])
    for primitive in file.primitives():
        at = primitive["attributes"]
        points, normals = file.array(at["POSITION"]), file.array(at["NORMAL"])
        carried, weights = file.array(at["JOINTS_0"]), file.array(at["WEIGHTS_0"])
        indices = file.array(primitive["indices"])
        assert len(points) == len(normals) == len(carried) == len(weights)
        assert indices.max() == len(points) - 1 and len(indices) % 3 == 0
        assert carried.max() < joints
        assert weights.sum(axis=1) == pytest.approx(1.0)
        assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-5)
        accessor = file.json["accessors"][at["POSITION"]]
        assert accessor["min"] == points.min(axis=0).tolist()
        assert accessor["max"] == points.max(axis=0).tolist()


def test_rest_pose_stands_upright_on_the_floor(file: Glb) -> None:
    points = np.concatenate([file.array(p["attributes"]["POSITION"]) for p in file.primitives()])
    assert points[:, 1].min() == pytest.approx(0.0, abs=0.05)
    assert points[:, 1].max() == pytest.approx(1.75, abs=0.12)


def test_skinned_points_follow_the_links(file: Glb, take: Take) -> None:
    """A corner of a foot, moved by the file's own matrices, is where the engine's body has it."""
    from understudy.output import meshes

    times, placed, turned = take.poses(take.clip().rate)
    frame = 50
    inverse = file.array(file.json["skins"][0]["inverseBindMatrices"]).reshape(-1, 4, 4)
    matrices = file.joint_matrices(frame) @ inverse.transpose(0, 2, 1)
    moved = []
    for primitive in file.primitives():
        points = file.array(primitive["attributes"]["POSITION"])
        joint = file.array(primitive["attributes"]["JOINTS_0"])[:, 0]
        moved.append(
            np.einsum(
                "nij,nj->ni", matrices[joint], np.column_stack((points, np.ones(len(points))))
            )
        )
    glb = np.concatenate(moved)[:, :3]
    engine = np.concatenate(
        [
            placed[frame, s.body] + rot.rotate(turned[frame, s.body], s.points)
            for s in meshes.surfaces(take.model)
        ]
    )
    assert glb.min(axis=0) == pytest.approx(y_up(engine).min(axis=0), abs=1e-4)
    assert glb.max(axis=0) == pytest.approx(y_up(engine).max(axis=0), abs=1e-4)
    assert glb.mean(axis=0) == pytest.approx(y_up(engine).mean(axis=0), abs=1e-4)
    assert times[frame] > 0


def test_clip_alone_gets_its_bones_as_octahedra(clip: Clip) -> None:
    alone = Glb(encoded(clip))
    skeleton = clip.skeleton
    bones = sum(np.linalg.norm(skeleton.offsets[1:], axis=1) > 1e-4) + len(skeleton.end_joints)
    (primitive,) = alone.primitives()
    assert len(alone.array(primitive["indices"])) == bones * 8 * 3


def test_single_joint_and_single_frame_make_a_file() -> None:
    dot = Clip(
        skeleton=Skeleton(names=("root",), parents=(-1,), offsets=np.zeros((1, 3))),
        rotations=rot.identity(1, 1),
        root_positions=np.zeros((1, 3)),
        rate=30.0,
    )
    assert Glb(encoded(dot)).json["accessors"][0]["count"] > 0


def test_skeleton_with_many_joints_gets_wider_numbers() -> None:
    count = 300
    chain = Clip(
        skeleton=Skeleton(
            names=tuple(f"j{i}" for i in range(count)),
            parents=tuple(range(-1, count - 1)),
            offsets=np.tile([0.0, 0.0, 0.01], (count, 1)),
        ),
        rotations=rot.identity(2, count),
        root_positions=np.zeros((2, 3)),
        rate=30.0,
    )
    read = Glb(encoded(chain))
    (primitive,) = read.primitives()
    assert read.array(primitive["attributes"]["JOINTS_0"]).max() == count - 2


def test_clip_of_another_skeleton_is_refused(take: Take, tmp_path: Path) -> None:
    stranger = Clip(
        skeleton=Skeleton(names=("a",), parents=(-1,), offsets=np.zeros((1, 3))),
        rotations=rot.identity(2, 1),
        root_positions=np.zeros((2, 3)),
        rate=30.0,
    )
    with pytest.raises(InvalidValue, match="Retarget"):
        write_glb(stranger, tmp_path / "x.glb", character=take.scene.characters[0])
    assert not list(tmp_path.iterdir())
