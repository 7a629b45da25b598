"""One function for every kind of file."""

import zipfile
from pathlib import Path

import pytest

from understudy.errors import InvalidValue
from understudy.motion.clip import Clip
from understudy.output import load_take, write
from understudy.take import Take

STARTS = {
    ".bvh": b"HIERARCHY",
    ".glb": b"glTF",
    ".html": b"<!doctype html>",
    ".npz": b"PK",
    ".png": b"\x89PNG",
}


@pytest.mark.parametrize("kind", [".bvh", ".glb", ".html", ".npz"])
def test_extension_decides_what_a_take_becomes(take: Take, tmp_path: Path, kind: str) -> None:
    write(take, tmp_path / f"walk{kind}")
    assert (tmp_path / f"walk{kind}").read_bytes().startswith(STARTS[kind])


def test_several_files_at_once(clip: Clip, tmp_path: Path) -> None:
    paths = [tmp_path / f"walk{kind}" for kind in (".bvh", ".glb", ".csv", ".npz", ".HTML")]
    write(clip, *paths)
    assert all(path.stat().st_size > 100 for path in paths)


def test_take_written_as_npz_is_the_whole_take(take: Take, tmp_path: Path) -> None:
    write(take, tmp_path / "walk.npz")
    assert load_take(tmp_path / "walk.npz").frames == take.frames
    assert zipfile.is_zipfile(tmp_path / "walk.npz")


def test_unknown_extension_writes_nothing_at_all(clip: Clip, tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match=r"cannot write \.fbx; known are \.bvh"):
        write(clip, tmp_path / "walk.bvh", tmp_path / "walk.fbx")
    with pytest.raises(InvalidValue, match="without an extension"):
        write(clip, tmp_path / "walk")
    assert not list(tmp_path.iterdir())
