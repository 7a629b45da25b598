"""One function reads every format, by extension or by content."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from texts import TWO_JOINTS, person

from understudy.errors import ClipError, InvalidValue
from understudy.motion.bvh import write_bvh
from understudy.motion.npz import write_npz
from understudy.motion.read import read


@pytest.mark.parametrize("write", [write_bvh, write_npz])
@pytest.mark.parametrize("other", ["a.txt", "a", "a.motion"])
def test_content_decides_where_the_extension_does_not(tmp_path, write, other):
    known = tmp_path / ("a.bvh" if write is write_bvh else "a.npz")
    write(person(), known)
    shutil.copy(known, tmp_path / other)
    one, two = read(known), read(tmp_path / other)
    np.testing.assert_array_equal(one.rotations, two.rotations)


def test_every_format_is_read_by_its_extension(tmp_path):
    from test_acclaim import AMC, ASF
    from test_orientations import COMMA, rows_of

    (tmp_path / "07.asf").write_text(ASF)
    (tmp_path / "07_01.amc").write_text(AMC)
    assert read(tmp_path / "07_01.amc").skeleton.names == ("root", "upper", "lower")
    (tmp_path / "hands.txt").write_text(AMC)
    assert read(tmp_path / "hands.txt", asf=tmp_path / "07.asf").frames == 2
    table = "\n".join(",".join(map(str, row)) for row in [COMMA, *rows_of(person(5))])
    for name in ("suit.csv", "suit.dat"):
        (tmp_path / name).write_text(table)
        assert read(tmp_path / name).frames == 5
    np.savez(tmp_path / "a.npz", poses=np.zeros((4, 66)), trans=np.zeros((4, 3)), fps=30)
    assert read(tmp_path / "a.npz").skeleton.names[1] == "left_hip"
    write_npz(person(), tmp_path / "b.npz")
    assert read(tmp_path / "b.npz", rate=60).rate == 60


@pytest.mark.parametrize("content", [b"; FBX 7.4", b"glTF\x02", b"\x00\x01", b"hello"])
def test_other_formats_are_refused_with_what_is_read(tmp_path, content):
    (tmp_path / "walk.fbx").write_bytes(content)
    with pytest.raises(ClipError, match=r"walk\.fbx: is of no format that is read; .*BVH"):
        read(tmp_path / "walk.fbx")


def test_a_missing_file_is_refused(tmp_path):
    for name in ("none.bvh", "none.amc", "none.npz", "none.csv", "none"):
        with pytest.raises(ClipError, match="no such file"):
            read(tmp_path / name)


def test_options_are_checked_for_every_format(tmp_path):
    write_npz(person(), tmp_path / "a.npz")
    with pytest.raises(InvalidValue, match="t_pose"):
        read(tmp_path / "a.npz", t_pose="maybe")
    (tmp_path / "a.bvh").write_text(TWO_JOINTS)
    with pytest.raises(InvalidValue, match="unit"):
        read(tmp_path / "a.bvh", unit="parsec")


@pytest.mark.clips
def test_every_real_clip_is_read(clips):
    for path in sorted([*clips.glob("*/*.bvh"), *clips.glob("*/*.amc")]):
        clip = read(path)
        assert clip.frames >= 2 and clip.notes, path
