"""BVH: every dialect is read, what is broken is refused in one line, what is written comes back."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from texts import TWO_JOINTS, person

from understudy.errors import ClipError, InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.bvh import read_bvh, write_bvh
from understudy.motion.clip import Clip, Conventions
from understudy.motion.skeleton import Skeleton


@pytest.fixture
def saved(tmp_path: Path):
    """Save a text and read it with the file's own axes and unit, unless told otherwise."""

    def read(text: str | bytes, **options) -> Clip:
        path = tmp_path / "walk.bvh"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_bvh(path, **{"up": "z", "unit": 1.0, "t_pose": "keep", **options})

    return read


def refusal(saved, text: str | bytes, **options) -> str:
    with pytest.raises(ClipError) as caught:
        saved(text, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value).split("walk.bvh", 1)[1]


def euler(order: str, *degrees: float) -> np.ndarray:
    return rot.from_euler(order, np.radians(degrees))


def test_channels_are_turned_in_the_order_listed(saved):
    clip = saved(TWO_JOINTS)
    assert rot.angle_between(clip.joint("Hips")[0], euler("ZXY", 10, 20, 30)) < 1e-12
    assert rot.angle_between(clip.joint("Chest")[2], euler("YXZ", 42, 52, 62)) < 1e-12
    assert clip.conventions.rotation_orders == ("ZXY", "YXZ")


def test_root_position_channels_replace_the_offset(saved):
    clip = saved(TWO_JOINTS)
    np.testing.assert_allclose(clip.root_positions, [[1, 91, 2], [1, 91, 3], [1, 91, 4]])
    np.testing.assert_allclose(clip.skeleton.offsets, [[0, 90, 0], [0, 20, 0]])


def test_end_sites_carry_on_from_their_joint(saved):
    pose = saved(
        TWO_JOINTS.replace("40 50 60", "0 0 0").replace("10 20 30", "0 0 0")
    ).forward_kinematics()
    np.testing.assert_allclose(pose.ends[0, 0], [1, 91 + 50, 2], atol=1e-12)


def test_y_up_files_stand_along_z_in_meters(saved):
    clip = saved(TWO_JOINTS, up="y", unit="cm")
    np.testing.assert_allclose(clip.root_positions[0], [0.01, -0.02, 0.91], atol=1e-12)
    np.testing.assert_allclose(clip.skeleton.offsets[1], [0, 0, 0.2], atol=1e-12)
    turn = rot.from_euler("X", [np.pi / 2])
    expected = rot.multiply(turn, rot.multiply(euler("ZXY", 10, 20, 30), rot.conjugate(turn)))
    assert rot.angle_between(clip.joint("Hips")[0], expected) < 1e-12


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t.replace("\n", "\r\n"),
        lambda t: t.replace("\n", "\r\n", 17),
        lambda t: t.replace("\n", "\r"),
        lambda t: t.replace(" ", "\t"),
        lambda t: t.upper(),
        lambda t: t.lower().replace("hips", "Hips").replace("chest", "Chest"),
        lambda t: t.replace("    ", "").replace("{\n", "{ ").replace("\n}", " }"),
        lambda t: t.replace("1 91 3", "\n\n1 91\n3"),
        lambda t: t.replace("60\n", "60 ").replace("61\n", "61   "),
        lambda t: t.replace("60\n", "60 \n\n"),
        lambda t: "\ufeff" + t,
        lambda t: t.encode("utf-16"),
        lambda t: t.replace("Frames: 3", "Frames:\t3").replace("Frame Time: ", "Frame Time:\t"),
        lambda t: t.replace("Frames: 3\n", "").rstrip(),
        lambda t: t + "\n\n",
    ],
)
def test_layout_does_not_matter(saved, change):
    plain, other = saved(TWO_JOINTS), saved(change(TWO_JOINTS))
    np.testing.assert_array_equal(other.rotations, plain.rotations)
    np.testing.assert_array_equal(other.root_positions, plain.root_positions)
    assert other.rate == plain.rate == 30.0


