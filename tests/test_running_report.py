"""A gait against people, and the page of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import understudy as us
from understudy.errors import InvalidValue
from understudy.evaluate.gait import Gait, gait_of
from understudy.evaluate.gait_cycle import PHASE, Cycle
from understudy.evaluate.gait_forces import StanceForce
from understudy.evaluate.gait_stances import Stance
from understudy.evaluate.people import people
from understudy.evaluate.running import likeness, matched
from understudy.evaluate.running_charts import phase_chart, running_charts
from understudy.running_report import running_data, running_page, statement, write_running

SPEED = 3.5


def average_runner(*, later: float = 0.0, bent: float = 0.0, name: str = "average") -> Gait:
    """A gait with people's own curves and timing: delayed by a share, and bent by degrees."""
    them = people(SPEED)
    value = {key: human.mean for key, human in them.figures.items()}
    stride, stance = 2.0 / value["step_rate_hz"], value["stance_s"]
    curves = {
        key: np.interp((PHASE - later) % 1.0, PHASE, curve) + np.radians(bent)
        for key, curve in them.curves.items()
    }
    curves["trunk"] = np.full(101, np.radians(6.0))
    cycles = tuple(
        Cycle(
            side=side,
            start_s=start,
            end_s=start + stride,
            stance_s=stance,
            speed=SPEED,
            acceleration=0.0,
            step_width=0.09,
            landing=(0.6, -0.6),
            rise=0.077,
            apart=0.1,
            curves=curves,
            height=0.04 * np.cos(4.0 * np.pi * PHASE),
        )
        for side, start in (("left", 0.0), ("right", 0.5 * stride))
    )
    stances = tuple(
        Stance(side=c.side, start_s=c.start_s, end_s=c.start_s + stance, whole=True, begins=True)
        for c in cycles
    )
    up = 0.5 * np.pi * value["force_mean_bw"] * np.sin(np.pi * PHASE)
    force = StanceForce(
        side="left",
        start_s=0.0,
        peak=up.max(),
        active=up.max(),
        impact=None,
        mean=value["force_mean_bw"],
        loading_rate=20.0,
        braking=-0.2,
        pushing=0.2,
        up=up,
        along=-0.3 * np.sin(2.0 * np.pi * PHASE),
    )
    return Gait(
        name=name,
        kind="contact forces",
        mass=70.0,
        height=1.75,
        leg_length=0.86,
        stances=stances,
        cycles=cycles,
        forces=(force,),
    )


def test_the_average_runner_is_like_people() -> None:
    found = likeness(average_runner())
    for name, match in found.curves.items():
        assert match.correlation == pytest.approx(1.0), name
        assert match.rms_deg == pytest.approx(0.0, abs=1e-9)
    for match in found.figures.values():
        assert match.inside in (True, None), match.name
    for name in ("stance_s", "flight_s", "step_rate_hz", "step_length_m", "force_mean_bw"):
        assert found.figures[name].difference == pytest.approx(0.0, abs=1e-6)
    for name in ("knee_touchdown_deg", "plantarflexion_toe_off_deg", "ankle_stance_peak_deg"):
        assert found.figures[name].difference == pytest.approx(0.0, abs=0.5)


def test_a_bent_runner_is_off_and_a_late_one_correlates_less() -> None:
    bent = likeness(average_runner(bent=10.0)).curves["knee"]
    assert bent.offset_deg == pytest.approx(10.0) and bent.rms_deg == pytest.approx(10.0)
    assert bent.correlation == pytest.approx(1.0)
    late = likeness(average_runner(later=0.1)).curves["knee"]
    assert late.correlation < 0.9 and late.offset_deg == pytest.approx(0.0, abs=0.2)


def test_matching_opposite_curves_gives_minus_one() -> None:
    wave = 20.0 * np.sin(2.0 * np.pi * PHASE)
    found = matched("hip", wave, -wave)
    assert found.correlation == pytest.approx(-1.0)
    assert found.rms_deg == pytest.approx(40.0 / np.sqrt(2.0))
    assert matched("hip", wave, 0.0 * wave).correlation == 0.0


