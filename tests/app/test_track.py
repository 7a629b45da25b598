"""`understudy track`, end to end: files, table, JSON, failures, interrupts."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time

import pytest

import understudy as us
from understudy.app import performing, track
from understudy.app.main import main

FILES = ["wave.html", "wave.json", "wave.take.npz", "wave_sim.bvh", "wave_sim.glb"]


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_every_file_is_made_and_nothing_else(out):
    assert names(out) == FILES


def test_the_simulated_bvh_is_on_the_clips_own_skeleton(out, short):
    simulated, captured = us.read(out / "wave_sim.bvh"), us.read(short)
    assert simulated.skeleton.names == captured.skeleton.names
    assert simulated.rate == pytest.approx(captured.rate, rel=1e-4)
    assert simulated.frames == captured.frames


def test_python_writes_the_files_of_the_command_line(out, short, tmp_path):
    clip = us.read(short)
    take = us.track(clip, us.Character.from_clip(clip))
    us.write(take, tmp_path / "a.bvh", tmp_path / "a.glb")
    us.write(us.load_take(out / "wave.take.npz"), tmp_path / "b.bvh")
    made = (out / "wave_sim.bvh").read_bytes()
    assert (tmp_path / "a.bvh").read_bytes() == made
    assert (tmp_path / "b.bvh").read_bytes() == made
    assert (tmp_path / "a.glb").read_bytes() == (out / "wave_sim.glb").read_bytes()


def test_the_saved_take_scores_as_the_certificate_says(out):
    saved = json.loads((out / "wave.json").read_text(encoding="utf-8"))
    again = us.score(us.load_take(out / "wave.take.npz"))
    assert again.joint_error_deg == pytest.approx(saved["characters"][0]["joint_error_deg"])


def test_the_table_says_what_help_means(short, tmp_path, capsys):
    assert main(["track", str(short), "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("clip")
    assert "body weight" in shown
    assert str(tmp_path / "wave_sim.bvh") in shown


def test_json_is_one_object_with_the_certificate(short, tmp_path, capfd):
    assert main(["track", str(short), "--out", str(tmp_path), "--json"]) == 0
    answer = json.loads(capfd.readouterr().out)
    (clip,) = answer["clips"]
    assert answer["failed"] == answer["status"] == 0
    assert clip["error"] is None
    assert sorted(clip["files"]) == ["html", "json", "sim.bvh", "sim.glb", "take.npz"]
    assert clip["certificate"]["kind"] == "understudy certificate"


def test_one_bad_clip_does_not_stop_the_others(short, tmp_path, capsys):
    bad = tmp_path / "bad.bvh"
    bad.write_text("HIERARCHY\nROOT hips\n{\n")
    folder = tmp_path / "out"
    assert main(["track", str(bad), str(short), "--out", str(folder), "--jobs", "1"]) == 1
    captured = capsys.readouterr()
    assert "bad.bvh" in captured.err
    assert "[2/2] wave: " in captured.err
    assert "1 of 2 clips failed." in captured.out
    assert names(folder) == FILES


def test_processes_make_the_same_takes_as_one_does(short, tmp_path, capfd):
    answers = []
    for jobs in ("1", "2"):
        folder = tmp_path / jobs
        assert (
            main(["track", *[str(short)] * 2, "--out", str(folder), "--jobs", jobs, "--json"]) == 0
        )
        answers.append(json.loads(capfd.readouterr().out)["clips"])
    for one, two in zip(*answers, strict=True):
        assert one["name"] == two["name"]
        assert one["certificate"]["characters"] == two["certificate"]["characters"]


def test_bad_input_alone_is_status_2_and_makes_no_folder(tmp_path, capsys):
    folder = tmp_path / "out"
    assert main(["track", str(tmp_path / "none.bvh"), "--out", str(folder)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert "none.bvh" in captured.err
    assert not folder.exists()


def test_a_run_that_fails_late_leaves_older_files_as_they_were(
    short, tmp_path, monkeypatch, capsys
):
    for name in FILES:
        (tmp_path / name).write_text("older")

    def full(*_):
        raise us.UnderstudyError("the disk is full")

    monkeypatch.setattr(us, "write_report", full)
    assert main(["track", str(short), "--out", str(tmp_path)]) == 2
    assert "the disk is full" in capsys.readouterr().err
    assert names(tmp_path) == FILES
    assert all((tmp_path / name).read_text() == "older" for name in FILES)


def test_a_divergence_keeps_the_take_and_is_status_1(short, tmp_path, monkeypatch, capsys):
    from understudy.errors import Diverged

    clip = us.read(short)
    take = us.track(clip, us.Character.from_clip(clip))

    def blown(*_, **__):
        raise Diverged(0.6, "left_hand", take)

    monkeypatch.setattr(us, "track", blown)
    assert main(["track", str(short), "--out", str(tmp_path)]) == 1
    assert "left_hand" in capsys.readouterr().err
    (kept,) = names(tmp_path)
    assert kept == "wave_until_0.600s.take.npz"


def test_an_interrupt_keeps_what_is_finished(short, tmp_path, monkeypatch, capsys):
    real, seen = performing.performed, []

    def second_time_interrupted(job):
        seen.append(job)
        if len(seen) == 2:
            raise KeyboardInterrupt
        return real(job)

    monkeypatch.setattr(performing, "performed", second_time_interrupted)
    words = ["track", str(short), str(short), "--out", str(tmp_path), "--jobs", "1"]
    assert main(words) == 130
    assert names(tmp_path) == FILES
    assert capsys.readouterr().err.endswith("interrupted; finished files are kept.\n")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process")
def test_an_interrupt_ends_the_workers_and_leaves_no_scraps(short, tmp_path):
    words = ["track", *[str(short)] * 60, "--out", str(tmp_path), "--jobs", "2"]
    process = subprocess.Popen(
        [sys.executable, "-m", "understudy.app.main", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    assert process.stderr.readline().startswith("[1/60]")
    process.send_signal(signal.SIGINT)
    started = time.monotonic()
    out, err = process.communicate(timeout=60)
    assert time.monotonic() - started < 30
    assert process.returncode == 130
    assert out == ""
    assert err.splitlines()[-1] == "understudy track: interrupted; finished files are kept."
    assert "Traceback" not in err
    made = names(tmp_path)
    assert "wave.json" in made or any(name.endswith(".json") for name in made)
    assert not [name for name in made if name.startswith(".")]


def test_a_folder_stands_for_the_motion_files_in_it(short, tmp_path, capsys):
    from understudy.app.reading import expanded

    folder = tmp_path / "clips"
    folder.mkdir()
    for name in ("b.bvh", "a.BVH"):
        (folder / name).write_bytes(short.read_bytes())
    us.write(us.read(short), folder / "c.npz", folder / "positions.csv")
    (folder / "d.take.npz").write_bytes(b"")
    (folder / "notes.txt").write_text("mine")
    (folder / "e.csv").write_text("time,segment,w,x,y,z\n")
    found = expanded(["sample:walk", str(folder)])
    assert [word.rpartition("/")[2] for word in found] == [
        "sample:walk",
        "a.BVH",
        "b.bvh",
        "c.npz",
        "e.csv",
    ]
    empty = tmp_path / "empty"
    empty.mkdir()
    assert main(["track", str(empty)]) == 2
    assert "holds no motion file" in capsys.readouterr().err


def test_several_clips_say_how_many_notes_there_are(short, tmp_path, capsys):
    folder = tmp_path / "clips"
    folder.mkdir()
    for name in ("a.bvh", "b.bvh"):
        (folder / name).write_bytes(short.read_bytes())
    words = ["track", str(folder), "--jobs", "1", "--out", str(tmp_path / "out"), "--json"]
    assert main(words) == 0
    answer = json.loads(capsys.readouterr().out)
    assert all(clip["wall_s"] > 0 for clip in answer["clips"])
    rows = [
        performing.Row(
            clip=c["clip"], name=c["name"], certificate=c["certificate"], notes=tuple(c["notes"])
        )
        for c in answer["clips"]
    ]
    count = sum(len(row.notes) for row in rows)
    assert count > 0
    shown = track.text(rows)
    assert f"{count} notes on what was read and changed: in each NAME.html." in shown
    assert shown.index("help: outside force") < shown.index("notes on what was read")


def test_the_table_says_that_a_body_fell(out):
    saved = json.loads((out / "wave.json").read_text(encoding="utf-8"))
    saved["characters"][0] |= {"fell_s": 0.2, "fully_physical": True}
    row = performing.Row(clip="wave.bvh", name="wave", certificate=saved)
    assert track.figures(row)[-1] == "0, fell"


def test_a_free_body_gets_columns_of_its_own(out):
    saved = json.loads((out / "wave.json").read_text(encoding="utf-8"))
    held = performing.Row(clip="wave.bvh", name="wave", certificate=saved)
    assert "s free" not in track.text([held])
    saved["characters"][0]["pelvis"] = "free"
    saved["characters"][0]["following"] |= {"free_s": 0.42, "com_mm": 7.25}
    loose = performing.Row(clip="wave.bvh", name="wave", certificate=saved)
    shown = track.text([loose])
    head, _, line = shown.splitlines()[:3]
    assert head.split("  ")[0] == "clip" and "s free" in head and "hands mm" not in head
    assert " 0.42 " in line and " 7." in line
    assert "s free 0.42" in track.summary(loose)
    saved["characters"][0]["following"] |= {"whole": False, "clip_s": 9.5}
    short = track.text([performing.Row(clip="wave.bvh", name="wave", certificate=saved)])
    assert " of 9.50 " in short and track.CUT_SHORT in short


def test_a_number_stays_on_the_line_of_its_percent_sign():
    for width in range(80, 100):
        lines = track.folded("x" * width + " 12 % of the weight")
        assert not any(line.startswith("%") for line in lines)
        assert " ".join(lines).endswith(" 12 % of the weight")


def test_clips_of_one_name_get_files_of_their_own():
    assert track.unique(["walk", "run", "walk", "walk_2", "walk"]) == [
        "walk",
        "run",
        "walk_3",
        "walk_2",
        "walk_4",
    ]


def test_another_body_performs_on_its_own_skeleton(short, tmp_path, capsys):
    words = ["track", str(short), "--character", "child", "--plan", "upper", "--stills"]
    assert main([*words, "--out", str(tmp_path)]) == 0
    assert names(tmp_path) == sorted([*FILES, "wave.png"])
    assert "left_wrist" in us.read(tmp_path / "wave_sim.bvh").skeleton.names


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["gestur"], "Did you mean sample:gesture?"),
        (["sample:gestur"], "Did you mean 'gesture'?"),
        (["gesture", "--character", "chld"], "Did you mean 'child'?"),
        (["gesture", "--character", "child", "--sex", "female"], "--sex"),
        (["gesture", "--rate", "30"], "--rate"),
        (["gesture", "--jobs", "0"], "at least 1"),
        (["gesture", "--mass", "nan"], "mass is nan kg"),
        (["gesture", "--mapping", "none.toml"], "none.toml"),
        (["gesture", "--stiffness", "-1"], "stiffness"),
        ([], "at least one clip"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(words, expected, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["track", *words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert expected in captured.err
    assert names(tmp_path) == []


def test_out_must_be_a_folder(short, tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("mine")
    for folder in (file, file / "inside"):
        assert main(["track", str(short), "--out", str(folder)]) == 2
        assert "needs a folder" in capsys.readouterr().err
    assert file.read_text() == "mine"


@pytest.mark.parametrize(("free", "says"), [(True, "this one did"), (False, "will need help")])
def test_after_a_free_performance_no_help_is_foreseen(free, says):
    row = performing.Row(
        clip="leap.bvh",
        name="leap",
        certificate={
            "feasibility": {"statement": "31 %: will need help from above; the peak is at 1 s."},
            "fully_physical": free,
            "characters": [{"following": {"free": free}}],
        },
    )
    said = track.expected(row)
    assert said.startswith("Foreseen from the clip: missing 31 %: ") and says in said
    assert said.endswith("the peak is at 1 s.")
    assert ("help" in said) is not free
