"""`understudy perform`, end to end: files, table, JSON, mistakes, interrupts."""

from __future__ import annotations

import json

import pytest

import understudy as us
from understudy.app import perform
from understudy.app.main import main
from understudy.edit import read_edit
from understudy.errors import NotFound

WAVE = '[[character]]\nclip = "sample:gesture"\ntrim = [0.8, 1.2]\n'
DRUM = """\
title = "a stroke"
contacts = [["right_hand", "drum"]]
[[character]]
clip = "sample:strike"
trim = [1.1, 1.5]
[[prop]]
kind = "drum"
position = [0.45, -0.15, 0.95]
"""


@pytest.fixture(scope="module")
def stroke(tmp_path_factory):
    """The edit file of one drum stroke."""
    path = tmp_path_factory.mktemp("edits") / "stroke.toml"
    path.write_text(DRUM)
    return path


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_files_table_and_contacts_of_one_edit(stroke, tmp_path, capsys):
    folder = tmp_path / "out"
    assert main(["perform", str(stroke), "--out", str(folder)]) == 0
    kinds = [".html", ".json", ".take.npz", "_sim.bvh", "_sim.glb"]
    assert names(folder) == [f"stroke{kind}" for kind in kinds]
    shown = capsys.readouterr().out
    assert shown.startswith("edit")
    assert "right_hand - drum" in shown
    assert "body weight" in shown
    for name in names(folder):
        assert str(folder / name) in shown
    saved = json.loads((folder / "stroke.json").read_text(encoding="utf-8"))
    assert saved["contacts"][0]["between"] == ["right_hand", "drum"]
    assert "<title>a stroke" in (folder / "stroke.html").read_text(encoding="utf-8")


def test_python_makes_the_same_take(stroke, tmp_path):
    assert main(["perform", str(stroke), "--out", str(tmp_path / "a")]) == 0
    take = us.simulate(read_edit(stroke).performance())
    us.write(take, tmp_path / "b.bvh")
    made = (tmp_path / "a" / "stroke_sim.bvh").read_bytes()
    assert (tmp_path / "b.bvh").read_bytes() == made


def test_a_second_character_has_files_of_its_own(tmp_path, capfd):
    path = tmp_path / "two.toml"
    path.write_text(f"{WAVE}{WAVE}at = [1, 0]\nbody = 'child'\n")
    folder = tmp_path / "out"
    assert main(["perform", str(path), "--out", str(folder), "--json"]) == 0
    (edit,) = json.loads(capfd.readouterr().out)["edits"]
    assert "<title>two" in (folder / "two.html").read_text(encoding="utf-8")  # it has no title
    assert {"sim.bvh", "sim.glb", "b_sim.bvh", "b_sim.glb", "take.npz"} <= set(edit["files"])
    assert edit["name"] == "two"
    assert [one["prefix"] for one in edit["certificate"]["characters"]] == ["", "b/"]
    one, two = (us.read(folder / f"two{which}_sim.bvh") for which in ("", "_b"))
    assert abs(two.root_positions[0, 0] - one.root_positions[0, 0]) > 0.8


