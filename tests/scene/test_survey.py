"""The floor read off a clip: level stays level, slopes and steps are found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.character import Character, adult_man, retargeted
from understudy.character.planting import planted
from understudy.character.soles import standing
from understudy.feasibility import assess
from understudy.motion.clip import Clip
from understudy.motion.samples import sample
from understudy.performance import tracked
from understudy.scene import Block, Ground, Steps
from understudy.scene.survey import surveyed


@pytest.fixture(scope="module")
def man() -> Character:
    return adult_man()


@pytest.fixture(scope="module")
def walk(man: Character) -> Clip:
    return retargeted(sample("walk"), man)


def on(walk: Clip, man: Character, ground: Ground) -> Clip:
    """The walk as it would have been captured on that ground."""
    return planted(standing(walk, man, ground=ground), man, ground=ground)


@pytest.mark.parametrize("name", ["walk", "bow", "gesture"])
def test_level_stays_level(name, man):
    assert surveyed(retargeted(sample(name), man), man) == (Ground(), "")


def test_the_height_of_the_capture_does_not_matter(man, walk):
    high = replace(walk, root_positions=walk.root_positions + np.array([0.0, 0.0, 0.7]))
    assert surveyed(high, man)[0].level


@pytest.mark.parametrize("degrees", [6.0, -6.0])
def test_a_slope_is_found_again(man, walk, degrees):
    made = Ground(slope=np.radians(degrees))
    found, note = surveyed(on(walk, man, made), man)
    assert not found.blocks
    np.testing.assert_allclose(found.normal, made.normal, atol=np.sin(np.radians(1.5)))
    assert "slopes: " in note


def test_a_foot_held_up_stands_on_nothing(man):
    """One leg is folded all the while; what it hangs over is no step."""
    clip = sample("gesture").trimmed(0.0, 2.0)
    own = retargeted(clip, man)
    turned = np.array(own.rotations)
    for joint, angle in (("right_hip", -1.2), ("right_knee", 1.2)):
        turned[:, man.index(joint)] = [np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0]
    assert surveyed(replace(own, rotations=turned), man)[0].level


def test_a_block_is_ground_on_top_and_nowhere_else():
    block = Block(position=(1.0, 2.0), height=0.3, length=0.4, width=0.8, heading=0.5)
    ground = Ground(blocks=(block,))
    assert not ground.level
    ahead, aside = np.array([np.cos(0.5), np.sin(0.5)]), np.array([-np.sin(0.5), np.cos(0.5)])
    middle = np.array([1.0, 2.0])
    assert ground.height(middle + 0.19 * ahead + 0.39 * aside) == 0.3
    assert ground.height(middle + 0.21 * ahead) == 0.0
    assert ground.height(middle + 0.41 * aside) == 0.0
    model = us.Scene(characters=(adult_man(),), ground=ground).model
    box = model.geom("ground/block1")
    assert box.pos[2] + box.size[2] == pytest.approx(0.3)
    assert box.pos[2] - box.size[2] == pytest.approx(0.0)


@pytest.mark.parametrize(("field", "bad"), [("height", 0.0), ("length", -1.0), ("width", np.nan)])
def test_blocks_of_wrong_sizes_are_refused(field, bad):
    with pytest.raises(us.UnderstudyError, match=field):
        Block(**{"position": (0.0, 0.0), "height": 0.2, field: bad})


def test_a_take_on_blocks_is_read_back(tmp_path, man):
    ground = Ground(blocks=(Block(position=(3.0, 0.0), height=0.2),))
    take = us.track(sample("gesture").trimmed(0.0, 0.2), man, ground=ground)
    us.write(take, tmp_path / "a.npz")
    assert us.load_take(tmp_path / "a.npz").scene.ground == ground


@pytest.mark.clips
def test_three_steps_up_and_down_are_found(clips):
    clip = us.read(clips / "cmu_asfamc" / "14_21.amc")
    body = Character.from_clip(clip)
    performance = tracked(clip, body)
    ground = performance.scene.ground
    assert ground is not None
    np.testing.assert_allclose([b.height for b in ground.blocks], [0.22, 0.41, 0.64], atol=0.02)
    level = tracked(clip, body, ground=Ground())
    assert assess(performance).score < 5.0 < 60.0 < assess(level).score


@pytest.mark.clips
@pytest.mark.parametrize("name", ["02_01", "29_01", "49_02", "49_19", "02_05", "35_17"])
def test_captures_on_a_level_floor_stay_level(name, clips):
    clip = us.read(clips / "cmu_bvh" / f"{name}.bvh")
    body = Character.from_clip(clip)
    assert surveyed(retargeted(clip.repaired(), body), body)[0].level


def test_steps_climbed_are_found_again(man, walk):
    """A walk set on one step: its feet stand on it from there on."""
    made = Ground(steps=Steps(position=(1.0, 0.0), rise=0.16, run=1.0, count=1, landing=9.0))
    found, note = surveyed(on(walk, man, made), man)
    assert found.blocks
    assert found.blocks[0].height == pytest.approx(0.16, abs=0.03)
    assert note.startswith("Feet stand on things")
