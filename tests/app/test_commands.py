"""The other commands: info, convert, score, render, tune, samples, fetch."""

from __future__ import annotations

import json

import numpy as np
import pytest

import understudy as us
from understudy.app.main import main


def answer(capfd, *words):
    assert main([*words, "--json"]) == 0
    return json.loads(capfd.readouterr().out)


def test_info_describes_the_clip_and_its_body(short, capfd):
    found = answer(capfd, "info", str(short))
    assert found["rate_hz"] == pytest.approx(60.0, rel=1e-4)
    assert found["duration_s"] == pytest.approx(0.6, abs=1e-3)
    assert found["skeleton"][0]["parent"] is None
    assert found["preparation"] == []  # both feet stand where they should
    body = found["character"]
    assert body["roles"]["left_knee"] == "left_knee"
    assert body["height_m"] == pytest.approx(1.75, abs=0.05)
    assert sum(link["mass_kg"] for link in body["links"]) == pytest.approx(body["mass_kg"])


def test_info_says_what_would_be_changed(capfd):
    found = answer(capfd, "info", "sample:walk")
    assert any("feet" in note for note in found["preparation"])


def test_info_says_where_a_clip_starts_faces_and_travels(tmp_path, capfd):
    walk = us.sample("walk").placed(at=(0.0, 0.0))
    us.write(walk, tmp_path / "a.npz")
    us.write(walk.placed(at=(2.0, -1.0), heading=np.radians(100.0)), tmp_path / "b.npz")
    one, two = (answer(capfd, "info", str(tmp_path / name)) for name in ("a.npz", "b.npz"))
    assert (one["start_m"], two["start_m"]) == ([0.0, 0.0], [2.0, -1.0])
    assert one["facing_deg"] == pytest.approx(0.0, abs=10.0)  # samples face +x
    assert one["travel_deg"] == pytest.approx(0.0, abs=5.0)
    assert one["travel_m"] > 2.0
    assert two["travel_m"] == pytest.approx(one["travel_m"], abs=1e-6)
    for key in ("facing_deg", "travel_deg"):
        assert two[key] == pytest.approx(one[key] + 100.0, abs=1e-3)


def test_info_says_when_a_clip_stays(capsys):
    assert main(["info", "sample:clapping"]) == 0
    assert ", ends where it starts (from +x toward +y)" in capsys.readouterr().out


def test_info_is_readable(short, capsys):
    assert main(["info", str(short)]) == 0
    shown = capsys.readouterr().out
    assert "roles:" in shown
    assert "skeleton:" in shown


@pytest.mark.parametrize("kind", ["bvh", "npz", "glb", "csv"])
def test_convert_writes_every_format(kind, short, tmp_path, capfd):
    target = tmp_path / f"wave.{kind}"
    found = answer(capfd, "convert", str(short), str(target))
    assert found["written"] == str(target)
    assert target.stat().st_size > 1000


def test_convert_edits_in_the_order_it_says(short, tmp_path, capfd):
    target = tmp_path / "half.bvh"
    words = ["--trim", "0.1:0.5", "--mirror", "--speed", "2", "--resample", "30"]
    found = answer(capfd, "convert", str(short), str(target), *words)
    assert found["duration_s"] == pytest.approx(0.2, abs=1e-3)
    assert found["rate_hz"] == 30.0
    expected = us.read(short).trimmed(0.1, 0.5).mirrored().retimed(2.0).resampled(30.0)
    assert us.read(target).frames == expected.frames


def test_mirroring_twice_gives_the_clip_back(short, tmp_path):
    once, twice = tmp_path / "once.npz", tmp_path / "twice.npz"
    assert main(["convert", str(short), str(once), "--mirror"]) == 0
    assert main(["convert", str(once), str(twice), "--mirror"]) == 0
    first, last = us.read(short), us.read(twice)
    np.testing.assert_allclose(
        first.forward_kinematics().positions, last.forward_kinematics().positions, atol=1e-6
    )


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--trim", "0.2"], "START:END"),
        (["--trim", "a:b"], "START:END"),
        (["--trim", "2:3"], "it lasts"),
        (["--speed", "0"], "speed is 0"),
        (["--resample", "nan"], "rate is nan"),
    ],
)
def test_convert_refuses_in_one_line_and_writes_nothing(words, expected, short, tmp_path, capsys):
    target = tmp_path / "x.bvh"
    assert main(["convert", str(short), str(target), *words]) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert expected in captured.err
    assert not target.exists()


def test_convert_names_the_formats_it_writes(short, tmp_path, capsys):
    assert main(["convert", str(short), str(tmp_path / "x.fbx")]) == 2
    assert ".bvh" in capsys.readouterr().err


