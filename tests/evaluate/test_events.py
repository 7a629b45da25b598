"""Contact events against closed forms: what fell, bounced, rested and was hit."""

from __future__ import annotations

import copy
import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from touching_scenes import Fixed, Loose, played

from understudy.errors import InvalidValue, UnknownName
from understudy.evaluate import contact_events, contact_force, measured, overlap
from understudy.evaluate.events import ContactEvent
from understudy.scene import Ground

G = 9.81
TABLE = Fixed(name="table", position=(3.0, 0.0, 0.5))
TOP = 0.6


def bouncing(**changes: Any) -> Any:
    """A ball of 2 kg that falls 0.2 m on a table and bounces."""
    settings = {"position": (3.0, 0.0, TOP + 0.3), "solref": (0.02, 0.1), **changes}
    return played(TABLE, Loose(name="ball", **settings), seconds=1.0)


@pytest.fixture(scope="module")
def bounces() -> Any:
    return bouncing()


@pytest.fixture(scope="module")
def resting() -> Any:
    box = Loose(name="box", position=(3.0, 0.0, 0.0999), size=(0.2, 0.2, 0.1), mass=5.0)
    return played(box, ground=Ground(), seconds=1.0)


def speed(take: Any, name: str, time: float) -> np.ndarray:
    """Velocity of a loose prop at the step nearest a time [m/s]."""
    first = take.model.joint(take.model.body(name).jntadr[0]).dofadr[0]
    return take.qvel[int(np.argmin(np.abs(take.times - time))), first : first + 3]


def test_impulse_of_a_bounce_is_its_change_of_momentum_and_the_weight_meanwhile(
    bounces: Any,
) -> None:
    first, second, *_ = contact_events(bounces, "ball", "table")
    for event in (first, second):
        gained = speed(bounces, "ball", event.end_s) - speed(bounces, "ball", event.start_s)
        expected = 2.0 * gained + np.array([0, 0, 2.0 * G * event.duration_s])
        assert np.allclose(event.impulse, expected, atol=1e-6 * np.linalg.norm(expected))
        assert event.impulse_ns == pytest.approx(np.linalg.norm(event.impulse))


def test_first_bounce_begins_when_the_fall_ends(bounces: Any) -> None:
    first = contact_events(bounces, "ball", "table")[0]
    assert first.start_s == pytest.approx(np.sqrt(2 * 0.2 / G), abs=2e-3)
    assert first.approach_m_s == pytest.approx(np.sqrt(2 * G * 0.2), rel=0.01)
    assert first.position == pytest.approx([3.0, 0.0, TOP], abs=0.01)


def test_a_ball_flies_freely_between_two_bounces(bounces: Any) -> None:
    first, second, *_ = contact_events(bounces, "ball", "table")
    leaving = speed(bounces, "ball", first.end_s)[2]
    assert leaving > 0.5
    assert second.start_s - first.end_s == pytest.approx(2 * leaving / G, abs=5e-3)


def test_impulses_of_all_events_are_the_whole_change_of_momentum(bounces: Any) -> None:
    total = sum((e.impulse for e in contact_events(bounces, "ball")), np.zeros(3))
    gained = 2.0 * (speed(bounces, "ball", 99.0) - speed(bounces, "ball", 0.0))
    weight = np.array([0.0, 0.0, 2.0 * G * bounces.duration])
    assert np.allclose(total, gained + weight, atol=1e-5)


def test_force_of_a_resting_body_is_its_weight(resting: Any) -> None:
    force = contact_force(resting, "box", "ground")
    assert np.allclose(force[resting.times > 0.5], [0.0, 0.0, 5.0 * G], atol=0.05)
    (event,) = contact_events(resting, "box", "ground")
    settled = resting.duration - event.start_s
    assert event.impulse[2] == pytest.approx(5.0 * G * settled, rel=0.01)
    assert event.start_s + event.duration_s == pytest.approx(resting.duration)


def test_force_on_the_one_is_opposite_to_that_on_the_other(bounces: Any) -> None:
    on_ball = contact_events(bounces, "ball", "table")
    on_table = contact_events(bounces, "table", "ball")
    assert [e.between for e in on_table[:1]] == [("table", "ball")]
    for one, two in zip(on_ball, on_table, strict=True):
        assert np.allclose(one.impulse, -two.impulse)
        assert one.impulse_ns == two.impulse_ns
    assert contact_events(bounces, second="ball") == contact_events(bounces, "ball")


def test_two_that_collide_swap_the_same_momentum() -> None:
    ground = Ground(friction=0.0)
    balls = (
        Loose(name="left", position=(3.0, 0.0, 0.6), velocity=(2.0, 0.0, 0.0), mass=1.0),
        Loose(name="right", position=(3.5, 0.0, 0.6), mass=3.0),
    )
    take = played(*balls, ground=ground, seconds=0.3)
    (event,) = contact_events(take, "left", "right")
    for name, mass, sign in (("left", 1.0, 1.0), ("right", 3.0, -1.0)):
        gained = mass * (speed(take, name, event.end_s) - speed(take, name, event.start_s))
        fallen = np.array([0.0, 0.0, mass * G * event.duration_s])
        assert np.allclose(gained + fallen, sign * event.impulse, atol=1e-5)
    assert event.approach_m_s == pytest.approx(2.0, rel=1e-3)


