"""Acclaim: rest axes, orders of freedoms and units, and agreement with another conversion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from understudy.errors import ClipError
from understudy.motion import rotations as rot
from understudy.motion.acclaim import read_acclaim
from understudy.motion.bvh import read_bvh, write_bvh
from understudy.motion.clip import Clip
from understudy.motion.skeleton import Skeleton

ASF = """# made by hand
:version 1.10
:name arm
:units
  mass 1.0
  length 0.5
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name upper
     direction 1 0 0
     length 2
     axis 0 0 30 XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 2
     name lower
     direction 0 3 0
     length 4
     axis 10 20 30 ZYX
    dof rx rz
  end
:hierarchy
  begin
    root upper
    upper lower
  end
"""
AMC = """#!OML:ASF H:\\somewhere\\else.ASF
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 10 20 30
upper 40 50 60
lower 70 80
2
root 1 2 4 11 21 31
upper 41 51 61
lower 71 81
"""


@pytest.fixture
def saved(tmp_path: Path):
    def read(amc: str = AMC, asf: str | None = ASF, **options) -> Clip:
        if asf is not None:
            (tmp_path / "07.asf").write_text(asf)
        (tmp_path / "07_01.amc").write_text(amc)
        options = {"up": "z", "unit": 1.0, "t_pose": "keep", **options}
        return read_acclaim(tmp_path / "07_01.amc", **options)

    return read


def fixed(order: str, *degrees: float) -> np.ndarray:
    """Turns about fixed axes, the first listed applied first."""
    total = np.eye(3)
    for axis, angle in zip(order, np.radians(degrees), strict=True):
        total = rot.to_matrix(rot.from_euler(axis, [angle])) @ total
    return total


def test_a_bone_turns_by_its_values_about_its_rest_axis(saved):
    clip = saved()
    c = fixed("XYZ", 0, 0, 30)
    expected = c @ fixed("XYZ", 40, 50, 60) @ c.T
    np.testing.assert_allclose(rot.to_matrix(clip.joint("upper")[0]), expected, atol=1e-12)
    c = fixed("ZYX", 10, 20, 30)
    expected = c @ fixed("XZ", 70, 80) @ c.T
    np.testing.assert_allclose(rot.to_matrix(clip.joint("lower")[0]), expected, atol=1e-12)


def test_the_root_turns_and_moves_in_the_order_of_the_skeleton(saved):
    clip = saved()
    np.testing.assert_allclose(
        rot.to_matrix(clip.joint("root")[0]), fixed("XYZ", 10, 20, 30), atol=1e-12
    )
    np.testing.assert_allclose(clip.root_positions, [[1, 2, 3], [1, 2, 4]])
    order = ASF.replace("TX TY TZ RX RY RZ", "RZ RY RX TZ TY TX")
    clip = saved(asf=order)
    np.testing.assert_allclose(
        rot.to_matrix(clip.joint("root")[0]), fixed("ZYX", 1, 2, 3), atol=1e-12
    )
    np.testing.assert_allclose(clip.root_positions[0], [30, 20, 10])


def test_a_bone_starts_where_its_parent_ends(saved):
    clip = saved()
    np.testing.assert_allclose(clip.skeleton.offsets, [[0, 0, 0], [0, 0, 0], [2, 0, 0]])
    np.testing.assert_allclose(clip.skeleton.end_offsets, [[0, 4, 0]])
    assert clip.skeleton.names == ("root", "upper", "lower")


def test_lengths_are_inches_over_the_stated_length(saved):
    clip = saved(unit=None)
    assert clip.conventions.unit == pytest.approx(0.0254 / 0.5)
    assert any("as the file states" in note for note in clip.notes)


def test_radians_are_taken_where_a_file_says_so(saved):
    rows = []
    for line in AMC.replace(":DEGREES", ":RADIANS").splitlines():
        words = line.split()
        if words and words[0] in ("root", "upper", "lower"):
            moves = 3 if words[0] == "root" else 0
            words[1 + moves :] = [repr(float(np.radians(float(w)))) for w in words[1 + moves :]]
        rows.append(" ".join(words))
    axes = ASF.replace("angle deg", "angle rad").replace(
        "0 0 30 XYZ", f"0 0 {float(np.radians(30))!r} XYZ"
    )
    axes = axes.replace(
        "10 20 30 ZYX", " ".join(map(repr, np.radians([10, 20, 30]).tolist())) + " ZYX"
    )
    other = saved("\n".join(rows), axes)
    assert rot.angle_between(saved().rotations, other.rotations).max() < 1e-12


def test_the_rate_is_assumed_with_a_note_or_given(saved):
    assert saved().rate == 120.0
    assert any("120 Hz assumed" in note for note in saved().notes)
    assert saved(rate=60).rate == 60.0
    assert not any("assumed; pass rate=" in note for note in saved(rate=60).notes)


def test_the_skeleton_is_found_beside_or_given(saved, tmp_path):
    saved()
    (tmp_path / "07.asf").rename(tmp_path / "body.asf")
    saved(asf=None)
    (tmp_path / "other.asf").write_text(ASF)
    with pytest.raises(ClipError, match=r"needs its skeleton, 07\.asf.*body\.asf, other\.asf"):
        read_acclaim(tmp_path / "07_01.amc")
    read_acclaim(tmp_path / "07_01.amc", asf=tmp_path / "body.asf")
    with pytest.raises(ClipError, match="give the AMC file"):
        read_acclaim(tmp_path / "body.asf")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.replace("lower 71 81\n", ""), "frame 2 lacks bone 'lower'"),
        (lambda t: t.replace("lower 70 80\n", ""), "amc:10: bone 'lower' is listed late"),
        (lambda t: t + "lower 1 2\n", "amc:12: bone 'lower' is listed twice"),
        (lambda t: t.replace("lower 71 81", "lower 71"), "amc:11: bone 'lower' has 1 values"),
        (lambda t: t.replace("lower 71 81", "tail 71 81"), "amc:11: bone 'tail' is not in"),
        (lambda t: t.replace("71 81", "71 x"), "amc:11: bone 'lower': could not convert"),
        (lambda t: t.replace("71 81", "71 nan"), "amc:11: bone 'lower' has a value"),
        (lambda t: t.replace("\n1\n", "\n"), "amc:4: 'root' comes before the first frame"),
        (lambda t: ":DEGREES\n", "holds no frames"),
    ],
)
def test_broken_motion_is_refused_with_its_line(saved, change, message):
    with pytest.raises(ClipError, match=message):
        saved(change(AMC))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda t: t.replace("upper lower\n", "upper lowe\n"),
            r"asf:36: .*'lowe', which is no bone",
        ),
        (lambda t: t.replace("    upper lower\n", ""), "leads from the root to no 'lower'"),
        (lambda t: t.replace("upper lower\n", "upper lower\n    lower upper\n"), "two parents"),
        (lambda t: t.replace("name lower", "name upper"), "'upper' is missing or used twice"),
        (lambda t: t.replace("dof rx rz", "dof rx rq"), r"asf:31: 'rq' is unknown"),
        (lambda t: t.replace("30 ZYX", "30 ZYY"), r"asf:30: axis order 'ZYY'"),
        (lambda t: t.replace("length 4", "length x"), r"asf:29: .*a number belongs here"),
        (lambda t: t.replace("length 0.5", "length 0"), r"asf:6: length is 0"),
        (lambda t: t.replace(":root", ":rood"), "has no :root section"),
        (lambda t: t.replace(":hierarchy", ":other"), "has no :hierarchy section"),
    ],
)
def test_broken_skeletons_are_refused_with_their_line(saved, change, message):
    with pytest.raises(ClipError, match=message):
        saved(asf=change(ASF))


# Names of the same joints in the conversion to BVH for MotionBuilder.
BVH_NAMES = {
    "root": "Hips",
    "lowerback": "LowerBack",
    "upperback": "Spine",
    "thorax": "Spine1",
    "lowerneck": "Neck",
    "upperneck": "Neck1",
    "head": "Head",
    "lhipjoint": "LHipJoint",
    "rhipjoint": "RHipJoint",
    "lthumb": "LThumb",
    "rthumb": "RThumb",
    **{
        f"{short}{bone}": f"{side}{joint}"
        for short, side in (("l", "Left"), ("r", "Right"))
        for bone, joint in (
            ("femur", "UpLeg"),
            ("tibia", "Leg"),
            ("foot", "Foot"),
            ("toes", "ToeBase"),
            ("clavicle", "Shoulder"),
            ("humerus", "Arm"),
            ("radius", "ForeArm"),
            ("wrist", "Hand"),
            ("hand", "FingerBase"),
            ("fingers", "HandIndex1"),
        )
    },
}


@pytest.mark.clips
@pytest.mark.parametrize("trial", ["02_01", "02_03", "05_06"])
def test_amc_agrees_with_its_conversion_to_bvh(clips, trial):
    """The conversion holds one more frame, a T-pose, and leaves out the lengths of four bones."""
    amc = read_acclaim(clips / f"cmu_asfamc/{trial}.amc")
    bvh = read_bvh(clips / f"cmu_bvh/{trial}.bvh")
    assert bvh.frames == amc.frames
    order = [bvh.skeleton.index(BVH_NAMES[name]) for name in amc.skeleton.names]
    ours, theirs = amc.forward_kinematics(), bvh.forward_kinematics()
    apart = rot.angle_between(ours.rotations, theirs.rotations[:, order])
    assert np.degrees(apart.max()) < 1e-3
    lengths = np.linalg.norm(amc.skeleton.offsets, axis=1)
    converted = np.linalg.norm(bvh.skeleton.offsets[order], axis=1)
    kept = np.abs(lengths - converted) < 1e-5
    left_out = [name for name, k in zip(amc.skeleton.names, kept, strict=True) if not k]
    assert sorted(left_out) == sorted(
        ["lowerneck", "lclavicle", "rclavicle", "lhand", "lthumb", "rhand", "rthumb"]
    )
    # Joints that hang from no such bone are where the conversion has them.
    whole = kept.copy()
    for j, parent in enumerate(amc.skeleton.parents[1:], 1):
        whole[j] &= whole[parent]
    assert whole.sum() == 14
    gap = np.abs(ours.positions - theirs.positions[:, order])[:, whole]
    assert gap.max() < 1e-5
    # With the conversion's offsets under the AMC's rotations, all joints are.
    same = Clip(
        skeleton=Skeleton(
            names=amc.skeleton.names,
            parents=amc.skeleton.parents,
            offsets=bvh.skeleton.offsets[order],
        ),
        rotations=amc.rotations,
        root_positions=amc.root_positions,
        rate=amc.rate,
    )
    gap = np.abs(same.forward_kinematics().positions - theirs.positions[:, order])
    assert gap.max() < 1e-5


@pytest.mark.clips
def test_every_real_amc_stands_and_comes_back_from_bvh(clips, tmp_path):
    for path in sorted(clips.glob("*/*.amc")):
        clip = read_acclaim(path)
        pose = clip.forward_kinematics()
        heights = np.concatenate((pose.positions[..., 2], pose.ends[..., 2]), axis=1)
        assert 1.45 < np.percentile(np.ptp(heights, axis=1), 90) < 1.75, path
        assert -0.14 < heights.min() < 0.03, path
        write_bvh(clip, tmp_path / "a.bvh")
        back = read_bvh(tmp_path / "a.bvh")
        assert back.frames == clip.frames and back.conventions == clip.conventions, path
        again = back.forward_kinematics()
        assert np.abs(pose.positions - again.positions).max() < 1e-6, path
        assert np.degrees(rot.angle_between(pose.rotations, again.rotations).max()) < 1e-4, path
