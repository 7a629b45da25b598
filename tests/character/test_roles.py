from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from people import DIALECTS, moving, person, renamed, still, without

from understudy.character.mapping import Mapping, read_mapping
from understudy.character.names import hints
from understudy.character.roles import find_roles
from understudy.errors import ClipError, InvalidValue, UnknownName
from understudy.motion.clip import Clip
from understudy.motion.figure import ROLES
from understudy.motion.skeleton import Skeleton

HANDS = ("left_wrist", "right_wrist")


def expected(names: dict[str, str], *gone: str) -> dict[str, str]:
    return {role: names[role] for role in ROLES if role not in gone}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_role_is_found_in_every_dialect(dialect):
    names = DIALECTS[dialect]
    roles = find_roles(still(renamed(person(), names)))
    assert roles.joints == expected(names)
    assert roles.confidence > 0.7


@pytest.mark.parametrize("dialect", ["motionbuilder", "meaningless"])
@pytest.mark.parametrize(
    "gone",
    [
        ("left_ball", "right_ball"),
        ("neck",),
        HANDS,
        ("neck", "left_ball", "right_ball", *HANDS),
    ],
)
def test_missing_joints_are_missing_roles(dialect, gone):
    names = DIALECTS[dialect]
    skeleton = renamed(without(person(), *gone), names)
    roles = find_roles(still(skeleton))
    assert roles.joints == expected(names, *gone)


def test_a_body_without_legs_has_a_trunk_and_arms():
    names = DIALECTS["motionbuilder"]
    legs = [r for r in ROLES if r.split("_")[-1] in ("hip", "knee", "ankle", "ball")]
    roles = find_roles(still(renamed(without(person(), "left_hip", "right_hip"), names)))
    assert roles.joints == expected(names, *legs)


def test_a_body_without_arms_has_legs():
    names = DIALECTS["motionbuilder"]
    skeleton = renamed(without(person(), "left_shoulder", "right_shoulder"), names)
    found = find_roles(still(skeleton)).joints
    assert found["left_knee"] == "LeftLeg"
    assert not any("elbow" in role for role in found)


def test_a_one_armed_person_keeps_the_roles_of_the_rest():
    names = DIALECTS["motionbuilder"]
    roles = find_roles(still(renamed(without(person(), "left_shoulder"), names)))
    assert roles.joints["right_knee"] == "RightLeg"
    assert len(set(roles.joints.values())) == len(roles.joints)


def test_left_and_right_go_by_geometry_where_names_are_silent():
    roles = find_roles(still(renamed(person(), DIALECTS["meaningless"])))
    skeleton = renamed(person(), DIALECTS["meaningless"])
    assert skeleton.rest_positions()[skeleton.index(roles.joints["left_hip"]), 1] > 0
    assert "feet" in roles.reason


def test_names_overrule_geometry_on_left_and_right():
    """A file that calls the right side left is believed."""
    names = DIALECTS["motionbuilder"]
    other = {"left": "right", "right": "left"}
    swapped = {
        role: names[role.replace(role.split("_")[0], other[role.split("_")[0]], 1)]
        if role.startswith(("left", "right"))
        else name
        for role, name in names.items()
    }
    roles = find_roles(still(renamed(person(), swapped)))
    assert roles.joints["left_knee"] == "LeftLeg"


def test_zero_length_joints_and_fingers_are_no_links():
    skeleton = with_extras(renamed(person(), DIALECTS["motionbuilder"]))
    roles = find_roles(still(skeleton))
    assert roles.joints == expected(DIALECTS["motionbuilder"])
    assert "LHipJoint" in roles.folded
    assert {"LeftThumb1", "Tail"} <= set(roles.dropped)


