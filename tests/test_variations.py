"""Variations: what changes, what stays, and in which direction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.character.soles import sole_heights
from understudy.control.feedforward import Rehearsal
from understudy.errors import InvalidValue, UnknownName
from understudy.family.cost import changed, effort
from understudy.motion import rotations as rot
from understudy.performance import driven, tracked
from understudy.simulate import simulate
from understudy.variations import (
    PRESETS,
    Grip,
    Length,
    Limp,
    Lock,
    Mass,
    Scaling,
    Speed,
    Strength,
    Together,
    preset,
)


@pytest.fixture(scope="module")
def clip():
    return us.sample("walk").trimmed(0.5, 1.7).resampled(60.0)


@pytest.fixture(scope="module")
def walk(clip):
    return tracked(clip, us.Character.from_clip(clip))


@pytest.fixture(scope="module")
def base(walk):
    return simulate(walk)


@pytest.fixture(scope="module")
def bodies(clip):
    return driven(clip, us.Linkage.from_clip(clip, "tree"))


def tracking(performance):
    return performance.controllers[0]


def states(performance):
    return simulate(performance).qpos.tobytes()


def joint_errors(take):
    return us.score(take).joint_errors_deg


# -- nothing changed --------------------------------------------------------------------------

IDENTITIES = [
    Scaling(joint="left_arm", by=1.0),
    Strength(joint="legs", by=1.0),
    Mass(link="left_foot", by=1.0),
    Speed(by=1.0),
    Grip(to=1.0),
    Together(),
]


@pytest.mark.parametrize("variation", [*IDENTITIES, Length(link="left_thigh", by=1.0)])
def test_a_factor_of_one_is_the_same_performance(walk, variation):
    assert variation(walk) is walk


@pytest.mark.parametrize("variation", IDENTITIES)
def test_a_factor_of_one_is_the_same_drive(bodies, variation):
    assert variation(bodies) is bodies


def test_strengths_of_one_and_a_rehearsal_of_the_same_are_the_same_bits(walk, base):
    own = tracking(walk)
    rehearsal = Rehearsal(scene=walk.scene, reference=own.reference)
    same = replace(own, strengths=(("left_knee", 1.0), ("neck", 1.0)), rehearsal=rehearsal)
    assert states(replace(walk, controllers=(same,))) == base.qpos.tobytes()


# -- effects ----------------------------------------------------------------------------------


def test_a_limp_arm_gives_no_torque_and_leaves_the_clip_while_the_rest_stays(walk, base):
    take = simulate(Limp(joint="right_arm")(walk))
    torque = changed(effort(base, base.duration), effort(take, take.duration))
    errors = joint_errors(take)
    for joint in ("right_shoulder", "right_elbow", "right_wrist"):
        stop = 1e-6  # only a joint at its stop is pushed, and that is no servo
        assert torque[joint]["torque_rms_nm"] < stop
    assert errors["right_shoulder"] > 5.0
    others = [e for joint, e in errors.items() if not joint.startswith("right_")]
    assert max(others) < 3.0


def test_a_limp_arm_hangs(clip):
    still = clip.trimmed(0.0, 0.2)
    arms_out = np.array(still.rotations[[0] * 121])
    character = us.Character.from_clip(clip)
    for link in character.links:
        if link.role in ("right_shoulder", "left_shoulder"):
            arms_out[:, clip.skeleton.index(link.clip_joint)] = rot.identity()
    held = replace(still, rotations=arms_out, root_positions=still.root_positions[[0] * 121])
    performance = Limp(joint="right_arm")(tracked(held, character))
    pose = simulate(performance).clip().forward_kinematics().positions[-1]
    drop = {
        side: pose[character.index(f"{side}_shoulder"), 2]
        - pose[character.index(f"{side}_wrist"), 2]
        for side in ("left", "right")
    }
    assert drop["right"] > drop["left"] + 0.2


def test_heavy_boots_raise_the_torque_of_the_hips(walk, base):
    boots = Together(Mass(link="left_foot", by=8.0), Mass(link="right_foot", by=8.0))
    take = simulate(boots(walk))
    cost = changed(effort(base, base.duration), effort(take, take.duration))
    for hip in ("left_hip", "right_hip"):
        assert cost[hip]["torque_rms_nm"] > 1.1 * cost[hip]["torque_rms_unvaried_nm"]


def test_the_boots_are_felt_because_gains_and_feedforward_know_nothing_of_them(walk):
    heavy = Mass(link="left_foot", by=8.0)(walk)
    assert tracking(heavy).rehearsal.scene is walk.scene
    k = [tracking(p)._gains(p.scene, p.scene.model)[0] for p in (walk, heavy)]
    np.testing.assert_array_equal(*k)
    assert heavy.scene.characters[0].mass > walk.scene.characters[0].mass


def test_the_weaker_a_joint_the_more_it_errs(walk):
    errors = [
        joint_errors(simulate(Strength(joint="neck", by=by)(walk)))["neck"]
        for by in (1.0, 0.4, 0.1)
    ]
    assert errors == sorted(errors)


def test_a_locked_joint_keeps_its_angle(walk):
    take = simulate(Lock(joint="left_knee")(walk))
    own = take.clip().joint("left_knee")
    assert np.degrees(rot.angle(own)).max() < 2.0
    bent = Lock(joint="left_elbow", at=(0.0, 0.0, -1.0))
    own = simulate(bent(walk)).clip().joint("left_elbow")
    turned = np.degrees(rot.angle_between(own, rot.from_rotvec(np.array([0.0, 0.0, -1.0]))))
    assert turned.max() < 2.0


def test_scaling_scales_the_rotation_inside_its_time_and_nothing_else(walk):
    before = tracking(walk).reference
    after = tracking(
        Scaling(joint="left_hip", by=1.5, start=0.3, end=0.9, ease=0.1)(walk)
    ).reference
    j = before.skeleton.index("left_hip")
    outside = (before.times < 0.3) | (before.times > 0.9)
    np.testing.assert_array_equal(before.rotations[outside], after.rotations[outside])
    others = np.arange(len(before.skeleton)) != j
    np.testing.assert_array_equal(before.rotations[:, others], after.rotations[:, others])
    full = (before.times > 0.45) & (before.times < 0.75)
    speeds = [
        np.linalg.norm(rot.angular_velocity(c.rotations[:, j], c.rate)[full], axis=1)
        for c in (before, after)
    ]
    np.testing.assert_allclose(speeds[1], 1.5 * speeds[0], rtol=0.02)


def test_a_scaled_knee_does_not_bend_backward(walk):
    def flexion(performance):
        return rot.to_rotvec(tracking(performance).reference.joint("left_knee"))[:, 1]

    assert flexion(Scaling(joint="left_knee", by=1.6)(walk)).min() > flexion(walk).min() - 0.02


def test_longer_legs_raise_the_hips_and_keep_the_feet_on_the_floor(walk):
    longer = Length(link="legs", by=1.2)(walk)
    before, after = walk.scene.characters[0], longer.scene.characters[0]
    ratio = np.linalg.norm(after.link("left_shank").offset) / np.linalg.norm(
        before.link("left_shank").offset
    )
    assert ratio == pytest.approx(1.2)
    assert after.simulated_mass == pytest.approx(before.simulated_mass)
    reference = tracking(longer).reference
    assert abs(np.median(sole_heights(reference, after).min(axis=1))) < 0.02
    rise = (
        reference.root_positions[:, 2].mean() - tracking(walk).reference.root_positions[:, 2].mean()
    )
    assert rise > 0.1
    simulate(longer)


def test_a_slower_motion_lasts_longer(walk):
    slower = Speed(by=0.5)(walk)
    assert slower.duration == pytest.approx(2.0 * walk.duration, rel=0.02)
    assert simulate(slower).duration == pytest.approx(slower.duration, abs=0.01)


def test_a_tighter_grip_leaves_less_of_the_effect(walk):
    boots = Mass(link="left_foot", by=8.0)
    away = []
    for grip in (0.0, 0.5, 1.0):
        one, other = (simulate(p).clip() for p in (Grip(to=grip)(walk), boots(Grip(to=grip)(walk))))
        places = [c.forward_kinematics().positions for c in (one, other)]
        away.append(np.linalg.norm(places[1] - places[0], axis=2).mean())
    assert away[0] > away[1] > away[2]


# -- composing --------------------------------------------------------------------------------


def test_changes_of_different_things_commute_bit_for_bit(walk):
    parts = [
        Mass(link="left_foot", by=3.0),
        Strength(joint="right_arm", by=0.3),
        Scaling(joint="neck", by=1.4),
        Limp(joint="left_wrist"),
        Grip(to=0.4),
    ]
    assert states(Together(*parts)(walk)) == states(Together(*reversed(parts))(walk))


def test_strengths_multiply(walk):
    twice = Together(Strength(joint="neck", by=0.5), Strength(joint="neck", by=0.4))(walk)
    assert dict(tracking(twice).strengths)["neck"] == pytest.approx(0.2)
    revived = Together(Limp(joint="neck"), Strength(joint="neck", by=2.0))(walk)
    assert dict(tracking(revived).strengths)["neck"] == 0.0


@pytest.mark.parametrize("name", PRESETS)
def test_presets_draw_the_same_from_the_same_seed_and_stay_in_range(walk, bodies, name):
    one, other = (preset(name).drawn(np.random.default_rng(5)) for _ in range(2))
    assert one == other
    assert not one.ranged
    one(walk)
    one(bodies)


def test_ranges_are_drawn_evenly_in_ratio():
    rng = np.random.default_rng(0)
    drawn = [Mass(link="left_foot", by=(0.25, 4.0)).drawn(rng).by for _ in range(2000)]
    assert np.median(drawn) == pytest.approx(1.0, rel=0.1)
    assert min(drawn) >= 0.25
    assert max(drawn) <= 4.0


# -- driven linkages --------------------------------------------------------------------------


def test_scaling_a_limb_of_a_linkage_scales_its_bodies_alone(bodies):
    drive = Scaling(joint="left_arm", by=1.3)(bodies).controllers[0]
    left = [j for j, s in enumerate(drive.scaling.max(axis=0)) if s > 1.0]
    names = [drive.reference.skeleton.names[j] for j in left]
    assert names
    assert drive.scaling[:, left].min() == 1.3
    assert all("left" in name.lower() for name in names)


def test_limp_bodies_of_a_linkage_get_no_force(bodies):
    from understudy.fidelity import drive_forces

    take = simulate(Limp(joint="right_arm")(bodies))
    limp = np.flatnonzero(take.performance.controllers[0].strength.max(axis=0) == 0.0)
    assert len(limp)
    assert not drive_forces(take).force[:, limp].any()


def test_the_zombie_of_a_linkage_does_not_bend_its_knee(bodies):
    zombie = preset("zombie").drawn(np.random.default_rng(0))(bodies)
    linkage = zombie.scene.characters[0]
    knee = linkage.locks[0].joint
    own = simulate(zombie).clip().joint(knee)
    assert np.degrees(rot.angle(own)).max() < 2.0


def test_lengths_of_a_linkage_are_the_clips(bodies):
    with pytest.raises(InvalidValue, match="as long as"):
        Length(link="left_thigh", by=1.1)(bodies)


# -- what cannot be ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "error", "said"),
    [
        (lambda: Limp(joint="left_nee"), UnknownName, "Did you mean 'left_knee'?"),
        (lambda: Mass(link="left_fot", by=2.0), UnknownName, "Did you mean 'left_foot'?"),
        (lambda: Strength(joint="pelvis", by=2.0), InvalidValue, "root"),
        (lambda: Length(link="pelvis", by=2.0), InvalidValue, "root"),
        (lambda: Scaling(joint="neck", by=2.0, start=1.0, end=0.5), InvalidValue, "empty"),
        (lambda: Scaling(joint="neck", by=2.0, end=99.0), InvalidValue, "outside the clip"),
        (lambda: Scaling(joint="neck", by=(1.0, 2.0)), InvalidValue, "draw from it first"),
        (lambda: Limp(joint="neck", character=1), InvalidValue, "No character 1"),
    ],
)
def test_what_the_body_cannot_do_is_said_before_anything_runs(walk, make, error, said):
    with pytest.raises(error, match=said.replace("?", r"\?")):
        make()(walk)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Mass(link="x", by=0.0), "must be positive"),
        (lambda: Mass(link="x", to=(-1.0, 2.0)), "must be positive"),
        (lambda: Mass(link="x"), "one of by, to and share"),
        (lambda: Mass(link="x", by=1.0, to=1.0), "one of by, to and share"),
        (lambda: Scaling(joint="x", by=(2.0, 1.0)), "empty"),
        (lambda: Scaling(joint="x", by=-1.0), "0 to 5"),
        (lambda: Strength(joint="x", by=float("nan")), "number"),
        (lambda: Speed(by=0.0), "0.1 to 10"),
        (lambda: Grip(to=1.5), "0 to 1"),
        (lambda: Lock(joint="x", at="bent"), "straight"),
        (lambda: Lock(joint="x", at=(9.0, 0.0, 0.0)), "pi"),
    ],
)
def test_senseless_amounts_are_refused_when_said(make, said):
    with pytest.raises(InvalidValue, match=said):
        make()


def test_an_unknown_preset_names_the_nearest():
    with pytest.raises(UnknownName, match="Did you mean 'zombie'"):
        preset("zombi")
