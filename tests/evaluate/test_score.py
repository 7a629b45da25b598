from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_takes import STEP, body_spec, simulated

from understudy.evaluate import certificate, measured, score, write_certificate
from understudy.evaluate.certificate import SCHEMA, statement, verdict
from understudy.evaluate.feet import kinematic_slide
from understudy.evaluate.score import Score, motion
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip


def dragged(speed: float) -> Any:
    """A foot pulled along the ground at constant speed."""

    def pull(time: float, data: Any) -> None:
        data.ctrl[4], data.ctrl[5] = speed * time, speed
        data.ctrl[8] = 0.199

    spec = body_spec(foot=True, servo=2e4, hold=3e5)
    return simulated(spec, 1.5, qpos=[0, 0, 0.198], qvel=[speed], control=pull, foot=True)


def test_foot_slide_is_the_speed_of_a_dragged_foot() -> None:
    s = score(dragged(0.2))
    assert s.foot_slide_mm_s == pytest.approx(200.0, rel=0.02)
    assert s.foot_slide_by_height_mm_s == pytest.approx(200.0, rel=0.02)


def test_a_foot_at_rest_does_not_slide() -> None:
    s = score(dragged(0.0))
    assert s.foot_slide_mm_s is not None and s.foot_slide_mm_s < 1.0


def test_a_foot_in_swing_does_not_count_as_sliding() -> None:
    take = dragged(0.0)
    m = measured(take)
    standing = motion(take, m)
    away = standing.root_positions + np.array([0.0, 0.0, 0.1])
    lifted = Clip(
        skeleton=standing.skeleton,
        rotations=standing.rotations,
        root_positions=away + np.linspace(0, 3.0, standing.frames)[:, None] * [1.0, 0, 0],
        rate=standing.rate,
    )
    assert kinematic_slide(lifted, m.performer(), take.model).speed is None


def test_penetration_is_the_deepest_overlap(standing: Any) -> None:
    s = score(standing)
    low = 0.05 - standing.qpos[::4, 2].min()
    assert s.penetration_mm == pytest.approx(1e3 * low, abs=0.2)


def test_free_body_is_fully_physical(standing: Any) -> None:
    s = score(standing)
    assert s.pelvis == "free"
    assert s.root_force_peak_percent == 0.0
    assert s.fully_physical
    assert "fully physical, no force on the root" in statement(s)


def test_hung_body_carries_all_its_weight_at_the_root() -> None:
    s = score(simulated(body_spec(ground=False, hold=5000.0, servo=200.0), 3.0))
    assert s.root_support_percent == pytest.approx(100.0, rel=0.05)
    assert s.pelvis == "assisted"
    assert not s.fully_physical
    assert "not fully physical" in statement(s)
    assert s.flight_s is None and s.foot_slide_mm_s is None


def test_led_pelvis_says_so() -> None:
    take = simulated(body_spec(ground=False, hold=5000.0), 0.5, pelvis="led")
    s = score(take)
    assert s.pelvis == "led"
    assert statement(s).startswith("The pelvis is led along the clip by an outside force of")


def test_playback_of_the_reference_has_no_error(standing: Any) -> None:
    take = simulated(body_spec(servo=200.0), 0.5, qpos=[0, 0, 0.05])
    clip = Clip(
        skeleton=take.scene.characters[0].skeleton,
        rotations=take.qpos[:, 3:].reshape(len(take.qpos), -1, 4),
        root_positions=take.qpos[:, :3],
        rate=take.rate,
        name="itself",
    )
    take.references = (clip,)
    s = score(take)
    assert s.clip == "itself"
    assert s.joint_error_deg == pytest.approx(0.0, abs=1e-5)
    assert s.joint_position_mm == pytest.approx(0.0, abs=1e-5)
    assert s.root_position_mm == pytest.approx(0.0, abs=1e-9)


def test_a_body_far_below_its_clip_has_fallen() -> None:
    take = simulated(body_spec(ground=False), 1.0)
    clip = Clip(
        skeleton=take.scene.characters[0].skeleton,
        rotations=np.tile([1.0, 0, 0, 0], (101, 2, 1)),
        root_positions=np.zeros((101, 3)),
        rate=100.0,
    )
    take.references = (clip,)
    s = score(take)
    # Free fall by 0.2 m takes sqrt(2 h / g).
    assert s.fell_s == pytest.approx(np.sqrt(2 * 0.2 / 9.81), abs=0.01)
    assert "lost its balance" in statement(s)
    assert s.fully_physical
    assert statement(s).startswith("It fell at 0.2")
    assert "fully physical" not in statement(s).lower()
    assert verdict(s).startswith("It fell at 0.2")


def held(**changes: Any) -> Score:
    """The score of a body on a floor, helped by a little force."""
    usual = {
        "character": "box",
        "duration_s": 10.0,
        "frame_rate_hz": 100.0,
        "pelvis": "assisted",
        "root_force_mean_percent": 3.0,
        "root_force_peak_percent": 9.0,
        "flight_s": 0.5,
    }
    return Score(**(usual | changes))