def with_extras(skeleton: Skeleton) -> Skeleton:
    """Joints of other files: a zero-length one before the hip, a thumb, a tail."""
    names = list(skeleton.names)
    at = names.index("LeftUpLeg")
    names.insert(at, "LHipJoint")
    parents = [p + (p >= at) for p in skeleton.parents]
    parents.insert(at, 0)
    parents[at + 1] = at
    offsets = np.insert(skeleton.offsets, at, 0.0, axis=0)
    names += ["LeftThumb1", "Tail"]
    parents += [names.index("LeftHand"), 0]
    offsets = np.concatenate([offsets, [[0.03, 0.04, 0.0], [-0.2, 0.0, 0.0]]])
    ends = (*tuple(j + (j >= at) for j in skeleton.end_joints), len(names) - 1)
    return Skeleton(
        names=tuple(names),
        parents=tuple(parents),
        offsets=offsets,
        end_joints=ends,
        end_offsets=np.concatenate([skeleton.end_offsets, [[-0.2, 0.0, 0.0]]]),
    )


def dog() -> Skeleton:
    """A horizontal spine on four legs."""
    names, parents, offsets = ["root"], [-1], [[0.0, 0.0, 0.5]]

    def add(name, parent, offset):
        names.append(name)
        parents.append(names.index(parent))
        offsets.append(offset)

    add("b1", "root", [0.2, 0, 0])
    add("b2", "b1", [0.3, 0, 0])
    add("n", "b2", [0.15, 0, 0.1])
    add("m", "n", [0.1, 0, 0])
    for parent, x in (("root", "h"), ("b2", "f")):
        for side, y in (("p", 0.08), ("q", -0.08)):
            add(f"{x}{side}1", parent, [0, y, 0])
            add(f"{x}{side}2", f"{x}{side}1", [0, 0, -0.22])
            add(f"{x}{side}3", f"{x}{side}2", [0, 0, -0.22])
            add(f"{x}{side}4", f"{x}{side}3", [0.05, 0, -0.04])
    return Skeleton(names=tuple(names), parents=tuple(parents), offsets=np.array(offsets))


def chain(joints: int) -> Skeleton:
    return Skeleton(
        names=tuple(f"c{i}" for i in range(joints)),
        parents=tuple(range(-1, joints - 1)),
        offsets=np.tile([0.1, 0.0, 0.0], (joints, 1)),
    )


@pytest.mark.parametrize("skeleton", [dog(), chain(1), chain(2), chain(12)])
def test_what_is_no_person_has_no_roles(skeleton):
    roles = find_roles(still(skeleton))
    assert not roles
    assert roles.reason


def test_a_mapping_overrules_what_is_found():
    skeleton = with_extras(renamed(person(), DIALECTS["motionbuilder"]))
    said = Mapping(roles={"left_hip": "LHipJoint"}, drop=("Tail",), fold=())
    roles = find_roles(still(skeleton), mapping=said)
    assert roles.joints["left_hip"] == "LHipJoint"
    assert roles.get("left_hip").confidence == 1.0


def test_one_joint_has_one_role():
    clip = still(renamed(person(), DIALECTS["motionbuilder"]))
    with pytest.raises(InvalidValue, match="two roles"):
        find_roles(clip, mapping=Mapping(roles={"left_elbow": "LeftLeg"}))


def test_a_mapping_that_contradicts_the_tree_is_refused():
    clip = still(renamed(person(), DIALECTS["motionbuilder"]))
    crossed = {"left_elbow": "RightForeArm", "right_elbow": "LeftForeArm"}
    with pytest.raises(InvalidValue, match=r"'RightForeArm' \(left_elbow\) does not hang on"):
        find_roles(clip, mapping=Mapping(roles=crossed))
    with pytest.raises(InvalidValue, match="give pelvis as well"):
        find_roles(still(chain(4)), mapping=Mapping(roles={"left_knee": "c1"}))


def test_a_mapping_alone_makes_a_person():
    """A tree in which nothing is found, every role said."""
    skeleton = renamed(person(), DIALECTS["meaningless"])
    said = dict(DIALECTS["meaningless"])
    roles = find_roles(still(skeleton), mapping=Mapping(roles=said))
    assert roles.joints == said
    assert roles.confidence == 1.0


