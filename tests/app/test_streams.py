"""Standard streams that are closed, full or gone, and requests to end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from understudy.app import main as app
from understudy.app import performing
from understudy.app.outcome import Interrupted

linux = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")


def shell(words: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    line = words.replace("understudy", f"'{sys.executable}' -m understudy.app.main", 1)
    return subprocess.run(
        ["sh", "-c", line], capture_output=True, text=True, timeout=60, check=False, cwd=folder
    )


@linux
@pytest.mark.parametrize(
    ("words", "status"),
    [
        ("understudy --help > /dev/full", 1),
        ("understudy samples --help > /dev/full", 1),
        ("understudy trak > /dev/full", 2),
        ("understudy trak --json > /dev/full", 2),
        ("understudy trak 2> /dev/full", 2),
        ("understudy --version >&-", 0),
        ("understudy trak --json >&-", 2),
        ("understudy trak 2>&-", 2),
        ("understudy trak >&- 2>&- <&-", 2),
    ],
)
def test_a_stream_that_fails_leaves_the_status_and_no_traceback(words, status):
    done = shell(words)
    assert done.returncode == status
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    if status == 1:
        assert done.stderr == (
            "understudy: standard output cannot be written: No space left on device.\n"
        )


@linux
def test_a_reader_that_went_away_is_no_error():
    done = shell("understudy --help | true")
    assert done.returncode == 0
    assert not done.stderr


@linux
def test_json_goes_to_a_file_although_other_streams_are_closed(tmp_path):
    file = tmp_path / "answer.json"
    done = shell(f"understudy samples --json <&- 2>&- > '{file}'")
    assert done.returncode == 0
    assert "gesture" in json.loads(file.read_text())["samples"]


@linux
def test_a_name_that_standard_output_cannot_spell_is_written_as_an_escape(tmp_path):
    done = shell("PYTHONIOENCODING=ascii PYTHONUTF8=0 understudy info 'gehöft.bvh'", tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "geh\\xf6ft.bvh: no such file" in done.stderr


@linux
def test_a_folder_that_is_gone_is_said_in_one_line(tmp_path):
    (tmp_path / "gone").mkdir()
    words = f"cd '{tmp_path}/gone' && rmdir ../gone && exec "
    done = shell(words + "understudy track sample:gesture")
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("understudy track: the current folder is there")


def test_a_request_to_end_is_one_line_and_status_143(monkeypatch, capsys):
    from understudy.app import samples

    def ended(_):
        os.kill(os.getpid(), signal.SIGTERM)
        pytest.fail("the signal must stop the work")

    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr(samples, "run", ended)
    assert app.main(["samples"]) == 143
    assert capsys.readouterr().err == "understudy samples: told to end; finished files are kept.\n"
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.parametrize(
    ("stop", "status"), [(KeyboardInterrupt(), 130), (Interrupted(status=143), 143)]
)
def test_a_stopped_run_lists_the_clips_it_finished(
    stop, status, short, tmp_path, monkeypatch, capfd
):
    real, seen = performing.performed, []

    def second_time_stopped(job):
        seen.append(job)
        if len(seen) == 2:
            raise stop
        return real(job)

    monkeypatch.setattr(performing, "performed", second_time_stopped)
    words = ["track", str(short), str(short), "--out", str(tmp_path), "--jobs", "1", "--json"]
    assert app.main(words) == status
    answer = json.loads(capfd.readouterr().out)
    assert answer["status"] == status
    assert "finished files are kept" in answer["error"]
    (clip,) = answer["clips"]
    assert Path(clip["files"]["json"]).exists()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["track", "a.bvh", "--plan", "ful"], "'full', 'full16', 'upper', 'upper8'. Did you mean"),
        (["track", "a.bvh", "--law", "Paper"], "Did you mean 'paper'?"),
        (["track", "a.bvh", "--pelvis", "none"], "one of 'assisted', 'free', 'led'. See"),
        (["info", "a.bvh", "--up", "w"], "Expected one of 'x', 'y', 'z'. See"),
        (["convert", "a.bvh", "b.bvh", "--speed="], "--speed needs a value. See"),
        (["info", "a.bvh", "--rate="], "--rate needs a value. See"),
        (["track", "a.bvh", "--seed", "1.5"], "--seed is '1.5', which is no whole number."),
        (["info", "a.bvh", "--json=true"], "--json takes no value"),
    ],
)
def test_a_refused_choice_says_what_was_meant(words, expected, capsys):
    assert app.main(words) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert expected in captured.err
    assert "None" not in captured.err
