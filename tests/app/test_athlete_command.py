"""The commands athlete and train."""

from __future__ import annotations

import json

import pytest

import understudy as us
from understudy.app import athlete, athlete_told
from understudy.app.main import main


def test_a_run_is_written_measured_and_can_be_read_again(tmp_path, capsys):
    words = ["athlete", "running", "--speed", "3.5", "--seconds", "2", "--out", str(tmp_path)]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["fell_at_s"] is None
    assert found["mean_speed_m_s"] == pytest.approx(3.5, abs=0.4)
    take = us.load_take(tmp_path / "running.take.npz")
    assert take.duration == pytest.approx(2.0)
    clip = us.read(tmp_path / "running.bvh")
    assert clip.root_positions[-1, 0] > 5.0
    saved = json.loads((tmp_path / "running_gait.json").read_text())
    curves = {curve["name"]: curve["correlation"] for curve in saved["run"]["curves"]}
    assert curves["knee"] == pytest.approx(found["knee_curve_correlation"])
    assert "<h2>Curves</h2>" in (tmp_path / "running_gait.html").read_text()


def test_several_run_in_lanes_each_with_files_of_its_own(tmp_path, capsys):
    words = ["athlete", "running", "--runners", "2", "--character", "mixed", "--seconds", "1"]
    assert main([*words, "--out", str(tmp_path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [one["character"] for one in found["runners"]] == ["man", "woman"]
    assert [one["height_m"] for one in found["runners"]] == pytest.approx([1.75, 0.98 * 1.65])
    clips = [us.read(tmp_path / f"running_{letter}.bvh") for letter in "ab"]
    apart = clips[0].root_positions[0] - clips[1].root_positions[0]
    assert apart[:2] == pytest.approx([0.0, 1.22], abs=0.05)
    assert len(us.load_take(tmp_path / "running.take.npz").scene.characters) == 2


def test_a_clip_is_laid_on_the_upper_body(tmp_path, capsys):
    words = ["athlete", "running", "--upper", "sample:gesture", "--seconds", "2"]
    assert main([*words, "--out", str(tmp_path)]) == 0
    assert "upper hands [mm]" in capsys.readouterr().out
    saved = json.loads((tmp_path / "running.json").read_text())
    assert saved["upper"]["clip"] == "gesture" and saved["upper"]["joint_error_deg"] < 3.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--push", "50:0,10"], "--push is '50:0,10'; its time must lie in the run of 2 s."),
        (["--push", "2:0,10"], "its time must lie in the run of 2 s."),
        (["--name", "../evil"], "--name is '../evil'; it must be the stem of a file's name"),
        (["--name", ""], "--name is ''"),
        (["--out", "/proc/x"], "lies among the system's own files"),
    ],
)
def test_what_cannot_be_run_or_written_is_refused_before_the_run(
    words, said, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(us, "simulate", None)
    monkeypatch.setattr(athlete, "_judged", None)
    assert main(["athlete", "running", "--seconds", "2", *words]) == 2
    told = capsys.readouterr().err
    assert said in told and told.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_as_many_run_as_a_track_has_lanes(capsys):
    assert main(["athlete", "running", "--runners", "9"]) == 2
    assert "--runners is 9" in capsys.readouterr().err


def test_another_motion_is_shown_beside_the_run(tmp_path, capsys):
    words = ["athlete", "running", "--seconds", "2", "--out", str(tmp_path)]
    assert main([*words, "--json"]) == 0
    beside = ["--beside", str(tmp_path / "running.bvh"), "--name", "again"]
    assert main([*words, *beside, "--json"]) == 0
    saved = json.loads((tmp_path / "again_gait.json").read_text())
    assert [one["gait"]["stance_by"] for one in saved["beside"]] == ["motion of the soles"]


def test_a_fall_is_said_and_the_take_ends_there(tmp_path, capsys):
    words = ["athlete", "running", "--seconds", "4", "--push", "1:0,900", "--out", str(tmp_path)]
    assert main([*words, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert 1.0 < found["fell_at_s"] < 3.0
    assert found["error"] == found["notes"][0] and found["status"] == 1
    assert found["error"].startswith(f"Fell at {found['fell_at_s']:.2f} s;")
    assert "the push of 900 N s at 1 s" in found["error"]


def test_a_run_too_short_to_measure_shows_no_figures_and_says_so(tmp_path, capsys):
    words = ["athlete", "running", "--speed", "20", "--seconds", "0.5", "--out", str(tmp_path)]
    assert main(words) == 1
    shown = capsys.readouterr().out
    assert "Fell at 0.39 s; likely because of a speed of 20 m/s (measured: 2.5 to 5)." in shown
    assert "Too few steps" in shown and "nan" not in shown
    saved = json.loads((tmp_path / "running.json").read_text())
    empty = {"mean_speed_m_s", "stance_s", "steps_per_s", "legs_apart_least_m", "trunk_lean_deg"}
    assert {saved[name] for name in empty} == {None}
    assert any("no gait page" in note for note in saved["notes"])


def test_a_corner_that_cannot_be_followed_is_said(tmp_path, capsys):
    file = tmp_path / "path.txt"
    file.write_text("0 0\n2 0\n2 20\n")
    words = ["athlete", "running", "--path", str(file), "--seconds", "3", "--out", str(tmp_path)]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    (note,) = found["notes"]
    assert note.startswith(f"Ran up to {found['off_path_most_m']:.1f} m off the path")
    assert "near (2, 0)" in note and "needs 10.0 m" in note


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("mean_speed_m_s", "mean speed [m/s]"),
        ("steps_per_s", "steps [1/s]"),
        ("peak_force_body_weights", "peak force [body weights]"),
        ("upper_hands_mm", "upper hands [mm]"),
        ("character", "character"),
    ],
)
def test_a_name_is_shown_as_words_with_a_unit(name, label):
    assert athlete_told.label(name) == label


def test_what_holds_for_all_runners_is_said_once():
    shared = "6 m/s lies outside."
    found = [
        {"character": "man", "notes": ["Fell at 1.00 s.", shared]},
        {"character": "woman", "notes": [shared]},
    ]
    lines = athlete_told.summary(found, {}).splitlines()
    assert lines.count(shared) == 1 and "a, man: Fell at 1.00 s." in lines


def test_on_a_path_speed_and_distance_are_the_paths(tmp_path, capsys):
    file = tmp_path / "path.txt"
    file.write_text("0 0\n0 50\n")
    words = ["athlete", "running", "--path", str(file), "--seconds", "2", "--out", str(tmp_path)]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["mean_speed_m_s"] == pytest.approx(3.5, rel=0.05)
    assert found["off_path_most_m"] < 0.3 and found["heading_rms_deg"] is None


def test_standing_before_and_after_a_run_are_steps_of_the_speed():
    options = athlete.Options(
        behavior="running", speed="0:3,4:4", seconds=12.0, start="standing", stop=True
    )
    course = athlete.asked_course(options)
    assert course.stands and course.start[2] == 0.0
    assert course.speeds.tolist() == [0.0, 0.0, 3.0, 4.0, 4.0, 0.0]
    assert course.times[:2].tolist() == [0.0, 1.0]
    assert 12.0 - course.times[-1] > 4.0 / 1.8


def test_a_stop_needs_time(capsys):
    assert main(["athlete", "running", "--stop", "--seconds", "3"]) == 2
    assert "--seconds is 3; with --stop it must be over 4.8" in capsys.readouterr().err


def test_a_start_and_a_stop_are_measured(tmp_path, capsys):
    words = ["athlete", "running", "--start", "standing", "--stop", "--speed", "3.5"]
    assert main([*words, "--seconds", "11", "--out", str(tmp_path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["fell_at_s"] is None
    assert 1.0 < found["start_s"] < 5.5 and found["start_m"] < 10.0
    assert found["stop_m"] < 5.0 and found["residual_speed_m_s"] < 0.05


def test_training_writes_gains_with_the_command_that_made_them(tmp_path, capsys):
    words = ["train", "running", "--gains", "pitch", "--evaluations", "4", "--population", "4"]
    assert main([*words, "--seed", "5", "--out", str(tmp_path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    saved = json.loads((tmp_path / "running.json").read_text())
    assert saved["origin"]["seed"] == 5
    assert "--gains pitch" in saved["origin"]["command"] == found["origin"]["command"]
    assert set(saved["gains"]) > {"pitch", "knee_stiffness"}


def test_training_a_stop_tells_how_its_part_was_made(tmp_path, capsys):
    words = ["train", "running", "--part", "stop", "--gains", "step_time", "--population", "2"]
    assert main([*words, "--evaluations", "2", "--out", str(tmp_path)]) == 0
    saved = json.loads((tmp_path / "standing.json").read_text())
    assert "--part stop --evaluations 2" in saved["origin"]["stop"]["command"]
    assert main([*words, "--checkpoint", "x.json"]) == 2
    assert "--part stop goes on with --start" in capsys.readouterr().err
