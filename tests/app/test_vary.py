"""`understudy vary`, end to end: files, table, JSON, words that cannot be."""

from __future__ import annotations

import json

import pytest

from understudy.app.main import main
from understudy.app.vary import Options, amount, asked
from understudy.errors import InvalidValue
from understudy.variations import Length, Limp, Lock, Mass, Scaling, Speed, Strength


def test_a_family_is_made_and_listed(short, tmp_path, capsys):
    words = ["vary", str(short), "--count", "2", "--preset", "zombie,tired", "--out", str(tmp_path)]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("member")
    assert "000_zombie" in shown
    assert "001_tired" in shown
    assert str(tmp_path / "family.html") in shown
    assert len(list((tmp_path / "members").glob("*.bvh"))) == 3


def test_json_is_one_object_and_the_same_command_goes_on(short, tmp_path, capfd):
    words = ["vary", str(short), "--limp", "right_arm", "--json", "--out", str(tmp_path)]
    assert main([*words, "--count", "1"]) == 0
    first = json.loads(capfd.readouterr().out)
    assert (first["count"], first["reused"]) == (1, 0)
    assert first["members"][0]["says"] == ["grip 0.5", "right arm: limp"]
    assert main([*words, "--count", "2"]) == 0
    again = json.loads(capfd.readouterr().out)
    assert again["reused"] == 1
    assert again["members"][0] == first["members"][0]


def test_a_linkage_can_be_varied(short, tmp_path, capsys):
    words = ["vary", str(short), "--linkage", "tree", "--count", "1", "--scale", "left_arm=1.2:1.5"]
    assert main([*words, "--out", str(tmp_path)]) == 0
    assert "000_varied" in capsys.readouterr().out


def test_an_interrupt_says_how_many_are_finished(short, tmp_path, capsys, monkeypatch):
    from understudy.family import family

    real = family.__globals__["performed"]

    def once(part, *rest):
        if part.index == 1:
            raise KeyboardInterrupt
        return real(part, *rest)

    monkeypatch.setitem(family.__globals__, "performed", once)
    words = ["vary", str(short), "--limp", "right_arm", "--count", "3", "--jobs", "1"]
    assert main([*words, "--out", str(tmp_path)]) == 130
    shown = capsys.readouterr().err
    assert "1 of 3 members are finished and kept; the same command goes on." in shown


def test_words_become_variations():
    options = Options(
        clip="x",
        scale=("right_knee=1:1.4@2:6",),
        mass=("left_foot=2:4", "70"),
        length=("legs=1.1",),
        strength=("neck=0.5",),
        limp=("left_arm,neck",),
        lock=("left_knee", "left_wrist=mean"),
        speed="0.8:1.2",
    )
    assert asked(options) == [
        Length(link="legs", by=1.1),
        Scaling(joint="right_knee", by=(1.0, 1.4), start=2.0, end=6.0),
        Mass(link="left_foot", by=(2.0, 4.0)),
        Strength(joint="neck", by=0.5),
        Limp(joint="left_arm"),
        Limp(joint="neck"),
        Lock(joint="left_knee"),
        Lock(joint="left_wrist", at="mean"),
        Speed(by=(0.8, 1.2)),
    ]


@pytest.mark.parametrize("word", ["", "a", "1:", "1:2:3", "nan", "inf:2"])
def test_a_word_that_is_no_amount_is_refused(word):
    with pytest.raises(InvalidValue, match="neither a number nor a range"):
        amount("--speed", word)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--limp", "right_arn"], "Did you mean 'right_arm'?"),
        (["--preset", "zombi"], "Did you mean 'zombie'?"),
        (["--mass", "left_foot=0"], "must be positive"),
        (["--mass", "heavy"], "--mass"),
        (["--scale", "neck=1:2@3:1"], "empty"),
        (["--scale", "neck"], "--scale NAME=LO:HI"),
        (["--strength", "neck=2:1"], "empty"),
        (["--lock", "neck=bent"], "straight"),
        (["--strength-slider", "2"], "0 to 1"),
        (["--count", "0"], "count is 0"),
        (["--jobs", "0"], "jobs is 0"),
        (["--seed", "-1"], "seed is -1"),
        (["--linkage", "tree", "--mass", "70"], "--mass: for characters only"),
        (["--linkage", "tree", "--pelvis", "free"], "--pelvis: for characters only"),
        (["--linkage", "tree", "--torque-limits", "human"], "--torque-limits: for"),
        (["--linkage", "tree", "--plan", "upper", "--character", "child"], "--character, --plan"),
        (["--linkage", "tree", "--length", "legs=2"], "as long as"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(words, expected, short, tmp_path, capsys):
    folder = tmp_path / "out"
    assert main(["vary", str(short), "--out", str(folder), *words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert expected in captured.err
    assert not folder.exists()


def test_help_says_what_the_slider_trades(capsys):
    with pytest.raises(SystemExit):
        from understudy.app.main import parse

        parse("vary", ["--help"])
    shown = " ".join(capsys.readouterr().out.split())
    assert "trades tracking against the generative effect" in shown
    assert "understudy vary sample:walk" in shown