def test_a_clip_off_the_floor_is_said_to_be_off_the_floor() -> None:
    assert "floor" not in statement(held())
    said = statement(held(flight_s=8.6, root_support_percent=80.0))
    assert "leaves the floor for 8.6 s of 10.0 s: its height drifts" in said
    assert "not in the scene" in said
    assert "4.0 s of 10.0 s: it jumps, its height drifts" in statement(held(flight_s=4.0))


def test_a_root_that_carries_much_weight_is_explained() -> None:
    assert "The feet carry" not in statement(held(root_support_percent=15.0))
    assert "The feet carry only 70 % of the weight" in statement(held(root_support_percent=30.0))


def test_a_body_without_a_floor_is_not_said_to_leave_it() -> None:
    said = statement(held(flight_s=None, pelvis="led", root_support_percent=100.0))
    assert "floor" not in said and "feet" not in said


def test_the_furthest_joint_is_named_with_its_time() -> None:
    far = {"joint_error_peak_joint": "left_ball", "joint_error_peak_s": 2.5}
    assert "Furthest" not in statement(held(joint_error_peak_deg=44.0, **far))
    assert "Furthest from the clip: ball of left foot, 61 degrees at 2.50 s." in statement(
        held(joint_error_peak_deg=61.0, **far)
    )
    assert "left_ball at 2.50 s" in str(held(joint_error_peak_deg=61.0, **far))


def test_the_peak_error_is_where_and_when_the_joint_was_furthest(standing: Any) -> None:
    take = simulated(body_spec(servo=200.0), 0.5, qpos=[0, 0, 0.05])
    turned = np.array(take.qpos[:, 3:].reshape(len(take.qpos), -1, 4))
    turned[100, 1] = rot.multiply(rot.from_rotvec(np.array([1.2, 0.0, 0.0])), turned[100, 1])
    take.references = (
        Clip(
            skeleton=take.scene.characters[0].skeleton,
            rotations=turned,
            root_positions=take.qpos[:, :3],
            rate=take.rate,
        ),
    )
    s = score(take)
    assert s.joint_error_peak_deg == pytest.approx(np.degrees(1.2), rel=1e-3)
    assert s.joint_error_peak_joint == "shoulder"
    assert s.joint_error_peak_s == pytest.approx(take.times[100])


def test_torque_is_compared_with_human_strength() -> None:
    def press(time: float, data: Any) -> None:
        data.qfrc_applied[6:9] = [25.0, 25.0, 0.0]

    s = score(simulated(body_spec(ground=False), 3 * STEP, control=press))
    # 25 of 50 N m about x is the nearest to a limit; 25 of 100 about y is not.
    assert s.strength_percent["shoulder"] == pytest.approx(50.0)
    assert s.torque_peak_joint == "shoulder"
    assert s.torque_peak_nm == pytest.approx(np.hypot(25.0, 25.0))


def test_score_prints_a_short_table(standing: Any) -> None:
    text = str(score(standing))
    assert len(text.splitlines()) < 20
    assert "pelvis free" in text and "% of body weight" in text
    assert all(len(line) < 100 for line in text.splitlines())
    assert "joint error" not in text  # no clip was tracked


def test_every_number_of_a_score_is_documented() -> None:
    page = (Path(__file__).parents[2] / "docs" / "evaluation.md").read_text()
    missing = [f.name for f in fields(Score) if f"`{f.name}`" not in page]
    assert not missing


def test_certificate_is_json_and_names_its_schema(standing: Any, tmp_path: Path) -> None:
    write_certificate(standing, tmp_path / "take.json")
    read = json.loads((tmp_path / "take.json").read_text())
    assert read["kind"] == "understudy certificate"
    assert read["schema"] == SCHEMA == 2
    assert read["seed"] == 7
    assert read["fully_physical"] is True
    assert set(read["versions"]) == {"understudy", "mujoco", "numpy", "python"}
    assert read["characters"][0]["root_force_mean_percent"] == 0.0


def test_certificate_keys_do_not_change_without_a_new_schema(standing: Any) -> None:
    made = certificate(standing)
    assert {
        "kind",
        "schema",
        "statement",
        "fully_physical",
        "duration_s",
        "step_s",
        "diverged_s",
        "real_time_factor",
        "seed",
        "versions",
        "facts",
        "characters",
    } <= set(made)


def test_certificate_takes_facts_of_any_kind(standing: Any) -> None:
    standing.facts.update(gains=np.arange(3.0), count=np.int64(2), where=Path("x"))
    try:
        facts = certificate(standing)["facts"]
    finally:
        standing.facts.clear()
    assert facts == {"gains": [0.0, 1.0, 2.0], "count": 2, "where": "x"}


def test_diverged_take_says_when(standing: Any) -> None:
    standing.diverged = 0.25
    try:
        assert "diverged at 0.250 s" in certificate(standing)["statement"]
    finally:
        standing.diverged = None
