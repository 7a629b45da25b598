"""`understudy track --pelvis free`: the search is kept, the best seed wins, the table says how."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import understudy as us
from understudy.app import freeing
from understudy.app.main import main
from understudy.control import Push
from understudy.errors import NotFound, UnderstudyError
from understudy.evaluate import following
from understudy.free_tracking import UnusableSearch
from understudy.performance import tracked
from understudy.simulate import simulate


@pytest.fixture(scope="module")
def freely(short, tmp_path_factory):
    """What the command wrote and printed for the short clip."""
    folder = tmp_path_factory.mktemp("free")
    assert main(["track", str(short), "--pelvis", "free", "--out", str(folder)]) == 0
    return folder


def test_nothing_holds_a_free_clip_and_the_search_is_kept(freely):
    saved = json.loads((freely / "wave.json").read_text(encoding="utf-8"))
    (one,) = saved["characters"]
    assert saved["fully_physical"] and one["pelvis"] == "free"
    assert one["following"]["free"]
    assert saved["statement"].startswith("Nothing but contact holds the body")
    assert (freely / "wave.seed0.search").stat().st_size > 0


def test_the_same_command_goes_on_from_its_search(freely, short, capsys):
    before = (freely / "wave_sim.bvh").read_bytes()
    assert main(["track", str(short), "--pelvis", "free", "--out", str(freely)]) == 0
    assert (freely / "wave_sim.bvh").read_bytes() == before
    told = capsys.readouterr()
    head, _, line = told.out.splitlines()[:3]
    assert "s free" in head and line.split()[-1] == "0"
    search = freely / "wave.seed0.search"
    assert f"{search}: this finished search was used again." in told.err
    assert f"  {search}\nThe same command goes on from the .search" in told.out


def test_the_search_is_among_the_files_for_machines(freely, short, capsys):
    assert main(["track", str(short), "--pelvis", "free", "--out", str(freely), "--json"]) == 0
    (clip,) = json.loads(capsys.readouterr().out)["clips"]
    assert clip["files"]["seed0.search"] == str(freely / "wave.seed0.search")


def test_searches_are_found_among_any_number_of_seeds(tmp_path):
    for name in ("w.seed0.search", "w.seed7.search", "w.seedx.search", "w.seed7.search.old"):
        (tmp_path / name).touch()
    found = freeing.searches(tmp_path, "w", range(10**11))
    assert sorted(found) == ["seed0.search", "seed7.search"]


def test_a_folder_where_the_search_belongs_is_refused_before_any_work(short, tmp_path, capsys):
    (tmp_path / "wave.seed0.search").mkdir()
    assert main(["track", str(short), "--pelvis", "free", "--out", str(tmp_path)]) == 2
    assert "wave.seed0.search: is no file" in capsys.readouterr().err


def test_an_old_search_stays_until_there_is_a_new_one(short, tmp_path, monkeypatch):
    kept = tmp_path / "wave.seed0.search"
    kept.write_bytes(b"of another clip")

    def interrupted(clip, character, **settings):
        if settings["checkpoint"].exists():
            raise UnusableSearch("of another clip")
        raise KeyboardInterrupt

    monkeypatch.setattr(us, "track", interrupted)
    clip = us.sample("gesture").trimmed(0.0, 0.1)
    given = {"seeds": 1, "folder": tmp_path, "name": "wave"}
    with pytest.raises(KeyboardInterrupt):
        freeing.freed(clip, us.Character.from_clip(clip), {}, **given)
    assert kept.read_bytes() == b"of another clip"


@pytest.mark.parametrize(
    ("percent", "whole", "more"),
    [
        (2.0, True, "need less help"),
        (0.0, True, "be harder to push over"),
        (2.0, False, "come farther"),
    ],
)
def test_a_budget_that_ended_the_search_is_said(percent, whole, more):
    from understudy.app.track import hurried

    one = {"following": {"help_percent": percent, "whole": whole}}
    facts = {"guidance": {"out_of_time_s": 3.0}}
    row: Any = SimpleNamespace(error="", certificate={"facts": facts, "characters": [one]})
    assert hurried(row) == [f"The budget of 3 s ended the search: with more it may {more}."]


def test_the_take_file_performs_again_bit_for_bit_and_can_be_pushed(freely):
    take = us.load_take(freely / "wave.take.npz")
    performance = take.performance
    assert performance is not None
    assert np.array_equal(us.simulate(performance).qpos, take.qpos)
    push = Push(time=0.1, on="pelvis", impulse=(0.0, 5.0, 0.0))
    pushed = us.simulate(replace(performance, controllers=(*performance.controllers, push)))
    assert not np.array_equal(pushed.qpos, take.qpos)
    assert following(pushed).lost_s is None


def test_what_the_search_cost_is_told_again(freely, short):
    def cost():
        saved = json.loads((freely / "wave.json").read_text(encoding="utf-8"))
        return saved["timing"]["search_cpu_seconds"]

    before = cost()
    assert main(["track", str(short), "--pelvis", "free", "--out", str(freely)]) == 0
    assert 0.9 * before < cost() < before + 5.0
    before = cost()
    assert main(["track", str(short), "--pelvis", "free", "--out", str(freely)]) == 0
    assert cost() == before  # only read again


@pytest.mark.parametrize("damaged", [False, True])
def test_a_search_of_another_clip_or_damaged_is_begun_anew(damaged, short, tmp_path, capsys):
    search = tmp_path / "wave.seed0.search"
    if damaged:
        search.write_text("nothing of the kind")
    else:
        np.savez(tmp_path / "other.npz", text=np.array('{"search": {"seed": 7}}'))
        (tmp_path / "other.npz").rename(search)
    assert main(["track", str(short), "--pelvis", "free", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err.strip().endswith("the search begins anew.")
    assert search.read_bytes()[:2] == b"PK" and search.stat().st_size > 10_000


def test_a_clip_performed_in_part_is_written_and_said_in_one_line(
    short, tmp_path, capsys, monkeypatch
):
    clip = us.read(short)
    part = us.track(clip, us.Character.from_clip(clip))
    assert part.performance is not None
    half = simulate(replace(part.performance, duration=0.5 * clip.duration))
    monkeypatch.setattr(us, "track", lambda *_, **__: half)
    assert main(["track", str(short), "--pelvis", "free", "--out", str(tmp_path)]) == 1
    told = capsys.readouterr()
    assert "wave: performed until" in told.err and told.err.count("\n") == 1
    saved = json.loads((tmp_path / "wave.json").read_text(encoding="utf-8"))
    assert not saved["characters"][0]["following"]["whole"]
    assert (tmp_path / "wave.take.npz").exists()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--seeds", "2"], "--seeds is for --pelvis free"),
        (["--pelvis", "assisted", "--budget", "9"], "--budget is for --pelvis free"),
        (["--pelvis", "free", "--budget", "0"], "--budget is 0"),
        (["--pelvis", "free", "--seeds", "-1"], "--seeds is -1"),
        (["--pelvis", "free", "--plan", "upper"], "--plan upper leaves the legs out"),
        (["--pelvis", "free", "--seed", "-1"], "seed is -1; it must be a whole number from 0 on"),
    ],
)
def test_what_cannot_be_searched_is_said_in_one_line(words, expected, short, tmp_path, capsys):
    folder = tmp_path / "out"
    assert main(["track", str(short), *words, "--out", str(folder)]) == 2
    captured = capsys.readouterr()
    assert expected in captured.err and captured.err.count("\n") == 1
    assert not folder.exists()


def test_seeds_are_tried_until_one_is_free_and_no_further(short, tmp_path, monkeypatch):
    clip = us.read(short)
    body = us.Character.from_clip(clip)
    helped = us.track(clip, body)
    free = simulate(tracked(clip, body, pelvis="free"))
    asked = []

    def by_seed(*_, seed, checkpoint, **__):
        asked.append((seed, checkpoint.name))
        if seed == 4:
            raise UnderstudyError("it fell")
        return helped if seed == 5 else free

    monkeypatch.setattr(us, "track", by_seed)
    take = freeing.freed(clip, body, {"seed": 4}, seeds=9, folder=tmp_path, name="wave")
    assert take is free and take.facts["seeds_tried"] == 3
    assert asked == [(seed, f"wave.seed{seed}.search") for seed in (4, 5, 6)]


def test_without_a_free_seed_the_least_help_wins(short, tmp_path, monkeypatch):
    clip = us.read(short)
    helps = {0: 9.0, 1: 3.0, 2: 5.0}
    monkeypatch.setattr(us, "track", lambda *_, seed, **__: SimpleNamespace(seed=seed, facts={}))
    monkeypatch.setattr(freeing, "badness", lambda take: (helps[take.seed], 1.0))
    take = freeing.freed(clip, None, {}, seeds=3, folder=tmp_path, name="wave")  # type: ignore
    assert take.seed == 1


def test_when_no_seed_comes_to_the_end_the_first_reason_is_told(short, tmp_path, monkeypatch):
    def fell(*_, seed, **__):
        raise NotFound(f"seed {seed} fell")

    monkeypatch.setattr(us, "track", fell)
    with pytest.raises(NotFound, match="w: seed 0 fell"):
        freeing.freed(us.read(short), None, {}, seeds=2, folder=tmp_path / "a", name="w")  # type: ignore
    assert not (tmp_path / "a").exists()


def test_an_interrupt_says_that_the_search_goes_on(short, tmp_path, monkeypatch, capsys):
    def stopped(*_, checkpoint, **__):
        checkpoint.write_bytes(b"so far")
        raise KeyboardInterrupt

    monkeypatch.setattr(us, "track", stopped)
    assert main(["track", str(short), "--pelvis", "free", "--out", str(tmp_path)]) == 130
    assert "the same command goes on with it" in capsys.readouterr().err


def test_an_interrupt_says_nothing_of_a_search_that_was_there(short, tmp_path, monkeypatch, capsys):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(us, "track", stopped)
    (tmp_path / "wave.seed0.search").write_bytes(b"of old")
    assert main(["track", str(short), "--pelvis", "free", "--out", str(tmp_path)]) == 130
    said = capsys.readouterr().err
    assert "finished files are kept" in said and "goes on" not in said


def test_a_search_in_vain_is_no_bad_input(short, tmp_path, monkeypatch, capsys):
    def fell(*_, **__):
        raise NotFound("No pass came far.")

    monkeypatch.setattr(us, "track", fell)
    assert main(["track", str(short), "--pelvis", "free", "--out", str(tmp_path)]) == 1
    assert "wave: No pass came far." in capsys.readouterr().err
