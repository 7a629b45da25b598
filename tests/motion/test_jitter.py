"""A joint that shakes is steadied, and what hangs on it does not notice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from understudy.motion import rotations as rot
from understudy.motion.jitter import steadied
from understudy.motion.repair import repair
from understudy.motion.samples import sample, samples

RATE = 120.0
FRAMES = 240
# A root with a thigh on a rigid hip, and a trunk.
PARENTS = (-1, 0, 1, 0)


def shaken(center=(0.0, 0.0, 0.0), degrees=10.0, frames=(60,)):
    """Rotations and path of a root that turns and walks, shaken about a point of it; and calm."""
    times = np.arange(FRAMES) / RATE
    calm = rot.from_rotvec(np.stack([0.0 * times, 0.2 * times, 1.5 * times], axis=1))
    path = np.stack([1.2 * times, 0.0 * times, 1.0 + 0.0 * times], axis=1)
    root = calm.copy()
    root[list(frames)] = rot.multiply(
        root[list(frames)], rot.from_rotvec([np.radians(degrees), 0.0, 0.0])
    )
    hip = np.broadcast_to(rot.from_rotvec([0.0, 0.3, 0.0]), calm.shape)
    thigh = rot.from_rotvec(np.stack([0.0 * times, np.sin(3.0 * times), 0.0 * times], axis=1))
    world = rot.multiply(calm, rot.multiply(hip, thigh))
    thigh = rot.multiply(rot.conjugate(rot.multiply(root, hip)), world)
    trunk = rot.multiply(rot.conjugate(root), calm)
    point = np.asarray(center)
    moved = path + rot.rotate(calm, point) - rot.rotate(root, point)
    return np.stack([root, hip, thigh, trunk], axis=1), moved, calm, world, path


def test_the_root_is_calm_and_what_hangs_on_it_keeps_its_orientation():
    rotations, path, calm, world, _ = shaken()
    out, _, found = steadied(rotations, path, PARENTS, RATE, 0)
    assert np.degrees(rot.angle_between(out[:, 0], calm)).max() < 1.5
    thigh = rot.multiply(out[:, 0], rot.multiply(out[:, 1], out[:, 2]))
    np.testing.assert_allclose(rot.angle_between(thigh, world), 0.0, atol=1e-7)
    np.testing.assert_array_equal(out[:, 1], rotations[:, 1])
    assert len(found) == 1 and found[0].first <= 60 <= found[0].last
    assert found[0].before == pytest.approx(10.0, abs=1.0) and found[0].after < 1.5


def test_it_turns_about_the_point_that_did_not_shake():
    rotations, path, calm, _, clean = shaken(center=(0.02, 0.05, -0.08))
    out, moved, _ = steadied(rotations, path, PARENTS, RATE, 0)
    assert np.linalg.norm(path - clean, axis=1).max() > 0.010
    point = np.array((0.02, 0.05, -0.08))
    kept = moved + rot.rotate(out[:, 0], point) - clean - rot.rotate(calm, point)
    assert np.linalg.norm(kept, axis=1).max() < 0.0005


def test_frames_away_from_it_are_as_they_were():
    rotations, path, *_ = shaken()
    out, moved, _ = steadied(rotations, path, PARENTS, RATE, 0)
    far = np.abs(np.arange(FRAMES) - 60) > 25
    np.testing.assert_allclose(out[far], rotations[far], atol=1e-9)
    np.testing.assert_allclose(moved[far], path[far], atol=1e-9)


def test_an_end_goes_on_as_it_came():
    rotations, path, calm, _, clean = shaken(frames=(FRAMES - 4,))
    out, moved, found = steadied(rotations, path, PARENTS, RATE, 0)
    assert found
    assert np.degrees(rot.angle_between(out[:, 0], calm)).max() < 1.5
    assert np.linalg.norm(moved - clean, axis=1).max() < 0.002


@pytest.mark.parametrize("change", [{"degrees": 4.0}, {"frames": ()}])
def test_what_does_not_shake_is_left_alone(change):
    rotations, path, *_ = shaken(**change)
    out, moved, found = steadied(rotations, path, PARENTS, RATE, 0)
    assert out is rotations and moved is path and not found


def test_lesser_shaking_is_steadied_only_near_it():
    rotations, path, calm, *_ = shaken()
    for frame in (70, 200):
        turn = rot.from_rotvec([0.0, np.radians(4.0), 0.0])
        rotations[frame, 0] = rot.multiply(rotations[frame, 0], turn)
    out, *_ = steadied(rotations, path, PARENTS, RATE, 0)
    assert np.degrees(rot.angle_between(out[70, 0], calm[70])) < 2.0
    np.testing.assert_allclose(out[200], rotations[200], atol=1e-9)


def test_few_frames_a_second_tell_nothing():
    rotations, path, *_ = shaken(degrees=60.0)
    assert steadied(rotations, path, PARENTS, 30.0, 0) == (rotations, path, [])


@pytest.mark.parametrize("name", samples())
def test_samples_do_not_shake(name):
    assert not [r for r in repair(sample(name))[1] if r.kind == "jitter"]


def test_a_repair_tells_of_it():
    clip = sample("walk")
    q = np.array(clip.rotations)
    turn = rot.from_rotvec([np.radians(9.0), 0.0, 0.0])
    q[200, 0] = rot.multiply(q[200, 0], turn)
    mended, repairs = repair(replace(clip, rotations=q))
    jitter = [r for r in repairs if r.kind == "jitter"]
    assert len(jitter) == 1 and jitter[0].joint == clip.skeleton.names[0]
    assert jitter[0].start < 200 / clip.rate < jitter[0].end
    assert "1 jitter of up to 9 degrees a frame" in mended.notes[-1]


def test_toes_that_flutter_are_steadied():
    rotations, path, *_ = shaken(frames=())
    flutter = np.zeros((FRAMES, 3))
    flutter[100:110:2, 1] = np.radians(25.0)
    rotations[:, 2] = rot.multiply(rotations[:, 2], rot.from_rotvec(flutter))
    out, moved, found = steadied(rotations, path, PARENTS, RATE, 2)
    assert len(found) == 1 and found[0].before > 20.0 and found[0].after < 5.0
    assert moved is path
    others = [0, 1, 3]
    np.testing.assert_array_equal(out[:, others], rotations[:, others])