def test_a_mapping_names_joints_that_exist():
    clip = still(renamed(person(), DIALECTS["motionbuilder"]))
    with pytest.raises(UnknownName, match="Did you mean 'LeftLeg'"):
        find_roles(clip, mapping=Mapping(roles={"left_knee": "LeftLge"}))
    with pytest.raises(UnknownName, match="Did you mean 'left_knee'"):
        Mapping(roles={"left_nee": "LeftLeg"})


def test_a_mapping_file_is_read(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('[roles]\nleft_knee = "LeftLeg"\n[fold]\njoints = ["LHipJoint"]\n')
    mapping = read_mapping(path)
    assert mapping.roles == {"left_knee": "LeftLeg"}
    assert mapping.fold == ("LHipJoint",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[roles]\nleft_nee = "LeftLeg"\n', r"map.toml:2: .*Did you mean 'left_knee'"),
        ("[roles]\n\nleft_knee = 3\n", r"map.toml:3: left_knee is 3"),
        ("[rolls]\n", r"map.toml:1: .*Did you mean 'roles'"),
        ('[drop]\njoint = ["Tail"]\n', r"map.toml:2: .*Did you mean 'joints'"),
        ('[drop]\njoints = "Tail"\n', r"map.toml:2: joints must be a list"),
        ("[roles\n", r"map.toml:1: is not TOML"),
        ("roles = 1\n", r"map.toml:1: roles must be a table"),
    ],
)
def test_errors_in_a_mapping_file_name_the_line(tmp_path, text, message):
    path = tmp_path / "map.toml"
    path.write_text(text)
    with pytest.raises(ClipError, match=message):
        read_mapping(path)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('[roles]\nleft_knee = "LeftLge"\n', 2),
        ('[fold]\njoints = ["LeftLge"]\n', 2),
        ('# "LeftLge" is not here\n[drop]\njoints = [\n  "LeftLeg", # thin\n  "LeftLge",\n]\n', 5),
    ],
)
def test_a_joint_that_a_mapping_file_misspells_is_found_in_it(tmp_path, text, line):
    path = tmp_path / "map.toml"
    path.write_text(text)
    clip = still(renamed(person(), DIALECTS["motionbuilder"]))
    with pytest.raises(ClipError, match=rf"map.toml:{line}: No joint .*mean 'LeftLeg'"):
        find_roles(clip, mapping=read_mapping(path))


def test_a_missing_mapping_file_is_said(tmp_path):
    with pytest.raises(ClipError, match="no such file"):
        read_mapping(tmp_path / "none.toml")


def test_roles_print_joint_and_reason():
    text = str(find_roles(still(renamed(person(), DIALECTS["daz"]))))
    assert "left_knee" in text
    assert "lShin" in text
    assert "95 %" in text
    assert str(find_roles(still(chain(3)))).startswith("no roles")


def test_words_that_end_in_l_or_r_are_no_side():
    names = ("Collar", "LeftCollar", "rShldr", "Pelvis", "Root", "thigh.L", "Tail")
    assert [h.side for h in hints(names)] == ["", "left", "right", "", "", "left", ""]


def test_roles_do_not_depend_on_the_motion():
    skeleton = renamed(person(), DIALECTS["motionbuilder"])
    for seed in range(3):
        clip = moving(skeleton, seed=seed, size=1.5)
        assert find_roles(clip).joints == expected(DIALECTS["motionbuilder"])


def test_a_person_lying_down_is_known_by_name():
    skeleton = renamed(person(), DIALECTS["motionbuilder"])
    flat = replace(still(skeleton), rotations=lying(still(skeleton)))
    assert find_roles(flat).joints["left_knee"] == "LeftLeg"


def lying(clip: Clip) -> np.ndarray:
    rotations = np.array(clip.rotations)
    rotations[:, 0] = [np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0]
    return rotations
