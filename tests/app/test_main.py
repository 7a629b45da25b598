"""The dispatcher: quick help, one-line errors, exit statuses, JSON and nothing else."""

from __future__ import annotations

import json
import subprocess
import sys
import time

import pytest

from understudy.app import main as app

HEAVY = ("numpy", "mujoco", "numba", "scipy", "tyro", "matplotlib", "viser")


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "understudy.app.main", *words],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_help_answers_at_once_and_names_every_command():
    started = time.monotonic()
    done = run("--help")
    assert time.monotonic() - started < 3.0  # 0.06 s on an idle machine
    assert done.returncode == 0
    assert not done.stderr
    for name, line in app.COMMANDS.items():
        assert name in done.stdout
        assert line in done.stdout


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from understudy.app.main import main; main(['--help']); "
        f"print([m for m in {HEAVY!r} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("name", app.COMMANDS)
def test_every_command_answers_help_with_an_example(name, capsys):
    assert app.main([name, "--help"]) == 0
    out = capsys.readouterr().out
    assert f"usage: understudy {name}" in out
    assert out.rstrip().splitlines()[-1].strip().startswith(f"understudy {name}")


def test_command_help_does_not_import_the_engine():
    code = (
        "import sys; from understudy.app.main import main; main(['track', '--help']); "
        "print([m for m in ('numpy', 'mujoco', 'numba', 'scipy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_no_command_shows_the_usage_and_fails(capsys):
    assert app.main([]) == 2
    assert "usage: understudy" in capsys.readouterr().out


def test_version_is_one_line(capsys):
    assert app.main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("understudy 0.")


def test_an_unknown_command_suggests_the_nearest(capsys):
    assert app.main(["trak", "walk.bvh"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert "Did you mean 'track'?" in captured.err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["convert", "a.bvh", "b.bvh", "--sped", "2"], "Did you mean --speed?"),
        (["convert", "a.bvh", "b.bvh", "--speed", "fast"], "--speed"),
        (["track", "a.bvh", "--law", "newton"], "'modern'"),
        (["convert", "a.bvh"], "OUT is missing"),
        (["track", "a.bvh", "--jobs", "many"], "--jobs: it cannot be 'many'"),
    ],
)
def test_bad_options_are_one_line_that_names_the_help(words, expected, capsys):
    assert app.main(words) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert expected in captured.err
    assert f"See: understudy {words[0]} --help" in captured.err


@pytest.mark.parametrize(
    "words",
    [
        ["--json"],
        ["--json", "trak"],
        ["trak", "--json"],
        ["convert", "no_such_file.bvh", "b.bvh", "--json"],
        ["convert", "a.bvh", "b.bvh", "--sped", "2", "--json"],
    ],
)
def test_errors_under_json_are_one_object(words, capfd):
    assert app.main(words) == 2
    captured = capfd.readouterr()
    answer = json.loads(captured.out)
    assert answer["status"] == 2
    assert answer["error"]


def test_a_defect_is_one_line_with_its_own_status(monkeypatch, capsys):
    from understudy.app import samples

    def broken(_):
        raise RuntimeError("a list\nof two lines")

    monkeypatch.setattr(samples, "run", broken)
    assert app.main(["samples"]) == app.DEFECT
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert "a list of two lines" in captured.err
    assert "Traceback" not in captured.err


def test_debug_shows_where(monkeypatch):
    from understudy.app import samples

    def broken(_):
        raise RuntimeError("here")

    monkeypatch.setattr(samples, "run", broken)
    monkeypatch.setenv("UNDERSTUDY_DEBUG", "1")
    with pytest.raises(RuntimeError, match="here"):
        app.main(["samples"])


def test_debug_shows_where_a_clip_failed_too(monkeypatch, capsys, tmp_path):
    import understudy as us

    def broken(*_, **__):
        raise RuntimeError("here")

    monkeypatch.setattr(us, "track", broken)
    words = ["track", "sample:gesture", "--out", str(tmp_path)]
    assert app.main(words) == app.DEFECT
    assert "Traceback" not in capsys.readouterr().err
    monkeypatch.setenv("UNDERSTUDY_DEBUG", "1")
    assert app.main(words) == app.DEFECT
    told = capsys.readouterr().err
    assert "Traceback" in told and 'raise RuntimeError("here")' in told


def test_an_interrupt_is_one_line_and_status_130(monkeypatch, capsys):
    from understudy.app import samples

    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(samples, "run", interrupted)
    assert app.main(["samples"]) == 130
    assert capsys.readouterr().err == "understudy samples: interrupted; finished files are kept.\n"


def test_json_keeps_stray_prints_off_standard_output(monkeypatch, capfd):
    import os

    from understudy.app import samples
    from understudy.app.outcome import Outcome

    def noisy(_):
        print("from Python")
        os.write(1, b"from a C library\n")
        return Outcome(result={"a": float("nan")})

    monkeypatch.setattr(samples, "run", noisy)
    assert app.main(["samples", "--json"]) == 0
    captured = capfd.readouterr()
    assert json.loads(captured.out) == {"a": None}
    assert "from Python" in captured.err
    assert "from a C library" in captured.err
