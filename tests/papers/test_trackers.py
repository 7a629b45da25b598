"""Runs, groups and the page that holds them beside published trackers."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.control import Push
from understudy.errors import InvalidValue
from understudy.papers.trackers import (
    DIFFERENT,
    TRACKERS,
    Run,
    page_html,
    run_of,
    summaries,
    table,
)
from understudy.papers.trackers.replays import changed, kept
from understudy.papers.trackers.runs import (
    HEAD,
    SUMMARY_HEAD,
    dynamic,
    easy,
    flight,
    reasons,
    survival,
    worst,
)
from understudy.simulate import prepared

WALK = Run(
    label="cmu_bvh/walk.bvh",
    seconds=4.0,
    score_percent=3.0,
    free=True,
    help_percent=0.0,
    free_s=4.0,
    joint_deg=2.0,
    com_mm=6.0,
    global_mm=10.0,
    peak_mm=40.0,
    relative_mm=7.0,
    slide_mm_s=20.0,
    clip_slide_mm_s=30.0,
    flight_s=0.0,
    cpu_s=8.0,
    survived={"push 50 N": (3, 4)},
)
JUMP = replace(WALK, label="cmu_bvh/jump.bvh", number=1, score_percent=15.0, flight_s=0.4)
HELD = replace(
    WALK,
    label="other/wheel.bvh",
    number=2,
    score_percent=40.0,
    free=False,
    help_percent=9.0,
    free_s=0.0,
    survived={"push 50 N": (1, 4)},
)
BROKEN = Run(label="odd/none.bvh", number=3, error="it has no legs")
RUNS = [WALK, JUMP, HELD, BROKEN]


def test_a_run_comes_back_from_its_line() -> None:
    assert Run.from_dict(json.loads(json.dumps(WALK.as_dict()))) == WALK
    with pytest.raises(InvalidValue, match="label"):
        Run.from_dict({"seed": 1})


def test_groups_go_by_score_flight_and_length() -> None:
    assert easy(WALK) and not dynamic(WALK)
    assert dynamic(JUMP) and not easy(JUMP)
    assert not easy(replace(WALK, seconds=11.0))
    assert not easy(replace(WALK, label="other/walk.bvh"))
    assert easy(replace(JUMP, score_percent=6.0)) and dynamic(replace(JUMP, score_percent=6.0))
    assert not easy(replace(WALK, score_percent=None))


def test_summaries_count_each_half_and_leave_out_what_failed() -> None:
    rows = {(row[0], row[1]): dict(zip(SUMMARY_HEAD, row, strict=True)) for row in summaries(RUNS)}
    whole = rows["all", "all"]
    assert (whole["runs"], whole["free"]) == (3, 2)
    assert whole["free, close %"] == pytest.approx(200.0 / 3.0)
    assert whole["global mm"] == 10.0 and whole["CPU-s/s"] == 2.0
    assert whole["help of the others % BW"] == 9.0
    assert whole["slide <= clip's %"] == 100.0
    assert rows["all", "held out"]["runs"] == 1
    assert rows["everything else", "all"]["free %"] == 0.0


def test_a_clip_searched_in_vain_counts_as_not_free() -> None:
    vain = Run(
        label="cmu_bvh/b.bvh", seconds=3.0, score_percent=2.0, flight_s=0.0, error="It fell."
    )
    rows = {(row[0], row[1]): row for row in summaries([WALK, vain])}
    easy_all = dict(
        zip(SUMMARY_HEAD, rows["CMU clips up to 10 s, score <= 7 %", "all"], strict=True)
    )
    assert (easy_all["runs"], easy_all["free"]) == (2, 1)
    (line,) = table([vain])
    assert line[2:5] == ("3.00", "2.0", "none")


def test_the_flight_of_a_tracked_clip_needs_no_take() -> None:
    clip = us.sample("gesture").trimmed(1.0, 1.3)
    assert flight(us.tracked(clip, us.Character.from_clip(clip))) == 0.0


def test_a_free_body_far_off_is_not_close() -> None:
    assert WALK.close
    assert not replace(WALK, peak_mm=151.0).close
    assert not replace(WALK, free=False).close


def test_survival_adds_up_over_runs() -> None:
    assert survival(RUNS) == [("push 50 N", 7, 12)]


def test_the_worst_come_first_and_each_clip_once() -> None:
    other = replace(HELD, seed=1, help_percent=12.0)
    assert worst([*RUNS, other], 2) == [other, WALK]


def test_every_row_has_a_cell_for_every_column() -> None:
    rows = table(RUNS)
    assert [len(row) for row in rows] == [len(HEAD)] * 4
    assert "none" in rows[-1]
    assert reasons(RUNS) == ["odd/none, seed 0: it has no legs"]
    assert rows[0][0] == "cmu_bvh/walk"


def test_every_published_number_has_a_source() -> None:
    assert all(tracker.source for tracker in TRACKERS)
    numbered = [t for t in TRACKERS if t.success_percent is not None]
    assert all(0.0 < t.success_percent <= 100.0 for t in numbered)
    assert {t.checked for t in TRACKERS} <= {"source", "quoted", "memory"}


def test_the_page_shows_both_sides_and_plays_the_worst(tmp_path) -> None:
    clip = us.sample("gesture").trimmed(1.0, 1.2)
    take = us.track(clip, us.Character.from_clip(clip))
    path = tmp_path / "a.take.npz"
    us.write(take, path)
    run = run_of(take, "cmu_bvh/gesture.bvh", cpu_s=0.4)
    assert run.score_percent is not None and run.score_percent < 5.0
    assert run.cost == pytest.approx(2.0, rel=1e-6)
    assert run.relative_mm is not None and run.global_mm is not None
    html = page_html([run, *RUNS], takes={(run.label, run.seed): path}, settings="Whole clips.")
    assert html.count("<iframe") == 1
    assert "PHC+" in html and "from memory" in html
    assert all(text[:20] in html for text in DIFFERENT)
    assert "it has no legs" in html
    assert "Whole clips." in html


def test_replays_change_one_thing_each() -> None:
    clip = us.sample("gesture").trimmed(1.0, 1.2)
    performance = us.tracked(clip, us.Character.from_clip(clip))
    found = changed(performance)
    assert {name: len(each) for name, each in found.items()} == {
        "push of 50 N": 12,
        "push of 100 N": 12,
        "friction 0.6": 1,
        "mass + 5 %": 1,
        "mass - 5 %": 1,
        "gains - 10 %": 1,
    }
    before = performance.scene.model
    (slippery,), (heavier,) = found["friction 0.6"], found["mass + 5 %"]
    assert slippery.scene.ground is not None and slippery.scene.ground.friction == 0.6
    assert heavier.scene.model.body_mass.sum() == pytest.approx(1.05 * before.body_mass.sum())
    (weaker,) = found["gains - 10 %"]
    usual, weak = prepared(performance)[0], prepared(weaker)[0]
    joints = list(performance.scene.parts[0].joint_actuators)
    for now, then in (
        (weak.actuator_gainprm, usual.actuator_gainprm),
        (weak.actuator_biasprm, usual.actuator_biasprm),
    ):
        assert np.allclose(now[joints], 0.9 * then[joints])
    pushes = [one.controllers[-1] for one in found["push of 50 N"]]
    assert all(isinstance(p, Push) and np.linalg.norm(p.impulse) == 5.0 for p in pushes)


def test_a_replay_is_kept_until_it_is_lost() -> None:
    clip = us.sample("gesture").trimmed(1.0, 1.6)
    performance = us.tracked(clip, us.Character.from_clip(clip))
    assert kept(performance)
    push = Push(time=0.1, on="pelvis", impulse=(3000.0, 0.0, 0.0))
    assert not kept(replace(performance, controllers=(*performance.controllers, push)))
