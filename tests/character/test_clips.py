"""Real clips of every dialect at hand: which joint is which, and what the bodies weigh."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from understudy.character import adult_man, find_roles, restored, retargeted
from understudy.character.body import Character
from understudy.motion.figure import ROLES
from understudy.motion.read import read

pytestmark = pytest.mark.clips


def table(middle: str, left: str, right: str, kinds: str) -> dict[str, str]:
    """Clip joint by role, from names in the order of `kinds` for either side."""
    out = dict(zip(("pelvis", "lower_back", "upper_back", "neck"), middle.split(), strict=False))
    for side, names in (("left", left), ("right", right)):
        named = zip(kinds.split(), names.split(), strict=True)
        out |= {f"{side}_{kind}": joint for kind, joint in named}
    return out


ALL = "shoulder elbow wrist hip knee ankle ball"
NO_TOES = "shoulder elbow wrist hip knee ankle"
MOTIONBUILDER = table(
    "Hips LowerBack Spine1 Head",
    "LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot LeftToeBase",
    "RightArm RightForeArm RightHand RightUpLeg RightLeg RightFoot RightToeBase",
    ALL,
)
MAX = table(
    "Hips lowerback Chest2 Head",
    "LeftShoulder LeftElbow LeftWrist LeftHip LeftKnee LeftAnkle LeftToe",
    "RightShoulder RightElbow RightWrist RightHip RightKnee RightAnkle RightToe",
    ALL,
)
DAZ = table(
    "hip abdomen chest head",
    "lShldr lForeArm lHand lThigh lShin lFoot",
    "rShldr rForeArm rHand rThigh rShin rFoot",
    NO_TOES,
)
ACCLAIM = table(
    "root lowerback thorax head",
    "lhumerus lradius lwrist lfemur ltibia lfoot ltoes",
    "rhumerus rradius rwrist rfemur rtibia rfoot rtoes",
    ALL,
)
HIK = MOTIONBUILDER | {"lower_back": "Spine", "upper_back": "Spine3"}
CLASSIC = table(
    "Hips Chest Chest2 Head",
    "LeftShoulder LeftElbow LeftWrist LeftHip LeftKnee LeftAnkle",
    "RightShoulder RightElbow RightWrist RightHip RightKnee RightAnkle",
    NO_TOES,
)
SHORT = {
    role: joint
    for role, joint in table(
        "Hips - Chest Head",
        "LeftUpArm LeftLowArm LeftHand LeftUpLeg LeftLowLeg LeftFoot",
        "RightUpArm RightLowArm RightHand RightUpLeg RightLowLeg RightFoot",
        NO_TOES,
    ).items()
    if joint != "-"
}

EXPECTED: dict[str, dict[str, str]] = {
    "cmu_bvh/*.bvh": MOTIONBUILDER,
    "cmu_3dsmax_bvh/*.bvh": MAX,
    "cmu_daz_bvh/*.bvh": DAZ,
    "cmu_asfamc/*.amc": ACCLAIM,
    "other_bvh/dab.bvh": HIK,
    "other_bvh/wave_hello.bvh": HIK,
    "other_bvh/zombie.bvh": HIK,
    "other_bvh/jesse_dance.bvh": HIK | {"upper_back": "Spine2"},
    "other_bvh/jumping_jacks.bvh": MAX,
    "odd_bvh/test_mocapbank.bvh": CLASSIC,
    "odd_bvh/bvhio_example.bvh": SHORT,
    "odd_bvh/pybvh_test1.bvh": HIK,
}


def files(clips: Path) -> list[tuple[Path, dict[str, str]]]:
    return [(path, roles) for glob, roles in EXPECTED.items() for path in sorted(clips.glob(glob))]


@pytest.fixture(scope="module")
def people(clips: Path) -> list:
    """Every person's clip, its path and its expected roles."""
    found = [(read(path), path, roles) for path, roles in files(clips)]
    assert len(found) >= 30
    return found


@pytest.fixture(scope="module")
def performers(people) -> list:
    """Every person's clip, its path and its own character."""
    return [(clip, path, Character.from_clip(clip)) for clip, path, _ in people]


def test_roles_are_found_in_every_file(people):
    for clip, path, expected in people:
        roles = find_roles(clip)
        assert roles.joints == expected, path
        assert roles.confidence > 0.9, path


def test_roles_are_found_without_names(people):
    for clip, path, expected in people:
        names = tuple(f"j{i}" for i in range(len(clip.skeleton)))
        bare = replace(clip, skeleton=replace(clip.skeleton, names=names))
        found = find_roles(bare).joints
        joints = {role: clip.skeleton.names[int(j[1:])] for role, j in found.items()}
        if expected is ACCLAIM:
            # Its forearm is cut in two; without names either end may be the wrist.
            joints |= {role: expected[role] for role in ("left_wrist", "right_wrist")}
        assert joints == expected, path


def test_what_is_no_person_has_no_roles(clips):
    for name in ("full_precision_frame_time", "rotation_first_root"):
        clip = read(clips / "odd_bvh" / f"{name}.bvh")
        assert not find_roles(clip)
        assert len(Character.from_clip(clip).links) == len(clip.skeleton)


def test_bodies_are_of_human_size(people, performers):
    for (_, path, expected), (_, _, character) in zip(people, performers, strict=True):
        assert 40 < character.mass < 110, path
        assert 1.4 < character.height < 2.0, path
        assert character.simulated_mass == pytest.approx(character.mass)
        assert [link.joint for link in character.links] == [r for r in ROLES if r in expected]


def test_clips_go_onto_their_characters_and_back(performers):
    """Exactly where nothing is folded: hips, legs, and all of the dialects with two back joints."""
    for clip, path, character in performers:
        own = retargeted(clip, character)
        captured, performed = clip.forward_kinematics(), own.forward_kinematics()
        for i, link in enumerate(character.links):
            joint = clip.skeleton.index(link.origin_joint)
            gap = np.linalg.norm(performed.positions[:, i] - captured.positions[:, joint], axis=1)
            side, _, kind = link.joint.partition("_")
            legs = kind in ("hip", "knee", "ankle", "ball") or side == "pelvis"
            # A file may write a leg's offsets with less than a micrometer of play.
            assert gap.max() < (1e-6 if legs else 0.2), (path, link.joint)
        back = restored(own, clip, character).forward_kinematics()
        assert np.abs(back.positions - captured.positions).max() < 1e-9, path


def test_knees_bend_the_human_way(performers):
    """Flexion is about +y."""
    for clip, path, character in performers:
        if clip.frames < 100 or path.stem == "05_06":  # A file with flipped hips.
            continue
        own = retargeted(clip, character)
        for side in ("left", "right"):
            knee = own.joint(f"{side}_knee")
            turn = 2 * np.median(np.sign(knee[:, :1]) * knee[:, 1:], axis=0)
            assert turn[1] > -0.12, (path, side)
            assert abs(turn[0]) < 0.3, (path, side)


def test_a_man_performs_other_peoples_clips(people):
    man = adult_man()
    for clip, path, _ in people[::2]:
        performed = retargeted(clip, man)
        assert performed.frames == clip.frames
        assert np.isfinite(performed.root_positions).all(), path
        # The path is as smooth as the actor's: no pops from one frame to the next.
        jumps = [np.abs(np.diff(c.root_positions[:, 2])).max() for c in (performed, clip)]
        assert jumps[0] < 1.5 * jumps[1] + 0.01, path
