"""Clips set on uneven ground: soles on it, the path along it, level ground as before."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.character import Character, adult_man, retargeted
from understudy.character.planting import planted
from understudy.character.soles import STANDS, sole_paths, sole_points, standing
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.motion.samples import sample
from understudy.scene import Block, Ground, Steps


@pytest.fixture(scope="module")
def man() -> Character:
    return adult_man()


@pytest.fixture(scope="module")
def walk(man: Character) -> Clip:
    return retargeted(sample("walk").trimmed(0.0, 3.0), man)


def over(clip: Clip, body: Character, ground: Ground) -> Array:
    """Height of every sole point over the ground [m], shape (frames, points)."""
    pose, out = clip.forward_kinematics(), []
    for link, center, radius in sole_points(body):
        place = pose.positions[:, link] + rot.rotate(pose.rotations[:, link], center)
        out.append(place[:, 2] - radius - ground.height(place))
    return np.stack(out, axis=1)


@pytest.mark.parametrize("degrees", [5.0, -5.0])
@pytest.mark.parametrize("heading", [0.0, np.pi / 2])
def test_a_walk_follows_a_slope_with_its_soles_on_it(man, walk, degrees, heading):
    ground = Ground(slope=np.radians(degrees), heading=heading)
    path = planted(standing(walk, man, ground=ground), man, ground=ground)
    lowest = over(path, man, ground).min(axis=1)
    # Within twice what a clip may stand off the floor (`STANDS`).
    assert np.abs(np.quantile(lowest, [0.02, 0.98])).max() < 2 * STANDS
    # The body stays as high over the slope as it was over the floor, less what bent knees take.
    gained = path.root_positions[:, 2] - ground.height(path.root_positions)
    assert np.abs(gained - gained.mean()).max() < 0.06
    np.testing.assert_array_equal(path.root_positions[:, :2], walk.root_positions[:, :2])


def test_feet_tilt_with_the_slope(man, walk):
    ground = Ground(slope=np.radians(8.0))
    level, tilted = standing(walk, man), standing(walk, man, ground=ground)
    foot = [link.joint for link in man.links].index("left_ankle")
    before = level.forward_kinematics().rotations[:, foot]
    after = tilted.forward_kinematics().rotations[:, foot]
    turned = rot.multiply(after, rot.conjugate(before))
    np.testing.assert_allclose(rot.angle(turned), np.radians(8.0), atol=1e-9)


def test_steps_that_are_elsewhere_change_little(man, walk):
    ground = Ground(steps=Steps(position=(50.0, 0.0)))
    there = planted(standing(walk, man, ground=ground), man, ground=ground)
    level = planted(standing(walk, man), man)
    assert np.abs(there.root_positions - level.root_positions).max() < 0.03
    assert np.abs(over(there, man, ground).min(axis=1)).max() < 0.004


def test_without_a_ground_nothing_changes(man, walk):
    once, twice = planted(standing(walk, man), man), planted(standing(walk, man), man, ground=None)
    np.testing.assert_array_equal(once.rotations, twice.rotations)
    np.testing.assert_array_equal(once.root_positions, twice.root_positions)


@pytest.mark.parametrize("start", [1.5, 2.2, 2.9])
def test_no_sole_meets_the_edge_of_a_block_on_the_way_down(man, walk, start):
    """Not at its points, and not between heel and ball as a foot rolls over the edge."""
    block = Block(position=(start - 5.0, 0.0), height=0.2, length=10.0, width=9.0)
    ground = Ground(blocks=(block,))
    path = planted(standing(walk, man, ground=ground), man, ground=ground)
    assert np.ptp(ground.height(path.root_positions)) == 0.2
    for side in ("left", "right"):
        points = sole_paths(path, man, side=side)
        middle = 0.5 * (points[:, :-2] + points[:, 2:])
        sole = np.concatenate((points, middle), axis=1)
        assert (sole[..., 2] - ground.height(sole)).min() > -0.01