def test_a_mistake_in_any_edit_stops_all_before_the_first(stroke, tmp_path, capsys, monkeypatch):
    bad = tmp_path / "bad.toml"
    bad.write_text(f"{WAVE}[[push]]\ntime = 0.1\non = 'chst'\nimpulse = [1, 0, 0]\n")
    monkeypatch.setattr(us, "simulate", lambda *_, **__: pytest.fail("it was simulated"))
    folder = tmp_path / "out"
    assert main(["perform", str(stroke), str(bad), "--out", str(folder)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert f"{bad}:6: No link or prop for Push named 'chst'. Did you mean 'chest'?" in said.err
    assert not folder.exists()


def test_a_prop_that_begins_in_a_body_is_told_with_its_line(tmp_path, capsys, monkeypatch):
    bad = tmp_path / "bad.toml"
    bad.write_text(
        f'contacts = [["chest", "ball"]]\n{WAVE}[[prop]]\nkind = "ball"\nposition = [0, 0, 1.25]\n'
    )
    monkeypatch.setattr(us, "simulate", lambda *_, **__: pytest.fail("it was simulated"))
    assert main(["perform", str(bad), "--out", str(tmp_path / "out")]) == 2
    assert f"{bad}:5: 'ball' begins" in capsys.readouterr().err


def test_a_mistake_as_json(tmp_path, capfd):
    bad = tmp_path / "bad.toml"
    bad.write_text(f"{WAVE}speeed = 2\n")
    assert main(["perform", str(bad), "--json"]) == 2
    answer = json.loads(capfd.readouterr().out)
    assert answer["status"] == 2
    assert answer["error"].startswith(f"{bad}:4: ")


def test_two_edits_of_one_name_have_files_of_two(stroke, tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(
        perform, "performed", lambda job: made.append(job.name) or perform.Row(path="", name="")
    )
    monkeypatch.setattr(perform, "text", lambda rows: "")
    assert main(["perform", str(stroke), str(stroke), "--out", str(tmp_path)]) == 0
    assert made == ["stroke", "stroke_2"]


def test_what_is_read_is_never_written_over(tmp_path, capsys):
    us.write(us.sample("gesture").trimmed(0.8, 1.2), tmp_path / "wave_sim.bvh")
    before = (tmp_path / "wave_sim.bvh").read_bytes()
    path = tmp_path / "wave.toml"
    path.write_text('[[character]]\nclip = "wave_sim.bvh"\n')
    assert main(["perform", str(path), "--out", str(tmp_path)]) == 2
    assert "written over" in capsys.readouterr().err
    assert (tmp_path / "wave_sim.bvh").read_bytes() == before


def test_a_run_that_diverges_keeps_the_take(stroke, tmp_path, monkeypatch, capsys):
    take = us.simulate(read_edit(stroke).performance())

    def blown_up(*_, **__):
        raise us.errors.Diverged(0.25, "chest", take)

    monkeypatch.setattr(us, "simulate", blown_up)
    assert main(["perform", str(stroke), "--out", str(tmp_path)]) == 1
    assert names(tmp_path) == ["stroke_until_0.250s.take.npz"]
    said = capsys.readouterr().err
    assert f"{stroke}: The simulation diverged at 0.250 s in 'chest'" in said
    assert "see it with: understudy render" in said


def test_ctrl_c_tells_what_is_finished(stroke, tmp_path, monkeypatch, capfd):
    rows = iter((perform.Row(path="a", name="a"),))

    def one(job):
        for row in rows:
            return row
        raise KeyboardInterrupt

    monkeypatch.setattr(perform, "performed", one)
    files = [str(stroke)] * 2
    assert main(["perform", *files, "--out", str(tmp_path / "out"), "--json"]) == 130
    answer = json.loads(capfd.readouterr().out)
    assert [row["name"] for row in answer["edits"]] == ["a"]
    assert "interrupted" in answer["error"]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "at least one|missing|required"),
        (["none.toml"], "no such file"),
        (["--out"], "value"),
    ],
)
def test_words_that_make_no_sense(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["perform", *arguments]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert any(word in said for word in words.split("|")), said


def test_an_out_that_is_a_file_is_refused(stroke, tmp_path, capsys):
    (tmp_path / "out").write_text("")
    assert main(["perform", str(stroke), "--out", str(tmp_path / "out")]) == 2
    assert "--out needs a folder" in capsys.readouterr().err


def test_how_far_tasks_were_from_their_goals_is_told(tmp_path, capsys):
    task = '[[character.task]]\nkind = "look_at"\ntarget = [2.0, 1.0, 1.5]\nease = 0.1\n'
    (tmp_path / "look.toml").write_text(WAVE + task)
    assert main(["perform", str(tmp_path / "look.toml"), "--out", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out
    assert "look: tasks" in shown and "face from its target" in shown


def test_the_search_of_a_free_body_is_kept_and_used_again(tmp_path, capsys):
    path, folder = tmp_path / "wave.toml", tmp_path / "out"
    path.write_text('[[character]]\nclip = "sample:gesture"\ntrim = [0.8, 1.0]\npelvis = "free"\n')
    assert main(["perform", str(path), "--out", str(folder), "--json"]) == 0
    search, made = folder / "wave.seed0.search", (folder / "wave_sim.bvh").read_bytes()
    (edit,) = json.loads(capsys.readouterr().out)["edits"]
    assert edit["files"]["seed0.search"] == str(search) and search.is_file()
    assert main(["perform", str(path), "--out", str(folder)]) == 0
    assert f"{search}: this finished search was used again." in capsys.readouterr().err
    assert (folder / "wave_sim.bvh").read_bytes() == made


def test_an_interrupt_says_that_the_search_of_a_free_body_goes_on(tmp_path, monkeypatch, capsys):
    path, folder = tmp_path / "wave.toml", tmp_path / "out"
    path.write_text('[[character]]\nclip = "sample:gesture"\ntrim = [0.8, 1.0]\npelvis = "free"\n')

    def stopped(_, *, checkpoint, **__):
        checkpoint.write_bytes(b"so far")
        raise KeyboardInterrupt

    monkeypatch.setattr("understudy.free_tracking.guided", stopped)
    assert main(["perform", str(path), "--out", str(folder)]) == 130
    assert "the same command goes on with it" in capsys.readouterr().err


def test_a_search_in_vain_leaves_the_other_edits_to_be_performed(tmp_path, monkeypatch, capsys):
    free, led = tmp_path / "free.toml", tmp_path / "led.toml"
    free.write_text('[[character]]\nclip = "sample:gesture"\ntrim = [0.8, 1.0]\npelvis = "free"\n')
    led.write_text(WAVE)

    def fell(performance, **given):
        if "checkpoint" in given:
            raise NotFound("No pass came far.")
        return performance

    monkeypatch.setattr("understudy.free_tracking.guided", fell)
    assert main(["perform", str(free), str(led), "--out", str(tmp_path / "out")]) == 1
    assert f"failed: {free}: No pass came far." in capsys.readouterr().err
    assert (tmp_path / "out" / "led.take.npz").is_file()