def test_rotations_may_come_before_positions(saved):
    text = TWO_JOINTS.replace(
        "Xposition Yposition Zposition Zrotation Xrotation Yrotation",
        "Zrotation Xrotation Yrotation Zposition Yposition Xposition",
    )
    for k in range(3):
        text = text.replace(
            f"1 91 {2 + k} {10 + k} {20 + k} {30 + k}", f"{10 + k} {20 + k} {30 + k} {2 + k} 91 1"
        )
    plain, other = saved(TWO_JOINTS), saved(text)
    np.testing.assert_array_equal(other.rotations, plain.rotations)
    np.testing.assert_array_equal(other.root_positions, plain.root_positions)
    assert other.conventions.channels[0] == "ZXYzyx"


@pytest.mark.parametrize(
    "name", ["mixamorig:Chest", "Upper Chest", "Brust_\u00e4", "MOTION", "End"]
)
def test_names_may_hold_anything_but_braces(saved, name):
    assert saved(TWO_JOINTS.replace("JOINT Chest", f"JOINT {name}")).skeleton.names[1] == name


def test_repeated_names_are_numbered_with_a_note(saved):
    clip = saved(TWO_JOINTS.replace("Chest", "Hips"))
    assert clip.skeleton.names == ("Hips", "Hips_2")
    assert any("Hips_2" in note for note in clip.notes)


def test_a_leaf_needs_no_end_site(saved):
    text = TWO_JOINTS.replace("End Site\n        {\n            OFFSET 0 30 0\n        }\n", "")
    assert saved(text).skeleton.end_joints == ()


def _with_chest(channels: str, *rows: str) -> str:
    """Two joints, the chest with other channels and other values."""
    head = TWO_JOINTS.split("1 91 2")[0].replace(
        "CHANNELS 3 Yrotation Xrotation Zrotation", channels
    )
    return head.replace("Frames: 3", f"Frames: {len(rows)}") + "\n".join(
        f"1 91 2 10 20 30 {row}" for row in rows
    )


SIX = "CHANNELS 6 Xposition Yposition Zposition Yrotation Xrotation Zrotation"


def test_constant_joint_positions_replace_the_offset(saved):
    clip = saved(_with_chest(SIX, "1 2 3 0 0 0", "1 2 3 0 0 9"))
    np.testing.assert_allclose(clip.skeleton.offsets[1], [1, 2, 3])
    assert not any("moves against" in note for note in clip.notes)


def test_zero_joint_positions_are_changes_against_the_offset(saved):
    clip = saved(_with_chest(SIX, "0 0 0 0 0 0", "0 0 0 0 0 9"))
    np.testing.assert_allclose(clip.skeleton.offsets[1], [0, 20, 0])


def test_small_joint_positions_are_changes_against_the_offset(saved):
    text = _with_chest(SIX, "0 0.1 0 0 0 0", "0 -0.1 0 0 0 9").replace(
        "        End Site", "        JOINT A { OFFSET 1 0 0 CHANNELS 0 }\n        End Site"
    )
    text = text.replace(
        "    JOINT Chest", "    JOINT B { OFFSET 1 0 0 CHANNELS 0 }\n    JOINT Chest"
    )
    clip = saved(text)
    np.testing.assert_allclose(clip.skeleton.offsets[clip.skeleton.index("Chest")], [0, 20, 0])


def test_moving_joint_positions_keep_their_mean_and_say_so(saved):
    text = _with_chest(SIX, "0 20 0 0 0 0", "0 22 0 0 0 9")
    text = text.replace(
        "    JOINT Chest", "    JOINT Leg { OFFSET 9 0 0 CHANNELS 0 }\n    JOINT Chest"
    )
    clip = saved(text)
    np.testing.assert_allclose(clip.skeleton.offsets[2], [0, 21, 0])
    assert any("'Chest' moves" in note and "1 file units" in note for note in clip.notes)


