"""npz: an exact round trip, and no trust in a file that comes from elsewhere."""

from __future__ import annotations

import io
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from texts import person

from understudy.errors import ClipError
from understudy.motion.clip import Conventions
from understudy.motion.npz import arrays_of, read_npz, write_npz
from understudy.motion.skeleton import Skeleton


def test_a_clip_comes_back_bit_for_bit(tmp_path):
    clip = person(
        name="walk \u00e4",
        synthetic=True,
        notes=("one", "two: \u00e9"),
        conventions=Conventions(up="z", unit=0.0254, channels=("xyzZXY", *["XYZ"] * 17)),
    )
    write_npz(clip, tmp_path / "a.npz")
    back = read_npz(tmp_path / "a.npz")
    assert back.skeleton == clip.skeleton
    np.testing.assert_array_equal(back.rotations, clip.rotations)
    np.testing.assert_array_equal(back.root_positions, clip.root_positions)
    for name in ("name", "rate", "synthetic", "notes", "conventions"):
        assert getattr(back, name) == getattr(clip, name)


def test_a_clip_without_ends_and_notes_comes_back(tmp_path):
    skeleton = Skeleton(names=("only",), parents=(-1,), offsets=np.zeros((1, 3)))
    clip = replace(person(2), skeleton=skeleton, rotations=person(2).rotations[:, :1])
    write_npz(clip, tmp_path / "a.npz")
    back = read_npz(tmp_path / "a.npz")
    assert back.skeleton == skeleton and back.notes == ()


def test_the_same_clip_gives_the_same_bytes(tmp_path):
    for name in ("a.npz", "b.npz"):
        write_npz(person(), tmp_path / name)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def packed(tmp_path: Path, members: dict[str, bytes], packing=zipfile.ZIP_STORED) -> Path:
    path = tmp_path / "bad.npz"
    with zipfile.ZipFile(path, "w", packing) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return path


def member(header: str, content: bytes = b"") -> bytes:
    text = header.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + content


def array_bytes(array: np.ndarray, allow_pickle: bool = False) -> bytes:
    out = io.BytesIO()
    np.lib.format.write_array(out, array, allow_pickle=allow_pickle)
    return out.getvalue()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (array_bytes(np.array([{"a": 1}], object), allow_pickle=True), "Python objects"),
        (
            member("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 9), }"),
            "does not fit its 0 bytes",
        ),
        (
            member("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }", b"1234"),
            "does not fit",
        ),
        (member("{'descr': '<f99', 'fortran_order': False, 'shape': (), }", b"0" * 99), "type"),
        (member("__import__('os').system('false')"), "type that is not read"),
        (member("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (), }"), "not read"),
        (
            member("{'descr': '<U1', 'fortran_order': False, 'shape': (), }", b"\xff" * 4),
            "no Unicode",
        ),
        (b"", "no NumPy array"),
        (b"\x93NUMPY\x01\x00", "no NumPy array"),
    ],
)
def test_a_hostile_member_is_refused(tmp_path, content, message):
    path = packed(tmp_path, {"rotations": content})
    with pytest.raises(ClipError, match=message) as caught:
        arrays_of(path.read_bytes(), path)
    assert "\n" not in str(caught.value)


def test_a_zip_bomb_is_refused_before_it_unpacks(tmp_path):
    header = "{'descr': '<f8', 'fortran_order': False, 'shape': (12500000,), }"
    path = packed(tmp_path, {"poses": member(header, bytes(100_000_000))}, zipfile.ZIP_DEFLATED)
    assert path.stat().st_size < 200_000
    with pytest.raises(ClipError, match="more than 100 times its size"):
        arrays_of(path.read_bytes(), path)


def test_a_damaged_archive_is_refused(tmp_path):
    write_npz(person(), tmp_path / "a.npz")
    data = bytearray((tmp_path / "a.npz").read_bytes())
    for change in (data[: len(data) // 2], data[100:], b"PK" + bytes(200)):
        (tmp_path / "b.npz").write_bytes(bytes(change))
        with pytest.raises(ClipError, match=r"damaged|no clip"):
            read_npz(tmp_path / "b.npz")
    data[5000] ^= 1  # the checksum of the rotations no longer fits
    (tmp_path / "b.npz").write_bytes(bytes(data))
    with pytest.raises(ClipError, match="damaged"):
        read_npz(tmp_path / "b.npz")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("rotations", None, "lacks the array 'rotations'"),
        ("rotations", np.full((40, 18, 4), np.nan), "no numbers"),
        ("rotations", np.zeros((40, 18, 4)), "zero quaternion"),
        ("rotations", np.ones((40, 17, 4)), "shape"),
        ("offsets", np.full((18, 3), 1e300), "above 1e9"),
        ("parents", np.arange(18), "root must come first"),
        ("names", np.array(["a"] * 18), "unique"),
        ("rate", np.array(-1.0), "rate"),
        ("up", np.array("w"), "up axis"),
        ("format", np.array("else"), "no clip of this package"),
    ],
)
def test_a_clip_that_does_not_fit_is_refused(tmp_path, name, value, message):
    write_npz(person(), tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as archive:
        arrays = dict(archive)
    arrays[name] = value
    np.savez(tmp_path / "b.npz", **{k: v for k, v in arrays.items() if v is not None})
    with pytest.raises(ClipError, match=message):
        read_npz(tmp_path / "b.npz")
