"""The reproduction of Hodgins et al. 1995: running."""

from __future__ import annotations

import json

import numpy as np
import pytest

from understudy.athletics import running_law as law
from understudy.athletics.running import Running
from understudy.errors import ClipError, UnknownName
from understudy.papers import hodgins1995
from understudy.papers.hodgins1995 import paths, published, runs, states
from understudy.papers.hodgins1995.timeline import Timeline
from understudy.simulate import simulate
from understudy.simulate.remembered import remembered


@pytest.fixture(scope="module")
def made():
    return hodgins1995.reproduce("running", quick=True)


def test_every_statement_has_a_measurement_with_numbers(made):
    held, count = made.held
    assert count >= 20 and held >= 16
    for finding in made.findings:
        for claim in finding.claims:
            assert any(letter.isdigit() for letter in claim.measured), claim


def test_the_page_and_the_numbers_are_written(made, tmp_path):
    hodgins1995.write(made, tmp_path)
    kept = json.loads((tmp_path / "hodgins1995.json").read_text(encoding="utf-8"))
    assert kept["part"] == "running" and kept["captured"] == []
    assert kept["statements"] == made.held[1]
    page = (tmp_path / "hodgins1995.html").read_text(encoding="utf-8")
    for word in ("Figure 3: States", "Figure 6: Hip and knee", "Quick run", "cannot be compared"):
        assert word in page
    assert "http" not in page.replace("http-equiv", "")
    head = (tmp_path / "hodgins1995_figure_3.csv").read_text(encoding="utf-8").splitlines()[0]
    assert head.split(",")[1:7] == list(law.STATES)


def test_an_unknown_part_or_folder_is_refused(tmp_path):
    with pytest.raises(UnknownName, match="running"):
        hodgins1995.reproduce("swimming")
    with pytest.raises(ClipError, match="no such folder"):
        hodgins1995.reproduce("running", tmp_path / "none")


def test_memory_is_that_of_the_run_itself():
    whole = runs.steady(3.5, 0.3)
    (memory,) = remembered(whole)
    assert memory.shape[0] == whole.steps
    assert memory[-1, law.TOUCHDOWN] > memory[0, law.TOUCHDOWN]
    # Touchdown as the controller felt it: the foot is on the ground in the take, too.
    step = int(np.argmax(np.diff(memory[:, law.TOUCHDOWN]) > 0)) + 1
    assert simulate(whole).qpos[step, 2] < 1.1


def test_states_share_a_step_and_a_timeline_draws_every_stay():
    (memory,) = remembered(runs.steady(3.5, 1.0))
    shown = states._timeline(memory, states._means(states._spells(memory)))
    assert shown.html().count("<rect") == len(shown.spells())
    assert sum(float(note.split(" %")[0]) for note in shown.notes) == pytest.approx(100, abs=3)


def test_a_timeline_tells_stays_apart_by_state_and_leg():
    line = Timeline(
        title="t",
        caption="c",
        names=("a", "b"),
        notes=("", ""),
        times=np.arange(6.0),
        states=np.array([0, 0, 1, 1, 0, 0]),
        legs=np.array([0, 0, 0, 1, 1, 1]),
    )
    assert [spell[:2] for spell in line.spells()] == [(0, 0), (1, 0), (1, 1), (0, 1)]
    assert line.spells()[1][2:] == (2.0, 3.0)


def test_the_drawn_path_is_one_line_with_bends_both_ways():
    path = paths.drawn_path()
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert (steps > 0).all()
    way = np.unwrap(np.arctan2(*np.diff(path, axis=0).T[::-1]))
    assert way.max() == pytest.approx(np.pi, abs=0.05) and way[-1] == pytest.approx(0.0, abs=0.05)


def test_changed_gains_hold_at_every_speed():
    (runner, *_) = runs.changed(runs.steady(3.5, 1.0), mirror=0.0).controllers
    assert isinstance(runner, Running)
    assert runner.schedule.at(5.0).mirror == 0.0
    assert runner.schedule.at(5.0).pitch != runner.schedule.at(2.5).pitch


def test_figures_shown_are_the_papers():
    assert [figure.number for figure in published.FIGURES] == [1, 2, 3, 5, 6]


@pytest.mark.clips
def test_captured_runs_are_found(clips):
    found = runs.captured_runs(clips)
    assert [one.name for one in found] == list(runs.CAPTURED)
    assert all(one.gait.cycles for one in found)