def test_a_root_that_only_carries_the_hips_is_folded_into_them(saved):
    head = TWO_JOINTS.split("1 91 2")[0].replace("CHANNELS 3 Yrotation Xrotation Zrotation", SIX)
    clip = saved(
        head + "1 0 0 90 0 0 0 20 5 0 0 0\n1 0 0 90 0 0 1 20 5 0 0 0\n1 0 0 90 0 0 2 20 5 0 0 0"
    )
    assert clip.skeleton.names == ("Chest",)
    # The carrier stands at (1, 0, 0), turned by 90 degrees about z: x becomes y.
    np.testing.assert_allclose(
        clip.root_positions, [[-19, 0, 5], [-19, 1, 5], [-19, 2, 5]], atol=1e-12
    )
    assert any("both became one root" in note for note in clip.notes)


@pytest.mark.parametrize(
    ("channels", "values", "order", "degrees"),
    [
        ("CHANNELS 1 Xrotation", "40", "X", (40,)),
        ("CHANNELS 2 Zrotation Yrotation", "40 50", "ZY", (40, 50)),
        ("CHANNELS 3 Zrotation Xrotation Zrotation", "40 50 60", "ZXZ", (40, 50, 60)),
        ("CHANNELS 0", "", "", ()),
        ("", "", "", ()),
    ],
)
def test_a_joint_may_have_any_rotations(saved, channels, values, order, degrees):
    clip = saved(_with_chest(channels, values, values))
    assert rot.angle_between(clip.joint("Chest")[0], euler(order, *degrees)) < 1e-12


def test_a_frame_count_that_disagrees_is_corrected_with_a_note(saved):
    for count in ("2", "500", "1000000000000", "-1"):
        clip = saved(TWO_JOINTS.replace("Frames: 3", f"Frames: {count}"))
        assert clip.frames == 3
        assert any("3 are present" in note for note in clip.notes)


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("0.0333333", 30.0),
        ("0.008333", 120.0),
        ("0.0417083750417", 23.976),
        ("0.008342", 1 / 0.008342),
    ],
)
def test_a_rounded_frame_time_states_the_rate_it_was_rounded_from(saved, text, rate):
    assert saved(TWO_JOINTS.replace("0.0333333", text)).rate == pytest.approx(rate, rel=1e-9)


def test_rate_can_be_overruled(saved):
    assert saved(TWO_JOINTS, rate=60).rate == 60.0
    assert saved(TWO_JOINTS.replace("Frame Time: 0.0333333\n", ""), rate=60).rate == 60.0
    assert "pass rate=" in refusal(saved, TWO_JOINTS.replace("Frame Time: 0.0333333\n", ""))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda t: t.replace("51 61", "51"),
            ":20: frame 1 has 8 values; the hierarchy declares 9 channels.",
        ),
        (lambda t: t.replace("51 61", "51 x61"), ":20: 'x61' is not a usable number"),
        (lambda t: t.replace("51 61", "51 nan"), ":20: 'nan' is not a usable number"),
        (lambda t: t.replace("51 61", "51 1e40"), ":20: '1e40' is not a usable number"),
        (lambda t: t.replace("51 61", "51 -inf"), ":20: '-inf' is not a usable number"),
        (lambda t: t.replace("OFFSET 0 20 0", "OFFSET 0 nan 0"), ":8: OFFSET has the value 'nan'"),
        (
            lambda t: t.replace("OFFSET 0 20 0", "OFFSET 0 20"),
            ":9: OFFSET has 'CHANNELS' where a number",
        ),
        (
            lambda t: t.replace("        }\n    }\n}\n", "        }\n    }\n"),
            ":2: the brace of 'Hips' is never closed",
        ),
        (lambda t: t.replace("    }\n}\n", "    }\n}\n}\n"), ":16: a closing brace too many"),
        (lambda t: t.replace("ROOT Hips", "JOINT Hips"), ":2: JOINT outside of a ROOT"),
        (lambda t: "HIERARCHY\nMOTION\n" + t.split("MOTION\n")[1], "has no ROOT"),
        (lambda t: t.split("MOTION")[0], ": has no MOTION"),
        (lambda t: t.split("1 91 2")[0], ": holds no frames"),
        (lambda t: t.replace("MOTION", "ROOT Two { OFFSET 0 0 0 }\nMOTION"), ":16: a second ROOT"),
        (
            lambda t: t.replace("Zrotation\n", "Zrotatio\n"),
            ":9: channel 'Zrotatio' of 'Chest' is unknown",
        ),
        (
            lambda t: t.replace("CHANNELS 3", "CHANNELS 999999999"),
            ":9: CHANNELS of 'Chest' says 1e+09",
        ),
        (lambda t: t.replace("CHANNELS 3", "CHANNELS 4"), "'End' of 'Chest' is unknown"),
        (lambda t: t.replace("0.0333333", "0"), ":18: Frame Time '0' must be a number of seconds"),
        (lambda t: t.replace("0.0333333", "nan"), "Frame Time 'nan'"),
        (
            lambda t: t.replace("Frames: 3", "Frames: many"),
            ":17: Frames: 'many' is not a whole number",
        ),
        (lambda t: t.replace("OFFSET 0 20 0", "SIZE 0 20 0"), ":8: 'SIZE' is not expected here"),
        (lambda t: "", ": is empty"),
        (lambda t: " \n ", ": is empty"),
        (lambda t: "\x00" * 500, "is not expected here"),
    ],
)
def test_a_broken_file_is_refused_with_its_line_and_the_value(saved, change, message):
    text = refusal(saved, change(TWO_JOINTS))
    assert text.startswith(message) if message.startswith(":") else message in text


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(ClipError, match="no such file"):
        read_bvh(tmp_path / "none.bvh")
    with pytest.raises(ClipError, match="is a folder"):
        read_bvh(tmp_path)


