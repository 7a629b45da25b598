"""What is shown: states of the take, the captured clip at the same times."""

import numpy as np
import pytest

import understudy as us
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.output.playback import Playback, playback, sampled
from understudy.take import Take


def test_frames_of_a_take_are_its_own_states(take: Take) -> None:
    shown = playback(take, rate=30.0)
    assert shown.frames == 31 and shown.rate == 30.0
    assert np.array_equal(shown.qpos, take.qpos[::16])
    assert np.array_equal(shown.times, take.times[::16])


def test_ghost_is_the_reference_at_the_same_times(take: Take) -> None:
    shown = playback(take, rate=120.0)
    reference = take.references[0]
    assert reference is not None and shown.ghost is not None
    assert shown.ghost[:, :3] == pytest.approx(reference.root_positions, abs=1e-12)
    turned = shown.ghost[:, 3:].reshape(reference.rotations.shape)
    assert rot.angle_between(turned, reference.rotations).max() < 1e-9


def test_bodies_of_a_clip_alone_stand_where_its_joints_do(clip: Clip) -> None:
    shown = playback(clip, rate=clip.rate)
    placed, turned = shown.poses(shown.qpos[:5])
    pose = clip.forward_kinematics()
    ids = [shown.model.body(f"b{i}").id for i in range(len(clip.skeleton))]
    assert placed[:, ids] == pytest.approx(pose.positions[:5], abs=1e-9)
    assert rot.angle_between(turned[:, ids], pose.rotations[:5]).max() < 1e-7


def test_heading_follows_the_body_whichever_way_it_walks(clip: Clip) -> None:
    turn = rot.from_rotvec(np.array([0.0, 0.0, 2.0]))
    turned = clip.rotations.copy()
    turned[:, 0] = rot.multiply(turn, turned[:, 0])
    away = Clip(
        skeleton=clip.skeleton,
        rotations=turned,
        root_positions=rot.rotate(turn, clip.root_positions),
        rate=clip.rate,
    )
    assert playback(clip).heading == pytest.approx(0.0, abs=0.1)
    assert playback(away).heading == pytest.approx(2.0, abs=0.1)


def test_ghost_beside_does_not_touch_the_body(playing: Playback) -> None:
    moved = playing.beside("follow")
    assert moved.ghost is not None and playing.ghost is not None
    shift = moved.ghost - playing.ghost
    assert np.linalg.norm(shift[0, :2]) > 1.2  # arms stretched out are 1.5 m wide
    assert np.ptp(shift, axis=0).max() < 1e-12
    assert not shift[:, 2:].any()


def test_time_outside_the_motion_is_refused(playing: Playback) -> None:
    assert playing.nearest(1.0) == 30
    with pytest.raises(InvalidValue, match=r"from 0 to 2 s"):
        playing.nearest(5.0)


def test_sampling_at_frame_times_gives_the_frames(clip: Clip) -> None:
    placed, turned = sampled(clip, clip.times)
    assert placed == pytest.approx(clip.root_positions, abs=1e-12)
    assert rot.angle_between(turned, clip.rotations).max() < 1e-7


def test_what_is_neither_take_nor_clip_is_refused() -> None:
    with pytest.raises(InvalidValue, match="str cannot be shown"):
        playback("walk.bvh")  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["independent", "constrained", "tree"])
def test_a_linkage_plays_with_its_clip_as_the_ghost(kind):
    from understudy.character import Linkage
    from understudy.motion.samples import sample
    from understudy.performance import driven
    from understudy.simulate import simulate

    clip = sample("gesture").trimmed(0.0, 0.5).resampled(60.0)
    take = simulate(driven(clip, Linkage.from_clip(clip, kind)))
    shown = playback(take, rate=30.0)
    assert shown.ghost is not None
    # Driven bodies follow within a millimeter, so ghost and body all but coincide.
    assert np.abs(shown.ghost - shown.qpos)[:, :3].max() < 1e-3
    aside = shown.beside().ghost
    assert aside is not None
    placed, _ = shown.poses(shown.ghost)
    moved = shown.poses(aside)[0] - placed
    assert np.ptp(moved[:, 1:], axis=1).max() < 1e-9  # all bodies by the same way
    assert np.linalg.norm(moved[0, 1]) > 0.3


def test_two_who_face_each_other_are_seen_across_the_line_between_them():
    from understudy.character import child
    from understudy.performance import together, tracked

    clip = us.sample("clapping").trimmed(0.0, 0.1)
    there = clip.placed(at=(0.6, 0.8), heading=np.pi + np.arctan2(0.8, 0.6))
    here = clip.placed(heading=np.arctan2(0.8, 0.6))
    take = us.simulate(together(tracked(here, child()), tracked(there, child())))
    shown = playback(take)
    assert shown.heading == pytest.approx(np.arctan2(0.8, 0.6), abs=0.15)