def test_score_prints_the_certificate_of_a_take(out, capfd):
    found = answer(capfd, "score", str(out / "wave.take.npz"))
    saved = json.loads((out / "wave.json").read_text(encoding="utf-8"))
    assert found["characters"] == saved["characters"]


def test_render_makes_a_sheet_and_a_player(out, tmp_path, capfd):
    words = ["render", str(out / "wave.take.npz"), "--out", str(tmp_path)]
    files = answer(capfd, *words, "--renderer", "software")["files"]
    assert sorted(files) == ["player.html", "png"]
    assert (tmp_path / "wave.png").read_bytes().startswith(b"\x89PNG")
    assert "<html" in (tmp_path / "wave_player.html").read_text(encoding="utf-8")


def test_render_refuses_a_folder_it_cannot_write_before_it_reads(tmp_path, capsys, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(us, "load_take", None)
    assert main(["render", "any.take.npz", "--out", str(tmp_path / "file" / "in")]) == 2
    assert "is a file; --out needs a folder." in capsys.readouterr().err


@pytest.mark.parametrize("command", ["score", "render"])
def test_what_is_no_take_is_said_in_one_line(command, short, capsys):
    assert main([command, str(short)]) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert "wave.bvh" in captured.err


def test_tune_finds_a_stiffness_between_its_bounds(short, tmp_path, capfd):
    words = [
        "--law",
        "paper",
        "--plan",
        "upper",
        "--survey",
        "3",
        "--low",
        "300",
        "--high",
        "30000",
    ]
    found = answer(capfd, "tune", str(short), *words, "--out", str(tmp_path))
    assert 300 <= found["best"]["stiffness"] <= 30000
    assert found["best"]["cost"] == min(trial["cost"] for trial in found["trials"])
    assert json.loads((tmp_path / "wave_tuning.json").read_text())["best"] == found["best"]
    assert (tmp_path / "wave_tuning.png").exists()


def test_tune_says_each_stiffness_once_and_how_to_use_the_best(short, tmp_path, capsys):
    words = ["--law", "paper", "--plan", "upper", "--survey", "3", "--low", "300"]
    assert main(["tune", str(short), *words, "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    head, _, *rows = shown.split("\n\n")[0].splitlines()
    assert "mean error deg" in head and "cost deg" in head
    tried = [row.split()[0] for row in rows]
    assert len(set(tried)) == len(tried) >= 3
    best = json.loads((tmp_path / "wave_tuning.json").read_text())["best"]["stiffness"]
    used = f"use it: understudy track {short} --plan upper --law paper --stiffness {best:.0f}\n"
    assert used in shown


@pytest.mark.parametrize("command", ["info", "track"])
def test_a_wrong_unit_is_doubted(command, short, tmp_path, capsys):
    out = ["--out", str(tmp_path)] if command == "track" else []
    assert main([command, str(short), "--unit", "0.004", *out]) == 0
    assert "Stands 0.70 m tall: check unit= (--unit)." in " ".join(capsys.readouterr().out.split())


def test_a_table_of_positions_is_not_read_back(short, tmp_path, capsys):
    table = tmp_path / "wave.csv"
    assert main(["convert", str(short), str(table)]) == 0
    capsys.readouterr()
    assert main(["info", str(table)]) == 2
    said = capsys.readouterr().err
    assert "is a table of joint positions; it cannot be read back as motion" in said
    assert said.count("\n") == 1


def test_sheets_are_drawn_alike_by_both_commands(short, out, tmp_path):
    assert main(["track", str(short), "--out", str(tmp_path), "--stills"]) == 0
    tracked = (tmp_path / "wave.png").read_bytes()
    words = ["render", str(out / "wave.take.npz"), "--out", str(tmp_path / "again"), "--stills"]
    assert main(words) == 0
    assert (tmp_path / "again" / "wave.png").read_bytes() == tracked


def test_samples_are_listed_and_written(tmp_path, capfd):
    assert set(answer(capfd, "samples")["samples"]) == set(us.samples())
    files = answer(capfd, "samples", "gesture", "--out", str(tmp_path))["files"]
    assert us.read(files["gesture"]).duration == pytest.approx(us.sample("gesture").duration)


def test_fetch_lists_what_there_is_with_its_terms(capfd):
    found = answer(capfd, "fetch")["motions"]
    assert "cmu/02_01" in found
    assert all(entry["terms"] for entry in found.values())


def test_fetch_suggests_the_nearest_name(capsys):
    assert main(["fetch", "cmu/02_1"]) == 2
    assert "Did you mean 'cmu/02_01'?" in capsys.readouterr().err