def test_a_walk_is_compared_only_at_a_speed_that_is_asked_for() -> None:
    walk = gait_of(us.sample("walk"))
    with pytest.raises(InvalidValue, match=r"walk: moves at 1\.32 m/s"):
        likeness(walk)
    found = likeness(walk, speed=2.5)
    assert found.figures["flight_s"].inside is False
    assert "Walks or shuffles" in statement(found)
    with pytest.raises(InvalidValue, match="no whole cycle"):
        likeness(gait_of(us.sample("walk").trimmed(0.0, 0.5)))


def test_the_phase_plot_is_a_closed_loop_of_knee_over_hip() -> None:
    chart = phase_chart((likeness(average_runner()),))
    mine, theirs = chart.series
    assert np.allclose(mine.x, theirs.x) and np.allclose(mine.y, theirs.y)
    assert mine.x[0] == pytest.approx(mine.x[-1]) and mine.y[0] == pytest.approx(mine.y[-1])


def test_a_gait_has_one_place_in_every_chart() -> None:
    found = tuple(likeness(average_runner(name=name)) for name in ("run", "other"))
    for chart in running_charts(found):
        assert [chart.series[k].name for k in (0, 2)] == ["run", "other"], chart.title
        assert "people" in chart.series[1].name


def test_the_page_shows_the_run_people_and_the_others(tmp_path: Path) -> None:
    run, other = average_runner(name="my <run>"), average_runner(name="captured", bent=5.0)
    page = running_page(run, beside=[other])
    assert "my &lt;run&gt;" in page and "my <run>" not in page
    for text in ("captured (people at 3.5 m/s)", "Hip and knee", "Fukuchi", "Upward force", "20 N"):
        assert text in page, text
    assert "http" not in page.replace("http-equiv", "")
    write_running(run, tmp_path / "run.html", beside=[other])
    assert (tmp_path / "run.html").read_text("utf-8") == page


def test_the_json_holds_what_the_page_says(tmp_path: Path) -> None:
    run = average_runner()
    write_running(run, tmp_path / "run.json", beside=[average_runner(bent=5.0)])
    read = json.loads((tmp_path / "run.json").read_text("utf-8"))
    assert read == json.loads(json.dumps(running_data(run, beside=[average_runner(bent=5.0)])))
    assert read["kind"] == "understudy running" and len(read["beside"]) == 1
    assert len(read["run"]["gait"]["curves_deg"]["knee"]) == 101
    assert {row["name"] for row in read["run"]["curves"]} >= {"hip", "knee", "ankle"}


def test_other_files_and_too_many_gaits_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match=r"\.html or \.json"):
        write_running(average_runner(), tmp_path / "run.txt")
    with pytest.raises(InvalidValue, match="told apart"):
        running_page(average_runner(), beside=[average_runner()] * 4)


@pytest.mark.clips
def test_captured_runs_stand_beside_a_run(clips: Path) -> None:
    paths = ("cmu_bvh/02_03.bvh", "cmu_bvh/35_17.bvh", "cmu_asfamc/127_03.amc")
    others = [gait_of(us.read(clips / path)) for path in paths]
    page = running_page(average_runner(), beside=others)
    assert "127_03 speeds up by" in page
    for one in others[:2]:
        found = likeness(one)
        assert found.curves["hip"].correlation > 0.90
        assert found.curves["knee"].correlation > 0.90


def test_the_run_is_held_against_every_motion_beside_it():
    run, other = average_runner(), average_runner(bent=5.0, name="bent")
    found = running_data(run, beside=[other])
    (one,) = found["beside"]
    curves = {match["name"]: match for match in one["with_run"]}
    assert curves["knee"]["correlation"] == pytest.approx(1.0)
    assert curves["knee"]["offset_deg"] == pytest.approx(-5.0)
    assert set(curves) == set(run.cycles[0].curves)
    page = running_page(run, beside=[other])
    assert "The curves of average against the others" in page
    assert "against the others&" not in running_page(run)
