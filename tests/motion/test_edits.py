"""Edits of clips: round trips, closed forms and symmetry."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from understudy.errors import InvalidValue
from understudy.motion import edits, mirror
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip, Conventions
from understudy.motion.figure import figure
from understudy.motion.skeleton import Skeleton


def smooth_clip(frames: int = 61, rate: float = 60.0) -> Clip:
    """Every joint turns as a smooth sum of sines; the root runs along a curve."""
    body, chance, t = figure(), np.random.default_rng(1), np.arange(frames) / rate
    waves = chance.uniform(-0.6, 0.6, (3, len(body), 3))
    phase = chance.uniform(0, 6, (3, len(body), 1))
    angles = sum(
        np.sin(2 * np.pi * (k + 1) * t[:, None, None] + phase[k]) * waves[k] for k in range(3)
    )
    path = np.stack((t, np.sin(3 * t), 1 + 0.1 * np.cos(5 * t)), axis=-1)
    return Clip(
        skeleton=body, rotations=rot.from_rotvec(angles), root_positions=path, rate=rate,
        name="smooth", notes=("first",), conventions=Conventions(up="z", unit=1.0),
    )  # fmt: skip


def spin(omega: float, rate: float, frames: int) -> Clip:
    """One joint spinning about z at `omega` [rad/s] while the root moves at 1 m/s."""
    one = Skeleton(names=("a", "b"), parents=(-1, 0), offsets=np.array([[0, 0, 0], [1.0, 0, 0]]))
    t = np.arange(frames) / rate
    q = rot.identity(frames, 2)
    q[:, 0] = rot.from_rotvec(np.stack((0 * t, 0 * t, omega * t), axis=-1))
    return Clip(
        skeleton=one, rotations=q, root_positions=np.stack((t, 0 * t, 0 * t), axis=-1), rate=rate
    )


def worst_angle(a: Clip, b: Clip) -> float:
    return float(rot.angle_between(a.rotations, b.rotations).max())


def test_trimming_keeps_the_frames_as_they_are():
    clip = smooth_clip()
    part = clip.trimmed(0.25, 0.75)
    assert part.frames == 31
    np.testing.assert_array_equal(part.root_positions, clip.root_positions[15:46])
    assert part.notes == ("first", "Trimmed to 0.25 .. 0.75 s.")
    assert part.conventions == clip.conventions
    assert clip.trimmed() is clip
    assert clip.trimmed(0.1 * 3).frames == 61 - 18


@pytest.mark.parametrize(("start", "end"), [(-1, None), (0.5, 0.2), (0, 9), (2, 3), (np.nan, 1)])
def test_trimming_outside_the_clip_is_refused(start, end):
    with pytest.raises(InvalidValue, match="Cannot trim"):
        smooth_clip().trimmed(start, end)


def test_trimming_between_two_frames_is_refused():
    with pytest.raises(InvalidValue, match="No frame"):
        smooth_clip().trimmed(0.101, 0.103)


@pytest.mark.parametrize("method", ["slerp", "spline"])
def test_resampling_keeps_the_frames_it_shares(method):
    clip = smooth_clip()
    fine = clip.resampled(240.0, method=method)
    assert fine.frames == 241
    assert fine.duration == clip.duration
    np.testing.assert_allclose(fine.root_positions[::4], clip.root_positions, atol=1e-12)
    assert rot.angle_between(fine.rotations[::4], clip.rotations).max() < 1e-6
    back = fine.resampled(60.0, method=method)
    assert worst_angle(back, clip) < 1e-6


def test_resampling_to_a_rate_that_does_not_divide_stays_inside_the_clip():
    assert smooth_clip().resampled(50.0).frames == 51
    assert smooth_clip().resampled(23.976).duration <= 1.0
    clip = smooth_clip()
    assert clip.resampled(60.0) is clip


def test_slerp_resampling_of_steady_motion_is_exact():
    fine = spin(3.0, 10.0, 11).resampled(70.0)
    assert worst_angle(fine, spin(3.0, 70.0, 71)) < 1e-6
    np.testing.assert_allclose(fine.root_positions[:, 0], fine.times, atol=1e-12)


def test_spline_resampling_is_smooth_where_slerp_has_corners():
    clip = smooth_clip(rate=60.0)
    true = smooth_clip(frames=601, rate=600.0)
    errors, jerks = {}, {}
    for method in ("slerp", "spline"):
        fine = clip.resampled(600.0, method=method)
        errors[method] = worst_angle(fine, true)
        omega = edits.angular_velocities(fine, world=False)
        jerks[method] = np.abs(np.diff(omega, axis=0)).max()
    # A fifth of a degree of error and half a rad/s of corner against a hundredth of each.
    assert errors["spline"] < 0.2 * errors["slerp"]
    assert jerks["spline"] < 0.25 * jerks["slerp"]


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), 1e9])
def test_bad_rates_are_refused(rate):
    with pytest.raises(InvalidValue, match="rate is"):
        smooth_clip().resampled(rate)


def test_unknown_methods_and_times_are_refused():
    with pytest.raises(InvalidValue, match="must be 'slerp' or 'spline'"):
        smooth_clip().resampled(30.0, method="cubic")
    with pytest.raises(InvalidValue, match="finite"):
        edits.sampled(smooth_clip(), [0.0, np.nan])


def test_sampling_outside_the_clip_holds_its_ends():
    clip = smooth_clip()
    q, p = edits.sampled(clip, [-5.0, 99.0])
    np.testing.assert_allclose(p, clip.root_positions[[0, -1]], atol=1e-12)
    assert rot.angle_between(q, clip.rotations[[0, -1]]).max() < 1e-6


def test_a_single_frame_survives_every_edit():
    clip = smooth_clip().trimmed(0.5, 0.5)
    for edited in (clip.resampled(30.0), clip.retimed(2.0), clip.mirrored(), clip.grounded()):
        assert edited.frames == 1
    assert clip.repaired() is clip
    assert edits.joint_velocities(clip).max() == 0.0


def test_retiming_scales_speed_and_keeps_the_path():
    clip = spin(2.0, 60.0, 121)
    fast = clip.retimed(1.33)
    assert fast.rate == clip.rate
    assert fast.duration == pytest.approx(2.0 / 1.33, abs=1 / 60)
    np.testing.assert_allclose(edits.joint_velocities(fast)[:, 0, 0], 1.33, atol=1e-9)
    omega = edits.angular_velocities(fast)[:, 0, 2]
    np.testing.assert_allclose(omega, 2.66, atol=1e-4)
    back = smooth_clip().retimed(0.5).retimed(2.0)
    assert worst_angle(back, smooth_clip()) < 1e-6
    assert clip.retimed(1.0) is clip
    with pytest.raises(InvalidValue, match="speed is"):
        clip.retimed(0.0)


def test_velocities_and_accelerations_of_a_spin_match_the_closed_form():
    omega, rate = 2.0, 500.0
    clip = spin(omega, rate, 501)
    for smoothing in (0.0, 0.03):
        velocity = edits.joint_velocities(clip, smoothing=smoothing)[:, 1]
        expected = np.stack(
            (1 - omega * np.sin(omega * clip.times), omega * np.cos(omega * clip.times)), axis=-1
        )
        np.testing.assert_allclose(velocity[:, :2], expected, atol=2e-3)
        acceleration = edits.joint_accelerations(clip, smoothing=smoothing)[20:-20, 1]
        size = np.linalg.norm(acceleration, axis=-1)
        np.testing.assert_allclose(size, omega**2, rtol=1e-3)
        spinning = edits.angular_velocities(clip, smoothing=smoothing)
        np.testing.assert_allclose(spinning[:, :, 2], omega, atol=1e-3)
        np.testing.assert_allclose(spinning[:, 1, :2], 0.0, atol=1e-9)
        local = edits.angular_velocities(clip, smoothing=smoothing, world=False)
        np.testing.assert_allclose(local[:, 1], 0.0, atol=1e-9)
        turning = edits.angular_accelerations(clip, smoothing=smoothing)
        np.testing.assert_allclose(turning[20:-20], 0.0, atol=1e-6)


def test_derivative_of_a_parabola_is_exact_to_its_ends():
    t = np.arange(9) / 10.0
    np.testing.assert_allclose(edits.derivative(3 * t**2, 10.0), 6 * t, atol=1e-12)
    np.testing.assert_allclose(edits.derivative(3 * t**2, 10.0, order=2), 6.0, atol=1e-9)
    np.testing.assert_allclose(edits.derivative(3 * t**2, 10.0, smoothing=0.5), 6 * t, atol=1e-9)
    assert edits.derivative([[1.0, 2.0]], 10.0).tolist() == [[0.0, 0.0]]
    np.testing.assert_allclose(edits.derivative([0.0, 1.0], 10.0), 10.0)
    for bad in ({"order": 3}, {"smoothing": -1.0}):
        with pytest.raises(InvalidValue):
            edits.derivative(t, 10.0, **bad)


# -- mirror ---------------------------------------------------------------------------------------

STYLES = {
    "LeftUpLeg": "RightUpLeg",
    "lfemur": "rfemur",
    "LThumb": "RThumb",
    "lShldr": "rShldr",
    "leftEye": "rightEye",
    "Bip01 L Thigh": "Bip01 R Thigh",
    "hand_l": "hand_r",
    "thigh.L": "thigh.R",
    "L_Hip": "R_Hip",
    "ThighL": "ThighR",
    "ELBOW_LEFT": "ELBOW_RIGHT",
    "mixamorig:LeftArm": "mixamorig:RightArm",
}


def pair_of(left: str, right: str) -> Skeleton:
    return Skeleton(
        names=("hips", "lowerback", left, right, "tail"),
        parents=(-1, 0, 0, 0, 1),
        offsets=np.array([[0, 0, 1.0], [0, 0, 0.1], [0.3, 0, 0], [-0.2, 0.1, 0], [0, 0.2, 0.1]]),
    )


@pytest.mark.parametrize(("left", "right"), STYLES.items())
def test_partners_are_found_in_every_style_of_naming(left, right):
    body = pair_of(left, right)
    assert mirror.partners(body) == (0, 1, 3, 2, 4)
    assert [mirror.side(body, i) for i in range(5)] == [0, 0, 1, -1, 0]


def test_partners_are_found_from_symmetry_where_names_say_nothing():
    body = figure()
    plain = replace(body, names=tuple(f"joint{i}" for i in range(len(body))))
    assert mirror.partners(plain) == mirror.partners(body)


@pytest.mark.parametrize("asymmetric", [False, True])
def test_mirroring_twice_is_the_identity(asymmetric):
    clip = smooth_clip()
    if asymmetric:  # a rest pose with one arm up, and a longer left leg
        offsets = np.array(clip.skeleton.offsets)
        offsets[clip.skeleton.index("left_elbow")] = [0.0, 0.05, 0.3]
        offsets[clip.skeleton.index("left_knee")] *= 1.1
        clip = replace(clip, skeleton=replace(clip.skeleton, offsets=offsets))
    twice = clip.mirrored().mirrored()
    np.testing.assert_allclose(twice.rotations, clip.rotations, atol=1e-9)
    np.testing.assert_allclose(twice.root_positions, clip.root_positions, atol=1e-9)
    np.testing.assert_allclose(twice.skeleton.offsets, clip.skeleton.offsets, atol=1e-9)
    assert twice.skeleton.end_joints == clip.skeleton.end_joints
    assert len(twice.notes) == len(clip.notes) + 2


@pytest.mark.parametrize("asymmetric", [False, True])
def test_mirrored_joints_move_along_the_mirror_image_of_their_partners(asymmetric):
    clip = smooth_clip()
    if asymmetric:
        offsets = np.array(clip.skeleton.offsets)
        offsets[clip.skeleton.index("right_ankle")] = [0.1, 0.0, -0.3]
        clip = replace(clip, skeleton=replace(clip.skeleton, offsets=offsets))
    partner = list(mirror.partners(clip.skeleton))
    there, here = clip.forward_kinematics(), clip.mirrored().forward_kinematics()
    flip = np.array([1.0, -1.0, 1.0])
    np.testing.assert_allclose(here.positions, there.positions[:, partner] * flip, atol=1e-12)
    assert (clip.mirrored().skeleton is clip.skeleton) != asymmetric


def test_a_chain_without_sides_mirrors_onto_itself():
    offsets = np.array([[0, 0, 0], [1.0, 0, 0], [1.0, 0, 0]])
    snake = Skeleton(names=("a", "b", "c"), parents=(-1, 0, 1), offsets=offsets)
    assert mirror.partners(snake) == (0, 1, 2)
    np.testing.assert_array_equal(mirror.sagittal_axis(snake), [0, 1, 0])


def test_ends_go_with_their_joints():
    body = Skeleton(
        names=("hips", "left_arm", "right_arm"), parents=(-1, 0, 0),
        offsets=np.array([[0, 0, 1.0], [0, 0.3, 0], [0, -0.3, 0]]),
        end_joints=(1, 1, 2), end_offsets=np.array([[0, 0.1, 0], [0.1, 0.1, 0], [0, -0.1, 0]]),
    )  # fmt: skip
    clip = Clip(
        skeleton=body, rotations=rot.identity(2, 3), root_positions=np.zeros((2, 3)), rate=10
    )
    there, here = clip.forward_kinematics().ends, clip.mirrored().forward_kinematics().ends
    np.testing.assert_allclose(here, there * [1, -1, 1], atol=1e-12)
    twice = clip.mirrored().mirrored().skeleton
    np.testing.assert_allclose(twice.end_offsets, body.end_offsets)


@pytest.mark.clips
@pytest.mark.parametrize(
    ("file", "pairs"),
    [
        ("cmu_bvh/02_01.bvh", 12),
        ("cmu_daz_bvh/02_01.bvh", 18),
        ("cmu_3dsmax_bvh/131_01.bvh", 12),
        ("cmu_asfamc/02_01.amc", 12),
        ("other_bvh/jesse_dance.bvh", 27),
    ],
)
def test_real_skeletons_pair_every_limb(clips: Path, file, pairs):
    from understudy.motion.read import read

    clip = read(clips / file)
    partner = mirror.partners(clip.skeleton)
    assert sum(i < j for i, j in enumerate(partner)) >= pairs
    sided = [n for i, n in enumerate(clip.skeleton.names) if mirror.side(clip.skeleton, i)]
    assert all(partner[clip.skeleton.index(n)] != clip.skeleton.index(n) for n in sided)
    twice = clip.mirrored().mirrored()
    np.testing.assert_allclose(twice.rotations, clip.rotations, atol=1e-9)
    np.testing.assert_allclose(twice.root_positions, clip.root_positions, atol=1e-9)


def test_placing_there_and_back_is_the_clip():
    clip = smooth_clip()
    out = clip.placed(at=(4.0, -2.0), heading=2.5)
    back = out.placed(at=clip.root_positions[0, :2], heading=-2.5)
    np.testing.assert_allclose(back.root_positions, clip.root_positions, atol=1e-12)
    assert worst_angle(back, clip) < 1e-7
    assert clip.placed().root_positions == pytest.approx(clip.root_positions)


def test_placing_moves_everything_rigidly_over_the_ground():
    clip, turn = smooth_clip(), rot.from_rotvec([0.0, 0.0, 0.7])
    out = clip.placed(at=(4.0, -2.0), heading=0.7)
    about = clip.root_positions[0] * [1.0, 1.0, 0.0]
    before, after = clip.forward_kinematics(), out.forward_kinematics()
    expected = rot.rotate(turn, before.positions - about) + np.array([4.0, -2.0, 0.0])
    np.testing.assert_allclose(after.positions, expected, atol=1e-12)
    np.testing.assert_allclose(out.root_positions[0, :2], [4.0, -2.0], atol=1e-12)
    np.testing.assert_array_equal(out.rotations[:, 1:], clip.rotations[:, 1:])


@pytest.mark.parametrize("options", [{"at": (1.0,)}, {"at": (1.0, np.nan)}, {"heading": np.inf}])
def test_placing_nowhere_is_refused(options):
    with pytest.raises(InvalidValue):
        smooth_clip().placed(**options)
