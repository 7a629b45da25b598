"""The reproduction of Zordan & Hodgins 1999."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.character.bodies import adult_man
from understudy.errors import ClipError
from understudy.evaluate.events import ContactEvent
from understudy.motion import rotations as rot
from understudy.motion.samples.partner import CLAPS, boundaries, clap_times
from understudy.motion.samples.striking import HITS
from understudy.papers.zordan1999 import bow, cast, drum, finding, patty_cake, speeds
from understudy.papers.zordan1999 import published as paper


def wave():
    return us.sample("gesture").trimmed(0.5, 2.5)


# -- what stands in for the paper's captures ------------------------------------------------------


def test_without_a_folder_the_bundled_gesture_plays():
    found = cast.casting(None)
    assert found.source == "sample:gesture" and not found.captured


def test_a_captured_gesture_comes_first(tmp_path):
    us.write(wave(), tmp_path / "wave_hello.bvh")
    found = cast.casting(tmp_path)
    assert found.source == "wave_hello" and found.captured


def test_a_missing_folder_is_refused(tmp_path):
    with pytest.raises(ClipError, match="no such folder"):
        cast.casting(tmp_path / "no")


def test_the_liveliest_part_of_a_long_clip_is_used():
    clip = us.sample("gesture")
    still = clip.trimmed(0.0, 0.1).looped(until=0.1)
    part = cast.liveliest(clip, 2.0)
    assert part.duration == pytest.approx(2.0)
    moved = [np.abs(np.diff(c.rotations, axis=0)).sum() for c in (part, clip.trimmed(4.0, 6.0))]
    assert moved[0] >= moved[1]
    assert cast.liveliest(still, 2.0) is still


@pytest.mark.clips
def test_a_real_capture_plays_the_gesture(clips):
    assert cast.casting(clips, seconds=2.0).captured


# -- measures -------------------------------------------------------------------------------------


def test_speed_and_acceleration_on_a_circle_are_those_of_a_circle():
    radius, turning, rate = 0.3, 4.0, 500.0
    angle = turning * np.arange(500) / rate
    path = np.zeros((500, 3))
    path[:, 0], path[:, 1] = radius * np.cos(angle), radius * np.sin(angle)
    assert finding.speed_of(path, rate)[5:-5] == pytest.approx(radius * turning, rel=1e-3)
    assert finding.acceleration_of(path, rate) == pytest.approx(radius * turning**2, rel=1e-3)


def test_a_hand_is_where_its_palm_is():
    clip = us.retargeted(wave(), adult_man())
    pose, wrist = clip.forward_kinematics(), clip.skeleton.index("left_wrist")
    away = np.linalg.norm(finding.hand_path(clip, "left") - pose.positions[:, wrist], axis=1)
    assert away == pytest.approx(away[0]) and 0.05 < away[0] < 0.15


# -- figure 6: sensors ----------------------------------------------------------------------------


def test_perfect_sensors_give_samples_of_the_clip():
    given = speeds.sensed(wave(), rate=20.0, noise=0.0)
    assert given.rate == 20.0
    same = wave().resampled(20.0)
    assert (
        np.abs(rot.angle(rot.multiply(rot.conjugate(same.rotations), given.rotations))).max() < 1e-6
    )


def test_noise_of_sensors_is_that_of_world_orientations():
    clean, noisy = (speeds.sensed(wave(), noise=n).forward_kinematics() for n in (0.0, 2.0))
    off = rot.to_rotvec(rot.multiply(rot.conjugate(clean.rotations), noisy.rotations))
    assert np.degrees(off.std()) == pytest.approx(2.0, rel=0.1)
    assert abs(np.degrees(off.mean())) < 0.2


def test_the_seed_says_which_noise():
    one, same, other = (speeds.sensed(wave(), seed=seed) for seed in (1, 1, 2))
    assert one == same and one != other


# -- figure 4: the drum ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def stroke():
    clip = us.sample("strike").trimmed(0.0, HITS[0] + 0.4)
    body = adult_man(plan="upper")
    return {on: drum.played(body, clip, contact=on) for on in (True, False)}


def test_the_hand_stops_at_the_drum_and_without_contact_goes_through(stroke):
    (on,), (off,) = (drum.impacts(stroke[k], HITS[:1]) for k in (True, False))
    assert on.deep < 0.002 and off.deep > 0.015
    assert on.event is not None and off.event is None
    assert on.impulse > 1.0 and off.impulse == 0.0
    assert on.speed > 2.5


def test_playback_puts_every_joint_where_the_reference_has_it(stroke):
    take = drum.played_back(stroke[False])
    reference = take.references[0]
    assert reference is not None
    clip = take.clip()
    frames = min(clip.frames, reference.frames)
    apart = (
        clip.forward_kinematics().positions[:frames]
        - reference.forward_kinematics().positions[:frames]
    )
    assert np.abs(apart).max() < 1e-6


# -- figure 9: patty-cake -------------------------------------------------------------------------


def test_claps_are_due_when_the_adult_clapped_over_the_speed():
    due = [time for time, _ in patty_cake.claps_of(patty_cake.Game(speed=2.0))]
    assert due == pytest.approx(np.array(clap_times()) / 2.0)


def test_both_hands_meet_the_hands_across():
    pairs = dict(zip(CLAPS, (p for _, p in patty_cake.claps_of(patty_cake.Game())), strict=True))
    assert pairs["both"] == (("right_wrist", "left_wrist"), ("left_wrist", "right_wrist"))
    assert pairs["right"] == (("right_wrist", "right_wrist"),)


def test_offsets_bring_hands_together_that_miss_without():
    mean, _ = patty_cake.misses(patty_cake.Game(offsets=False))
    _, worst = patty_cake.misses(patty_cake.Game())
    assert mean > 0.1 and worst < 0.002


def test_longer_offsets_last_as_long_at_any_speed():
    games = patty_cake.games()
    windows = {(n, g.speed): g.window for n, g in games if g.law == "paper" and g.offsets}
    assert windows["longer offsets", 2.0] == pytest.approx(2.0 * windows["offsets", 2.0])
    assert windows["longer offsets", 2.0] == windows["offsets", 1.0]


def test_segments_in_another_order_keep_claps_at_their_times():
    clip = patty_cake.adults_clip((2, 0))
    assert clip.duration == pytest.approx(boundaries()[2] + 0.5, abs=0.02)
    reach = [finding.hand_path(clip, side)[:, 0] for side in ("left", "right")]
    first, second = (round(time * clip.rate) for time in clap_times()[:2])
    assert reach[0][first] > 0.4 and reach[1][first] > 0.4  # both
    assert reach[1][second] > 0.4 > reach[0][second]  # right alone


def test_a_clap_is_late_when_any_of_its_hands_is():
    def touch(start):
        return None if start is None else replace(EVENT, start_s=start)

    clap = patty_cake.Clap(time=1.0, events=(touch(0.99), touch(1.08)), gaps=(0.0, 0.0))
    assert clap.late == pytest.approx(0.08) and not clap.on_time
    clap = patty_cake.Clap(time=1.0, events=(touch(0.99), None), gaps=(0.0, 0.1))
    assert clap.late is None and not clap.on_time


EVENT = ContactEvent(
    between=("right_hand", "b/right_hand"),
    start_s=0.0,
    duration_s=0.1,
    impulse_ns=1.0,
    impulse=np.zeros(3),
    peak_force_n=1.0,
    peak_s=0.0,
    penetration_mm=0.0,
    approach_m_s=1.0,
    position=np.zeros(3),
)


# -- figure 8: the bow ----------------------------------------------------------------------------


def test_a_body_without_balance_falls_and_that_is_seen():
    clip = us.retargeted(us.sample("bow").trimmed(0.0, 4.0), adult_man(plan="upper"))
    take = us.simulate(bow.performed(adult_man(), clip, balanced=False))
    time = bow.fell(take)
    assert time is not None and 1.0 < time < 4.0
    _, away = bow.off_center(take)
    assert away[-1] > 0.1


# -- what the paper says --------------------------------------------------------------------------


def test_the_figures_with_simulations_are_listed():
    assert [figure.number for figure in paper.FIGURES] == [1, 4, 5, 6, 7, 8, 9]
    assert paper.FASTER in patty_cake.SPEEDS
    assert patty_cake.SPEEDS[0] == 1.0
