"""Palms at targets, on surfaces, and targets too far away."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import pytest

import understudy as us
from understudy.character import adult_man, child
from understudy.control import HandOn, Reach
from understudy.errors import InvalidValue, UnknownName
from understudy.evaluate import contact_events, contact_force
from understudy.motion import rotations as rot
from understudy.scene import Drum, Staff, Table

TARGET = (0.42, -0.20, 1.20)


@pytest.fixture(scope="module")
def clip() -> us.Clip:
    return us.sample("gesture").trimmed(0.0, 2.6)


@pytest.fixture(scope="module")
def body(clip) -> us.Character:
    return us.Character.from_clip(clip)


def palm(take: us.Take, hand: str = "right") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [s], palm positions [m] and hand orientations."""
    times, placed, turned = take.poses(120.0)
    number = take.model.body(f"{hand}_hand").id
    offset = take.model.site(f"{hand}_palm").pos
    return times, placed[:, number] + rot.rotate(turned[:, number], offset), turned[:, number]


def test_the_palm_comes_to_the_target_and_stays_while_the_clip_waves(clip, body):
    reach = Reach(target=TARGET, span=(0.8, 2.4), ease=0.4)
    times, place, _ = palm(us.track(clip, body, tasks=[reach]))
    held = (times > 1.35) & (times < 2.0)
    assert np.linalg.norm(place[held] - TARGET, axis=1).max() < 0.005


def test_before_and_after_its_span_the_arm_follows_the_clip(clip, body):
    reach = Reach(target=TARGET, span=(0.8, 2.0), ease=0.3)
    plain, reached = us.track(clip, body), us.track(clip, body, tasks=[reach])
    early, late = plain.times < 0.8, plain.times > 2.3
    np.testing.assert_allclose(reached.qpos[early], plain.qpos[early], atol=1e-9)
    np.testing.assert_allclose(reached.qpos[late], plain.qpos[late], atol=0.02)


def test_the_hand_keeps_the_clips_orientation_where_the_wrist_allows(clip, body):
    still = us.sample("staff").trimmed(1.0, 1.5)
    person = us.Character.from_clip(still)
    reference = us.tracked(still, person).controllers[0].reference
    at = palm(us.track(still, person))[1][0] + [0.05, 0.05, 0.05]
    times, _, turned = palm(us.track(still, person, tasks=[Reach(target=tuple(at), ease=0.0)]))
    wanted = reference.forward_kinematics().rotations[:, person.index("right_wrist")]
    k = np.searchsorted(reference.times, times[times > 0.2] - 1e-9)
    assert np.degrees(rot.angle_between(turned[times > 0.2], wanted[k])).max() < 6.0


def test_a_left_hand_reaches_the_mirrored_target(clip, body):
    mirrored = clip.mirrored()
    other = us.Character.from_clip(mirrored)
    right = palm(us.track(clip, body, tasks=[Reach(target=TARGET, span=(0.5, 2.5))]))[1]
    left = palm(
        us.track(
            mirrored,
            other,
            tasks=[Reach(hand="left", target=TARGET * np.array([1, -1, 1]), span=(0.5, 2.5))],
        ),
        "left",
    )[1]
    np.testing.assert_allclose(left * [1, -1, 1], right, atol=0.01)


def test_a_named_site_can_be_the_target(clip, body):
    drum = Drum(position=(0.40, -0.20, 1.18))
    take = us.track(clip, body, props=[drum], tasks=[Reach(target="drum/skin", span=(0.8, 2.4))])
    times, place, _ = palm(take)
    held = (times > 1.3) & (times < 2.0)
    assert np.linalg.norm(place[held] - drum.position, axis=1).max() < 0.006


