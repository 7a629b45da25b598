"""A walking body that nothing holds: it stays up, again and again, bit for bit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import understudy as us
from understudy.control import Guidance, Push, Upright
from understudy.errors import InvalidValue, NotFound, UnderstudyError
from understudy.free_tracking import Effort, freed, track
from understudy.free_tracking.checkpoint import save
from understudy.free_tracking.free import FREE, STEP
from understudy.free_tracking.relay import Relay
from understudy.motion.clip import Clip
from understudy.performance import Performance, tracked
from understudy.simulate import open_loop_controls, prepared, simulate
from understudy.simulate.gears import STATE, rollout
from understudy.take import Take

# As little as tells something: a step of a walk.
SMALL = Effort(children=70, elites=40)


@pytest.fixture(scope="module")
def clip() -> Clip:
    return us.sample("walk").trimmed(1.0, 1.6)


@pytest.fixture(scope="module")
def servos(clip: Clip) -> Performance:
    character = us.Character.from_clip(clip)
    return tracked(clip, character, pelvis="free", timestep=STEP, **FREE)


@pytest.fixture(scope="module")
def take(clip: Clip) -> Take:
    return track(clip, us.Character.from_clip(clip), pelvis="free", effort=SMALL, threads=2)


def guidance_of(performance: Performance) -> Guidance:
    (one,) = (c for c in performance.controllers if isinstance(c, Guidance))
    return one


def test_nothing_holds_the_body_and_it_walks(take: Take) -> None:
    score = us.score(take)
    assert score.fully_physical
    assert score.fell_s is None
    assert score.joint_error_deg is not None and score.joint_error_deg < 5.0
    assert score.joint_position_mm is not None and score.joint_position_mm < 40.0
    assert take.facts["guidance"]["help_percent"] == 0.0
    assert take.facts["torque_limits"] == "human"


def test_no_joint_is_stronger_than_a_person(take: Take) -> None:
    model, part = take.model, take.scene.parts[0]
    servos = list(part.joint_actuators)
    data_of = us.score(take).torque_peaks_nm
    for servo, name in zip(servos, list(data_of), strict=True):
        limit = model.actuator_forcerange[servo].max()
        assert data_of[name] < 1.25 * limit, name


def test_controls_replay_bitwise_open_loop(take: Take) -> None:
    from understudy.control import Controls

    assert take.performance is not None
    model, data = prepared(take.performance)
    states = np.empty((take.frames, 1 + model.nq + model.nv))
    states[0, 0] = 0.0
    states[0, 1:] = np.concatenate((data.qpos, data.qvel))
    block = Controls(np.array(take.ctrl[:-1]), np.array(take.qfrc_applied[:-1]))
    assert STATE
    for _ in rollout(model, data, block, states):
        pass
    assert np.array_equal(states[:, 1 : 1 + model.nq], take.qpos)


def test_feedback_is_silent_on_the_plan(take: Take) -> None:
    assert take.performance is not None
    *others, one = take.performance.controllers
    assert isinstance(one, Guidance)
    silent = replace(take.performance, controllers=(*others, replace(one, gains=one.gains[:0])))
    assert np.array_equal(simulate(silent).qpos, take.qpos)


def test_feedback_brings_a_pushed_body_back(take: Take) -> None:
    assert take.performance is not None
    *others, one = take.performance.controllers
    assert isinstance(one, Guidance)
    off = {}
    for name, own in (("with", one), ("without", replace(one, gains=one.gains[:0]))):
        ends = []
        for impulse in ((6.0, 0.0, 0.0), (-6.0, 0.0, 0.0), (0.0, 6.0, 0.0), (0.0, -6.0, 0.0)):
            push = Push(time=0.05, on="pelvis", impulse=impulse)
            pushed = replace(take.performance, controllers=(*others, own, push))
            end = simulate(pushed)
            place, speed = end.qpos[-1] - take.qpos[-1], end.qvel[-1] - take.qvel[-1]
            ends.append(np.linalg.norm(place[:2] + speed[:2] / 3.3))  # where it is going to be
        off[name] = np.mean(ends)
    assert off["with"] < 0.8 * off["without"]


def test_one_thread_or_two_find_the_same(servos: Performance, take: Take) -> None:
    alone = guidance_of(freed(servos, effort=SMALL, threads=1))
    assert take.performance is not None
    other = guidance_of(take.performance)
    assert np.array_equal(alone.offsets, other.offsets)
    assert np.array_equal(alone.gains, other.gains)


def test_a_stopped_search_goes_on_where_it_was(
    servos: Performance, take: Take, tmp_path: Path
) -> None:
    file = tmp_path / "search.npz"
    with pytest.raises(NotFound, match="No pass of the search"):
        freed(servos, effort=SMALL, checkpoint=file, budget=0.0)
    first = replace(SMALL, passes=1)
    relay = Relay(servos, effort=SMALL)
    next(iter(relay.passes()))
    save(relay, file)
    resumed = guidance_of(freed(servos, effort=SMALL, checkpoint=file))
    assert take.performance is not None
    assert np.array_equal(resumed.offsets, guidance_of(take.performance).offsets)
    with pytest.raises(UnderstudyError, match="belongs to another search"):
        freed(servos, effort=first, checkpoint=file)
    file.write_text("nothing of the kind")
    with pytest.raises(UnderstudyError, match="is not a checkpoint"):
        freed(servos, effort=SMALL, checkpoint=file)


@pytest.mark.parametrize("seed", [-1, 1.5, True])
def test_a_seed_is_a_whole_number_from_0_on(servos: Performance, seed: int) -> None:
    with pytest.raises(InvalidValue, match=f"seed is {seed}; it must be a whole number"):
        freed(servos, seed=seed)


def test_one_frame_is_nothing_to_perform(clip: Clip) -> None:
    with pytest.raises(InvalidValue, match="must have at least 2"):
        track(clip.trimmed(0.0, 0.001), us.Character.from_clip(clip), pelvis="free")


def test_where_no_run_comes_to_the_end_the_farthest_is_kept(
    clip: Clip, servos: Performance, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from understudy.free_tracking.passes import OnePass

    least, file = OnePass.reached, tmp_path / "search.npz"
    monkeypatch.setattr(OnePass, "reached", property(lambda one: min(10, least.fget(one))))  # type: ignore
    once = replace(SMALL, passes=1)
    found = freed(servos, effort=once, checkpoint=file)
    assert 0.5 <= found.duration <= clip.duration
    resumed = freed(servos, effort=once, checkpoint=file)
    assert np.array_equal(guidance_of(resumed).offsets, guidance_of(found).offsets)
    take = simulate(found)
    score = us.score(take)
    assert score.joint_position_mm is not None and score.joint_position_mm < 100.0


def test_a_loaded_take_is_performed_again(take: Take, tmp_path: Path) -> None:
    us.write(take, tmp_path / "walk.take.npz")
    read = us.load_take(tmp_path / "walk.take.npz")
    assert read.performance is not None
    assert np.array_equal(simulate(read.performance).qpos, take.qpos)


def test_only_a_free_pelvis_without_tasks_is_searched(servos: Performance) -> None:
    upright = replace(servos, controllers=(*servos.controllers, Upright()))
    with pytest.raises(InvalidValue, match="has a Upright"):
        freed(upright)
    (tracking,) = servos.controllers
    held = replace(servos, controllers=(replace(tracking, pelvis="assisted"),))  # type: ignore[call-arg]
    with pytest.raises(InvalidValue, match="The pelvis is held"):
        freed(held)


def test_other_pelvises_are_tracked_as_ever(clip: Clip) -> None:
    take = us.track(clip, us.Character.from_clip(clip))
    assert take.facts["pelvis"] == "assisted"
    model, _ = prepared(take.performance)  # type: ignore[arg-type]
    assert np.array_equal(open_loop_controls(take.performance, model).ctrl, take.ctrl[:-1])  # type: ignore[arg-type]


def test_a_take_saved_again_is_the_same_file(take: Take, tmp_path: Path) -> None:
    us.write(take, tmp_path / "once.take.npz")
    us.write(us.load_take(tmp_path / "once.take.npz"), tmp_path / "twice.take.npz")
    assert (tmp_path / "once.take.npz").read_bytes() == (tmp_path / "twice.take.npz").read_bytes()