@pytest.mark.parametrize(
    "options",
    [
        {"up": "w"},
        {"unit": "furlong"},
        {"unit": -1},
        {"rate": 0},
        {"rate": np.nan},
        {"t_pose": "no"},
    ],
)
def test_options_that_cannot_be_meant_are_refused(saved, options):
    with pytest.raises(InvalidValue, match=str(next(iter(options)))):
        saved(TWO_JOINTS, **options)


def _nested(depth: int) -> str:
    opening = "".join(
        f"{'JOINT' if k else 'ROOT'} j{k}\n{{\nOFFSET 0 0.01 0\nCHANNELS 1 Xrotation\n"
        for k in range(depth)
    )
    row = " ".join(["0.1"] * depth)
    return f"HIERARCHY\n{opening}{'}' * depth}\nMOTION\nFrames: 1\nFrame Time: 0.01\n{row}\n"


def test_deep_nesting_is_read_and_written_without_recursion(saved, tmp_path):
    clip = saved(_nested(3000))
    assert len(clip.skeleton) == 3000
    write_bvh(clip, tmp_path / "deep.bvh")
    assert len(read_bvh(tmp_path / "deep.bvh").skeleton) == 3000


def test_absurd_sizes_are_refused_quickly(saved):
    start = time.perf_counter()
    assert "more than 4096 joints" in refusal(saved, _nested(20_000))
    assert "more than 4096 end sites" in refusal(
        saved, TWO_JOINTS.replace("End Site", "End Site { OFFSET 0 0 0 }\n" * 9000 + "End Site")
    )
    assert time.perf_counter() - start < 2.0


@pytest.mark.parametrize(
    "conventions",
    [
        Conventions(),
        Conventions(up="z", unit=1.0, rotation_orders=("XYZ",) * 18),
        Conventions(up="x", unit=0.0254, rotation_orders=("YXZ", *["XZY"] * 9, *["YZX"] * 8)),
        Conventions(unit=0.0254 / 0.45, channels=("ZYXxyz", *["xyzYXZ"] * 17)),
        Conventions(unit=0.001, channels=("yXYZzx", *["ZYX"] * 17)),
    ],
)
def test_written_files_come_back_in_the_same_dialect(tmp_path, conventions):
    clip = person(conventions=conventions)
    write_bvh(clip, tmp_path / "a.bvh")
    back = read_bvh(tmp_path / "a.bvh", up=conventions.up, unit=conventions.unit)
    if conventions.channels:
        assert back.conventions.channels == conventions.channels
    assert back.rate == clip.rate
    here, there = clip.forward_kinematics(), back.forward_kinematics()
    order = [back.skeleton.index(name) for name in clip.skeleton.names]
    assert np.abs(here.positions - there.positions[:, order]).max() < 1e-7
    assert np.degrees(rot.angle_between(here.rotations, there.rotations[:, order]).max()) < 1e-5