def test_shapes_of_a_prop_count_as_one(bounces: Any) -> None:
    # The ball lands on the seam between the table's two halves: two contact points.
    m = measured(bounces)
    frames, counts = np.unique(m.contacts.frame, return_counts=True)
    assert counts.max() == 2 and len(frames)
    assert {e.between for e in contact_events(m)} == {("table", "ball")}


def test_gap_joins_touches_that_are_closer(bounces: Any) -> None:
    raw = contact_events(bounces, "ball", "table", gap=0.0)
    apart = [b.start_s - a.end_s for a, b in itertools.pairwise(raw)]
    assert len(raw) >= 3
    joined = contact_events(bounces, "ball", "table", gap=max(apart) + 1e-3)
    assert len(joined) == 1 and joined[0].touches == len(raw)
    assert joined[0].impulse_ns == pytest.approx(sum(e.impulse_ns for e in raw), rel=1e-6)
    assert joined[0].duration_s == pytest.approx(raw[-1].end_s - raw[0].start_s)
    kept = contact_events(bounces, "ball", "table", gap=apart[0])
    assert kept[0] == raw[0]  # a gap of just that length parts them
    assert joined[0].peak_force_n == max(e.peak_force_n for e in raw)
    assert joined[0].approach_m_s == raw[0].approach_m_s


def test_penetration_of_an_event_is_the_overlap_of_the_poses(bounces: Any) -> None:
    depth = overlap(bounces, "ball", "table")
    for event in contact_events(bounces, "ball", "table", gap=0.0)[:2]:
        during = (bounces.times >= event.start_s) & (bounces.times < event.end_s)
        assert 1e3 * depth[during].max() == pytest.approx(event.penetration_mm, rel=1e-6)
    assert depth[bounces.times < 0.19].max() == 0.0


def test_overlap_needs_no_collision(bounces: Any) -> None:
    model = copy.copy(bounces.model)
    model.geom_contype[:] = 0
    states = bounces.qpos.copy()
    height = model.jnt_qposadr[model.body("ball").jntadr[0]] + 2
    states[:, height] = TOP + 0.1 - np.linspace(-0.05, 0.05, len(states))
    through = replace(bounces, model=model, qpos=states)
    assert contact_events(through) == ()
    depth = overlap(through, "table", "ball", rate=100.0)
    assert depth == pytest.approx(np.maximum(np.linspace(-0.05, 0.05, 101), 0.0), abs=1e-6)


def test_events_come_in_order_of_time(bounces: Any) -> None:
    starts = [e.start_s for e in contact_events(bounces, gap=0.0)]
    assert starts == sorted(starts)


@pytest.mark.parametrize("names", [("bal",), ("ball", "tabel")])
def test_unknown_names_are_refused_with_the_nearest(bounces: Any, names: tuple[str, ...]) -> None:
    with pytest.raises(UnknownName, match=r"Did you mean '(ball|table)'"):
        contact_events(bounces, *names)
    with pytest.raises(UnknownName):
        contact_force(bounces, *names)


def test_a_thing_does_not_touch_itself(bounces: Any) -> None:
    for call in (contact_events, overlap):
        with pytest.raises(InvalidValue, match="two things"):
            call(bounces, "ball", "ball")
    with pytest.raises(InvalidValue, match="gap"):
        contact_events(bounces, gap=-0.1)


def test_names_are_of_links_props_and_ground(bounces: Any, resting: Any) -> None:
    assert measured(bounces).owners.names == ("block", "rod1", "table", "ball", "world")
    assert measured(resting).owners.names == ("block", "rod1", "box", "ground", "world")
    assert contact_events(resting)[0].between == ("box", "ground")
    assert contact_events(resting, "rod1") == ()


def test_an_event_is_plain_values(bounces: Any) -> None:
    event = contact_events(bounces, "ball")[0]
    assert isinstance(event, ContactEvent)
    found = event.as_dict()
    assert found["between"] == ["ball", "table"]
    assert found["impulse_world_ns"][2] == pytest.approx(found["impulse_ns"], rel=1e-6)
    with pytest.raises(ValueError, match="read-only"):
        event.impulse[0] = 1.0


def test_impulse_hardly_depends_on_the_step() -> None:
    sizes = [
        contact_events(
            played(
                TABLE,
                Loose(position=(3.0, 0.0, TOP + 0.3), solref=(0.02, 0.1)),
                seconds=0.3,
                timestep=step,
            )
        )[0].impulse_ns
        for step in (0.0005, 0.001, 0.002)
    ]
    assert max(sizes) < 1.1 * min(sizes)
