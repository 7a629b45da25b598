"""What a command would write over: its inputs, another clip's files, what is no file."""

from __future__ import annotations

import json
import os
import shutil

import pytest

import understudy as us
from understudy.app import performing
from understudy.app.main import main
from understudy.errors import Diverged


def refused(capsys, *words) -> str:
    assert main([str(word) for word in words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err


@pytest.fixture
def pair(short, tmp_path):
    """x.bvh, and a file where x's simulated motion would go."""
    for name in ("x.bvh", "x_sim.bvh"):
        shutil.copy(short, tmp_path / name)
    return tmp_path / "x.bvh", tmp_path / "x_sim.bvh"


def test_track_does_not_write_over_a_clip_it_reads(pair, capsys):
    first, second = pair
    before = second.read_bytes()
    said = refused(capsys, "track", first, second, "--out", first.parent)
    assert f"{second}: would be written over; choose another --out." in said
    assert second.read_bytes() == before
    assert sorted(path.name for path in first.parent.iterdir()) == ["x.bvh", "x_sim.bvh"]


@pytest.mark.skipif(os.name != "posix", reason="needs links")
def test_an_input_is_known_through_a_link(pair, capsys):
    first, second = pair
    link = first.parent / "linked" / "x_sim.bvh"
    link.parent.mkdir()
    link.symlink_to(second)
    assert "written over" in refused(capsys, "track", first, second, "--out", link.parent)


def test_an_input_that_comes_up_while_a_clip_is_performed_stays(short, tmp_path, monkeypatch):
    real = us.track

    def meanwhile(*given, **options):
        (tmp_path / "wave.json").write_text("mine")
        return real(*given, **options)

    monkeypatch.setattr(us, "track", meanwhile)
    (job,) = _jobs(short, tmp_path, keep=(tmp_path / "wave.json",))
    row = performing.attempted(job)
    assert "would be written over" in (row.error or "")
    assert [path.name for path in tmp_path.iterdir()] == ["wave.json"]
    assert (tmp_path / "wave.json").read_text() == "mine"


def _jobs(clip, folder, keep):
    from dataclasses import replace

    from understudy.app.track import Options, jobs_for

    jobs = jobs_for(Options(clips=(str(clip),), out=folder))
    return [replace(job, keep=keep) for job in jobs]


def test_names_that_differ_in_letter_case_get_files_of_their_own():
    from understudy.app.track import unique

    assert unique(["Walk", "walk", "WALK"]) == ["Walk", "walk_2", "WALK_3"]


def test_a_folder_where_a_file_would_go_is_found_before_the_work(short, tmp_path, capsys):
    (tmp_path / "wave_sim.glb").mkdir()
    said = refused(capsys, "track", short, "--out", tmp_path)
    assert "wave_sim.glb: is a folder" in said


@pytest.mark.parametrize("command", ["track", "tune"])
def test_a_folder_that_cannot_be_written_is_found_before_the_work(
    command, short, tmp_path, monkeypatch, capsys
):
    def no_space(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(us, "read", lambda *_, **__: pytest.fail("the work must not begin"))
    monkeypatch.setattr(performing.tempfile, "TemporaryFile", no_space)
    folder = tmp_path / "new"
    said = refused(capsys, command, short, "--out", folder)
    assert f"{folder}: cannot be written: Permission denied." in said
    assert not folder.exists()


def test_a_full_disk_names_the_file_that_was_asked_for(short, tmp_path, monkeypatch, capsys):
    def full(take, path):
        from understudy.motion.files import written

        with written(path):
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(us, "write_report", full)
    said = refused(capsys, "track", short, "--out", tmp_path)
    assert f"{tmp_path}/wave.html: cannot be written: No space left on device." in said


def test_convert_does_not_replace_its_source(short, tmp_path, capsys):
    source = tmp_path / "a.bvh"
    shutil.copy(short, source)
    before = source.read_bytes()
    for target in (source, tmp_path / "." / "a.bvh", tmp_path / "x" / ".." / "a.bvh"):
        assert "is the file to be read" in refused(
            capsys, "convert", source, target, "--speed", "2"
        )
    if os.name == "posix":
        (tmp_path / "link.bvh").symlink_to(source)
        assert "is the file to be read" in refused(capsys, "convert", source, tmp_path / "link.bvh")
    assert source.read_bytes() == before


@pytest.mark.parametrize("command", ["samples", "fetch"])
def test_a_folder_without_names_is_refused(command, tmp_path, capsys):
    assert "--out needs names" in refused(capsys, command, "--out", tmp_path / "new")


def test_a_partial_take_is_told_of_in_text_and_json(short, tmp_path, monkeypatch, capfd):
    clip = us.read(short)
    take = us.track(clip, us.Character.from_clip(clip))

    def blown(*_, **__):
        raise Diverged(0.0034, "left_hand", take)

    monkeypatch.setattr(us, "track", blown)
    kept = tmp_path / "wave_until_0.003s.take.npz"
    assert main(["track", str(short), "--out", str(tmp_path)]) == 1
    said = capfd.readouterr().err
    assert "diverged at 0.003 s" in said
    assert said.endswith(f"The take up to then: {kept}; see it with: understudy render {kept}\n")
    assert main(["track", str(short), "--out", str(tmp_path), "--json"]) == 1
    assert json.loads(capfd.readouterr().out)["clips"][0]["files"] == {"take.npz": str(kept)}
    assert us.load_take(kept).frames == take.frames