@dataclass(frozen=True)
class Rail:
    """A bead that slides by itself along y at a speed."""

    def attach(self, spec: mujoco.MjSpec) -> None:
        bead = spec.worldbody.add_body(name="bead", pos=[0.42, -0.3, 1.15], gravcomp=1.0)
        bead.add_joint(name="bead", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 1, 0], damping=5.0)
        bead.add_geom(size=[0.02, 0, 0], mass=0.1, contype=0, conaffinity=0)
        bead.add_site(name="bead")
        motor = spec.add_actuator(name="bead", target="bead", trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.gainprm[0] = 0.0
        motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        motor.biasprm[0] = 0.5  # 0.5 N against 5 N s/m: 0.1 m/s


def test_a_moving_target_is_followed(clip, body):
    take = us.track(clip, body, props=[Rail()], tasks=[Reach(target="bead", ease=0.5)])
    times, place, _ = palm(take)
    number = take.model.body("bead").id
    bead = take.poses(120.0)[1][:, number]
    assert bead[-1, 1] - bead[0, 1] > 0.2
    late = times > 0.7
    assert np.linalg.norm(place[late] - bead[late], axis=1).max() < 0.012


def test_a_target_out_of_reach_says_how_far(clip, body):
    with pytest.raises(
        InvalidValue,
        match=r"Reach: at .* s the right wrist would have to be 1\.\d\d m from the shoulder, "
        r"which is at \(-?0\.\d\d, -0\.\d\d, 1\.\d\d\); the arm reaches 0\.\d\d m\. "
        r"Bring the target 0\.\d\d m nearer",
    ):
        us.tracked(clip, body, tasks=[Reach(target=(1.5, -0.2, 1.2))])
    with pytest.raises(InvalidValue, match="the arm reaches"):
        performance = us.tracked(
            clip, body, props=[Drum(position=(2.0, 0.0, 0.9))], tasks=[Reach(target="drum/skin")]
        )
        us.simulate(performance)
    with pytest.raises(InvalidValue, match=r"the arm reaches 0\.3\d m"):
        us.tracked(clip, child(), tasks=[Reach(target=(0.5, -0.2, 1.2))])


def test_a_site_that_does_not_exist_is_refused_with_the_nearest(clip, body):
    performance = us.tracked(
        clip, body, props=[Drum(position=(0.4, 0, 0.9))], tasks=[Reach(target="drum/skn")]
    )
    with pytest.raises(UnknownName, match="Did you mean 'drum/skin'"):
        us.simulate(performance)


def test_a_target_on_the_arm_itself_is_refused(clip, body):
    for target in ("right_palm", "staff/head"):
        performance = us.tracked(clip, body, props=[Staff()], tasks=[Reach(target=target)])
        with pytest.raises(InvalidValue, match="is on the right arm itself"):
            us.simulate(performance)


def test_a_task_without_its_clip_is_refused(clip, body):
    from dataclasses import replace

    performance = us.tracked(clip, body)
    bare = replace(performance, controllers=(*performance.controllers, Reach(target=TARGET)))
    with pytest.raises(InvalidValue, match="Reach needs the clip; give it to `tracked`"):
        us.simulate(bare)


def test_a_hand_on_a_table_presses_with_its_force(clip):
    person = adult_man()
    table = Table(position=(0.45, -0.1), size=(0.5, 0.8), height=1.0)
    press = HandOn(target=(0.36, -0.22, 1.0), force=20.0, span=(1.1, 2.6), ease=0.6)
    take = us.track(clip, person, props=[table], contacts=[("right_hand", "table")], tasks=[press])
    event = contact_events(take, "right_hand", "table")[-1]
    assert take.times[-1] > event.start_s > 1.1
    pressed = (take.times > 1.75) & (take.times < 2.0)
    upward = contact_force(take, "right_hand", "table")[pressed, 2]
    assert 12.0 < upward.mean() < 28.0
    times, place, turned = palm(take)
    held = (times > 1.75) & (times < 2.0)
    facing = rot.rotate(turned[held], np.array([0.0, 0.0, -1.0]))
    assert np.degrees(np.arccos(-facing[:, 2])).max() < 8.0
    assert np.linalg.norm(place[held, :2] - [0.36, -0.22], axis=1).max() < 0.03


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"normal": (0.0, 0.0, 0.0)}, "normal is zero"),
        ({"force": -1.0}, "force is -1.0"),
        ({"force": np.nan}, "force is nan"),
        ({"target": (0.0, 0.0)}, "target has shape"),
        ({"target": (0.0, 0.0, np.nan)}, "not finite"),
        ({"hand": "middle"}, "hand is 'middle'"),
    ],
)
def test_values_that_cannot_be_meant_are_refused(settings, message):
    with pytest.raises(InvalidValue, match=message):
        HandOn(**{"target": (0.4, 0.0, 1.0)} | settings)


def test_a_hand_from_below_goes_round_the_edge_of_a_table(clip):
    table = Table(position=(0.5, 0.1), size=(0.6, 1.0), height=0.95)
    press = HandOn(hand="left", target=(0.3, 0.2, 0.95), span=(0.3, 2.6))
    contacts = [("left_hand", "table")]
    take = us.track(clip, adult_man(), props=[table], contacts=contacts, tasks=[press])
    times, place, turned = palm(take, "left")
    held = (times > 1.3) & (times < 1.7)
    assert np.linalg.norm(place[held, :2] - [0.3, 0.2], axis=1).max() < 0.03
    fingers = rot.rotate(turned[held], np.array([0.0, 1.0, 0.0]))
    assert fingers[:, 0].min() > 0.9  # away from the shoulder, flat
