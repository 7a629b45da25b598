"""Two characters in one scene: certificate, report and score tell them apart."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bodies import still
from understudy.character.bodies import adult_woman
from understudy.control import Tracking
from understudy.evaluate import certificate, contact_events, measured, score
from understudy.evaluate.plots import all_charts
from understudy.performance import Performance
from understudy.report import report_html
from understudy.scene import Ball, Scene
from understudy.simulate import simulate

AWAY = 1.5


@pytest.fixture(scope="module")
def pair() -> Any:
    """Two women stand side by side; a ball falls on the second one's head."""
    woman = adult_woman()
    here = still(woman, seconds=0.6)
    there = replace(here, root_positions=here.root_positions + np.array([AWAY, 0.0, 0.0]))
    ball = Ball(position=(AWAY, 0.0, woman.height + 0.3), mass=0.5)
    scene = Scene(characters=(woman, woman), props=(ball,), contacts=(("b/head", "ball"),))
    controllers = (
        Tracking(reference=here, captured=here, pelvis="assisted"),
        Tracking(reference=there, captured=there, character=1, pelvis="assisted"),
    )
    return simulate(Performance(scene=scene, controllers=controllers, duration=0.6))


def test_each_has_the_score_it_would_have_alone(pair: Any) -> None:
    m = measured(pair)
    first, second = (score(pair, character=k, measures=m) for k in (0, 1))
    woman = pair.scene.characters[0]
    alone = simulate(
        Performance(
            scene=Scene(characters=(woman,), timestep=pair.scene.timestep),
            controllers=(Tracking(reference=pair.references[0], pelvis="assisted"),),
            duration=0.6,
        )
    )
    single = score(alone)
    for name in ("joint_error_deg", "ground_force_mean_percent", "root_force_mean_percent"):
        assert getattr(first, name) == pytest.approx(getattr(single, name), rel=1e-3, abs=1e-6)
    # The second carries the ball for a moment.
    assert second.ground_force_peak_percent != pytest.approx(single.ground_force_peak_percent)
    assert [p.weight for p in m.performers] == pytest.approx([woman.mass * 9.81] * 2, rel=1e-3)


def test_each_ones_contacts_are_told_apart(pair: Any) -> None:
    m = measured(pair)
    assert {e.between for e in contact_events(m, "ball")} == {("ball", "b/head")}
    assert contact_events(m, "b/head", "ball")[0].start_s > 0.1
    assert contact_events(m, "head") == ()
    standing = {e.between[1].removeprefix("b/") for e in contact_events(m, "ground")}
    assert standing <= {"left_foot", "right_foot", "left_toes", "right_toes", "ball"}


def test_certificate_has_both(pair: Any) -> None:
    found = json.loads(json.dumps(certificate(pair), allow_nan=False))
    assert [c["prefix"] for c in found["characters"]] == ["", "b/"]
    name = pair.scene.characters[0].name
    assert found["statement"].startswith(f"{name} (a): ") and f" {name} (b): " in found["statement"]
    feet = {foot["foot"] for foot in found["feet_on_ground"]}
    assert feet == {"left_foot", "right_foot", "b/left_foot", "b/right_foot"}
    assert {tuple(c["between"]) for c in found["contacts"]} == {("b/head", "ball")}
    assert found["contacts_in_all"] == len(found["contacts"])
    impulse = np.array(found["contacts"][0]["impulse_world_ns"])
    assert impulse[2] < -0.5  # the head is pressed down


def test_report_has_both_and_the_events_once(pair: Any) -> None:
    page = report_html(pair)
    assert page.count("Help from outside") == 2
    assert page.count('<section id="contact-events">') == 1
    assert "b/head - ball" in page and "b/left foot" in page
    name = pair.scene.characters[0].name
    assert f"{name} (a): still" in page and f"{name} (b): still" in page
    shown = page.split("</iframe>")[1].split("<script>")[0]
    assert "nan" not in shown.split()


def test_both_have_all_charts(pair: Any) -> None:
    m = measured(pair)
    titles = [[chart.title for chart in all_charts(pair, m, k)] for k in (0, 1)]
    assert titles[0] == titles[1] and "Ground reaction" in titles[1]
