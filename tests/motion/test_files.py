"""Files that are written whole or not at all, and files that are read only if they are files."""

from __future__ import annotations

import os
import sys

import pytest

import understudy as us
from understudy.character.mapping import read_mapping
from understudy.errors import ClipError, UnderstudyError
from understudy.motion.files import same_file, writable, written
from understudy.motion.source import regular_bytes

posix = pytest.mark.skipif(os.name != "posix", reason="needs links, pipes and devices")


@posix
def test_a_link_stays_and_what_it_leads_to_is_written(tmp_path):
    target, link = tmp_path / "inside" / "real.txt", tmp_path / "link.txt"
    target.parent.mkdir()
    target.write_text("old")
    link.symlink_to(target)
    with written(link) as temporary:
        temporary.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert [path.name for path in target.parent.iterdir()] == ["real.txt"]


@posix
def test_what_is_no_file_is_not_replaced(tmp_path):
    pipe = tmp_path / "pipe.bvh"
    os.mkfifo(pipe)
    with pytest.raises(UnderstudyError, match="a device or a pipe"), written(pipe):
        pytest.fail("the block must not start")
    assert pipe.is_fifo()
    with pytest.raises(UnderstudyError, match="is a folder"):
        writable(tmp_path)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Linux has these folders")
@pytest.mark.parametrize("path", ["/dev/new/x.bvh", "/proc/x.bvh", "/sys/new/x.bvh"])
def test_nothing_is_made_among_the_systems_files(path):
    with pytest.raises(UnderstudyError, match="the system's own"), written(path):
        pytest.fail("the block must not start")


@posix
def test_a_loop_of_links_is_one_line(tmp_path):
    one, other = tmp_path / "one.txt", tmp_path / "other.txt"
    one.symlink_to(other)
    other.symlink_to(one)
    with pytest.raises(UnderstudyError, match=r"one\.txt: cannot be written"), written(one):
        pytest.fail("the block must not start")


@posix
def test_files_are_the_same_through_links_and_before_they_exist(tmp_path):
    file, link = tmp_path / "a.bvh", tmp_path / "b.bvh"
    file.touch()
    link.symlink_to(file)
    assert same_file(file, link)
    assert same_file(tmp_path / "new.bvh", tmp_path / "x" / ".." / "new.bvh")
    assert not same_file(file, tmp_path / "new.bvh")


@posix
def test_pipes_and_devices_are_refused_at_once(tmp_path):
    pipe = tmp_path / "pipe.bvh"
    os.mkfifo(pipe)
    for endless in (pipe, "/dev/zero"):
        with pytest.raises(ClipError, match="a device or a pipe"):
            us.read(endless)
        with pytest.raises(ClipError, match="one mapping file"):
            read_mapping(endless)
        with pytest.raises(UnderstudyError, match="a device or a pipe"):
            us.load_take(endless)


def test_no_more_is_read_than_allowed(tmp_path):
    file = tmp_path / "long.txt"
    file.write_bytes(b"x" * 11)
    assert len(regular_bytes(file, what="file", most=11)) == 11
    with pytest.raises(ClipError, match="split the file"):
        regular_bytes(file, what="file", most=10)
