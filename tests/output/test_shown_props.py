"""Props are shown wherever a take is: once each, where they are, moving as they move."""

from __future__ import annotations

import json
import re
import struct
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from understudy.character.bodies import adult_man
from understudy.motion.samples import sample
from understudy.output import meshes
from understudy.output.gltf import encoded, solids_of
from understudy.output.pictures import still
from understudy.output.playback import playback, props_of
from understudy.output.player import player_html
from understudy.output.take_file import load_take, save_take
from understudy.performance import tracked
from understudy.scene import Ball, Box, Drum, Ground, Staff, Steps, Table
from understudy.simulate import simulate
from understudy.take import Take

PROPS = (
    Drum(position=(0.5, -0.3, 0.95), normal=(0.2, 0.0, 1.0)),
    Table(position=(0.9, 0.6), heading=0.3),
    Box(position=(0.9, 0.6, 0.9), mass=1.5),
    Staff(held_by="left_hand"),
    Ball(position=(0.6, -0.8, 0.7)),
)


@pytest.fixture(scope="module")
def propped() -> Take:
    """A third of a second of a gesture among props and a step."""
    whole = tracked(
        sample("gesture").trimmed(0.0, 0.35),
        adult_man(),
        props=PROPS,
        contacts=(("box", "table"),),
        ground=Ground(),
    )
    steps = Ground(steps=Steps(position=(3.0, 0.0)))
    return simulate(replace(whole, scene=replace(whole.scene, ground=steps)))


def test_a_take_file_brings_back_props_contacts_and_steps(propped: Take, tmp_path: Path):
    save_take(propped, tmp_path / "take.npz")
    back = load_take(tmp_path / "take.npz")
    assert back.scene.props == propped.scene.props
    assert back.scene.contacts == propped.scene.contacts
    assert back.scene.ground == propped.scene.ground
    np.testing.assert_array_equal(back.qpos, propped.qpos)


def test_the_ghost_shows_the_performer_and_no_prop(propped: Take):
    shown = playback(propped)
    names = [propped.model.body(i).name for i in shown.ghost_bodies]
    assert "right_hand" in names
    assert not {p.name for p in PROPS} & set(names)
    loose = {propped.model.body(i).name for i in props_of(propped)}
    assert loose == {"drum", "table", "box", "ball"}


def test_a_ball_that_rolls_away_does_not_shrink_the_picture(propped: Take):
    far = np.array(propped.qpos)
    start = propped.model.joint("ball").qposadr[0]
    far[:, start] += np.linspace(0.0, 50.0, len(far))
    near = playback(propped).shot("follow", 1.0).distance
    assert playback(replace(propped, qpos=far)).shot("follow", 1.0).distance < 1.6 * near


def test_a_prop_near_the_performer_changes_the_picture(propped: Take):
    bare = replace(propped, scene=replace(propped.scene, props=(), contacts=()))
    bare = replace(
        bare,
        model=bare.scene.model,
        qpos=propped.qpos[:, : bare.scene.model.nq],
        qvel=propped.qvel[:, : bare.scene.model.nv],
        qfrc_applied=propped.qfrc_applied[:, : bare.scene.model.nv],
    )
    size = {"width": 96, "height": 96, "ghost": "none"}
    with_props = still(propped, 0.2, **size).pixels.astype(int)
    without = still(bare, 0.2, **size).pixels.astype(int)
    assert np.abs(with_props - without).max() > 60


def page_data(take: Take) -> dict:
    found = re.search(r"const take = (\{.*?\});\n", player_html(take))
    assert found is not None
    return json.loads(found.group(1))


def test_the_player_has_every_prop_once_and_no_ghost_of_it(propped: Take):
    data = page_data(propped)
    for prop in PROPS:
        body = data["bodies"][propped.model.body(prop.name).id]
        assert body["count"] > 0 and not body["ghost"]
    # Steps belong to the world, which is drawn too.
    assert data["bodies"][0]["count"] > 0
    assert data["ground"] == 0.0


def test_the_player_shows_a_slope_as_tiles(propped: Take):
    slope = replace(propped.scene, ground=Ground(slope=0.1))
    data = page_data(replace(propped, scene=slope, model=slope.model))
    assert data["ground"] is None
    assert data["bodies"][0]["count"] == 2 * 3 * 40 * 40
    placed = slope.ground
    assert placed is not None
    for tile in meshes.tiles(slope.model, slope.model.geom("ground").id, np.array([3.0, 2.0, 0.3])):
        np.testing.assert_allclose(tile.points[:, 2], placed.height(tile.points), atol=1e-9)


def document(data: bytes) -> dict:
    (size,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + size])


def test_a_glb_has_a_node_for_every_prop(propped: Take):
    clip = propped.clip()
    solids = solids_of(propped, rate=clip.rate)
    file = document(encoded(clip, character=propped.scene.characters[0], solids=solids))
    nodes = {node["name"]: k for k, node in enumerate(file["nodes"])}
    assert {p.name for p in PROPS} <= set(nodes)
    assert len(file["nodes"]) == len(nodes)
    # Held: under the wrist's node. Loose: two channels. Fixed: neither.
    hand = file["nodes"][nodes["left_wrist"]]
    assert nodes["staff"] in hand["children"]
    moved = [c["target"]["node"] for c in file["animations"][0]["channels"]]
    assert moved.count(nodes["ball"]) == moved.count(nodes["box"]) == 2
    assert not {nodes["staff"], nodes["drum"], nodes["table"]} & set(moved)
    roots = set(file["scenes"][0]["nodes"])
    assert {nodes[name] for name in ("ball", "box", "drum", "table", "ground")} <= roots
    assert nodes["staff"] not in roots
    for accessor in file["accessors"]:
        assert accessor["count"] > 0


def test_the_poses_in_a_glb_are_those_of_the_take(propped: Take):
    clip = propped.clip()
    solids = {s.name: s for s in solids_of(propped, rate=clip.rate)}
    model, data = propped.model, mujoco.MjData(propped.model)
    for frame in (0, clip.frames - 1):
        data.qpos[:] = propped.qpos[frame * propped.stride(clip.rate)]
        mujoco.mj_kinematics(model, data)
        np.testing.assert_allclose(
            solids["ball"].positions[frame], data.body("ball").xpos, atol=1e-12
        )
    assert len(solids["ball"].positions) == clip.frames
    np.testing.assert_allclose(solids["drum"].positions, PROPS[0].position)
