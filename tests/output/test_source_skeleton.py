"""Which skeleton a take's BVH is on."""

from dataclasses import replace

import numpy as np

import understudy as us
from understudy.motion.clip import Clip
from understudy.motion.skeleton import Skeleton
from understudy.output.write import on_source_skeleton


def thumbed() -> Clip:
    """Half a second of the gesture by a person with a thumb that turns, which no link carries."""
    clip = us.sample("gesture").trimmed(0.0, 0.5).resampled(60.0)
    held = clip.skeleton
    skeleton = Skeleton(
        names=(*held.names, "thumb"),
        parents=(*held.parents, held.index("left_wrist")),
        offsets=np.vstack((held.offsets, [[0.0, 0.03, 0.02]])),
        end_joints=(*held.end_joints, len(held)),
        end_offsets=np.vstack((held.end_offsets, [[0.0, 0.04, 0.0]])),
    )
    half = 0.5 * np.linspace(0.0, 0.6, clip.frames)
    none = np.zeros(clip.frames)
    turns = np.stack((np.cos(half), np.sin(half), none, none), axis=-1)
    return replace(
        clip, skeleton=skeleton, rotations=np.concatenate((clip.rotations, turns[:, None]), axis=1)
    )


def test_a_bvh_has_every_joint_of_the_clip(tmp_path):
    clip = thumbed()
    take = us.track(clip, us.Character.from_clip(clip))
    us.write(take, tmp_path / "a.bvh")
    assert set(us.read(tmp_path / "a.bvh").skeleton.names) == set(clip.skeleton.names)
    back = on_source_skeleton(take)
    np.testing.assert_allclose(
        np.abs(np.sum(back.joint("thumb") * clip.joint("thumb"), axis=-1)), 1.0, atol=1e-9
    )
    assert "thumb" not in take.clip().skeleton.names


def test_another_body_keeps_its_own_skeleton():
    from understudy.character import child

    body = child()
    take = us.track(thumbed(), body)
    assert on_source_skeleton(take).skeleton == body.skeleton


def test_a_take_without_a_clip_keeps_its_own_skeleton():
    clip = thumbed()
    take = us.track(clip, us.Character.from_clip(clip))
    alone = replace(take, captured=(None,))
    assert on_source_skeleton(alone).skeleton == take.clip().skeleton