def test_writing_twice_gives_the_same_file(tmp_path):
    write_bvh(person(), tmp_path / "a.bvh")
    write_bvh(read_bvh(tmp_path / "a.bvh"), tmp_path / "b.bvh")
    one, two = ((tmp_path / name).read_text().split("MOTION")[0] for name in ("a.bvh", "b.bvh"))
    assert one == two


def test_gimbal_lock_and_whole_turns_survive_writing(tmp_path):
    angles = np.radians(
        [[30, 90, 20], [31, 90, 20], [170, -90, 190], [350, 89.99999, 5], [370, 0, 0]]
    )
    rotations = np.stack([rot.from_euler("ZXY", angles), rot.from_euler("XYZ", angles)], axis=1)
    clip = Clip(
        skeleton=Skeleton(
            names=("a", "b"), parents=(-1, 0), offsets=np.array([[0, 0, 1.0], [0, 0, 1.0]])
        ),
        rotations=rotations,
        root_positions=np.tile([0, 0, 1.0], (5, 1)),
        rate=100,
    )
    write_bvh(clip, tmp_path / "a.bvh")
    back = read_bvh(tmp_path / "a.bvh", up="y", unit=0.01, t_pose="keep")
    assert np.degrees(rot.angle_between(clip.rotations, back.rotations).max()) < 1e-5


def test_joints_with_few_channels_get_three_when_an_edit_needs_them(saved, tmp_path):
    clip = saved(_with_chest("CHANNELS 1 Xrotation", "40", "50"))
    write_bvh(clip, tmp_path / "a.bvh")
    assert read_bvh(tmp_path / "a.bvh").conventions.channels[1] == "X"
    turned = np.array(clip.rotations)
    turned[:, 1] = euler("ZXY", 1, 2, 3)
    edited = Clip(
        skeleton=clip.skeleton,
        rotations=turned,
        root_positions=clip.root_positions,
        rate=clip.rate,
        conventions=clip.conventions,
    )
    write_bvh(edited, tmp_path / "b.bvh")
    back = read_bvh(tmp_path / "b.bvh", up="z", unit=1.0, t_pose="keep")
    assert len(back.conventions.channels[1]) == 3
    assert rot.angle_between(back.rotations, edited.rotations).max() < 1e-7


def test_a_name_that_bvh_cannot_hold_is_refused(tmp_path):
    skeleton = Skeleton(names=("a{",), parents=(-1,), offsets=np.zeros((1, 3)))
    clip = Clip(
        skeleton=skeleton, rotations=rot.identity(2, 1), root_positions=np.zeros((2, 3)), rate=30
    )
    with pytest.raises(InvalidValue, match="rename it"):
        write_bvh(clip, tmp_path / "a.bvh")
    assert not list(tmp_path.iterdir())


@pytest.mark.clips
def test_every_real_clip_comes_back_with_the_same_kinematics(clips, tmp_path):
    for path in sorted(clips.glob("*/*.bvh")):
        clip = read_bvh(path)
        write_bvh(clip, tmp_path / "a.bvh")
        back = read_bvh(tmp_path / "a.bvh")
        assert back.frames == clip.frames and back.rate == clip.rate, path
        assert back.conventions == clip.conventions, path
        here, there = clip.forward_kinematics(), back.forward_kinematics()
        assert np.abs(here.positions - there.positions).max() < 1e-6, path
        assert np.abs(here.ends - there.ends).max() < 1e-6, path
        assert np.degrees(rot.angle_between(here.rotations, there.rotations).max()) < 1e-4, path
