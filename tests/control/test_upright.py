"""A staff kept upright through a pump that tilts it, and after a knock."""

from __future__ import annotations

import numpy as np
import pytest

import understudy as us
from understudy.control import Push, Upright
from understudy.motion import rotations as rot
from understudy.scene import Staff


@pytest.fixture(scope="module")
def clip() -> us.Clip:
    return us.sample("staff").trimmed(0.0, 3.0)


@pytest.fixture(scope="module")
def body(clip) -> us.Character:
    return us.Character.from_clip(clip)


def tilt(take: us.Take) -> tuple[np.ndarray, np.ndarray]:
    """Angle of the staff from vertical [deg]."""
    times, _, turned = take.poses(120.0)
    staff = take.model.body("staff").id
    local = rot.rotate(
        rot.conjugate(turned[:, take.model.body("right_hand").id]),
        rot.rotate(turned[:, staff], np.array([0.0, 0.0, 1.0])),
    )
    assert np.ptp(local, axis=0).max() < 1e-9  # it is fixed in the hand
    upward = rot.rotate(turned[:, staff], np.array([0.0, 0.0, 1.0]))[:, 2]
    return times, np.degrees(np.arccos(np.clip(np.abs(upward), -1.0, 1.0)))


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def test_the_staff_stays_upright_through_a_pump_that_tilts_it(clip, body):
    raw = tilt(us.track(clip, body, props=[Staff()]))[1]
    times, kept = tilt(us.track(clip, body, props=[Staff()], tasks=[Upright(ease=0.3)]))
    assert rms(raw) > 8.0
    assert rms(kept[times > 0.7]) < 1.0
    assert kept[times > 0.7].max() < 3.0


def test_the_rest_of_the_body_moves_as_in_the_clip(clip, body):
    take = us.track(clip, body, props=[Staff()], tasks=[Upright()])
    errors = us.score(take).joint_errors_deg
    assert errors.pop("right_wrist") > 5.0
    assert max(errors.values()) < 1.0


def test_a_knock_of_five_newton_seconds_is_recovered_within_a_second(clip, body):
    knock = Push(time=1.2, on="staff", impulse=(3.5, 3.5, 0.0))
    take = us.track(clip, body, props=[Staff(grip=0.35)], tasks=[Upright(), knock])
    times, angle = tilt(take)
    assert angle[(times > 1.2) & (times < 1.6)].max() > 5.0
    assert angle[times > 2.2].max() < 3.0


def test_a_softer_wrist_sways_more(clip, body):
    knock = Push(time=1.2, on="staff", impulse=(3.5, 3.5, 0.0))
    swayed = [
        tilt(us.track(clip, body, props=[Staff(grip=0.35)], tasks=[Upright(stiffness=s), knock]))
        for s in (400.0, 100.0)
    ]
    hard, soft = (angle[times > 1.2].max() for times, angle in swayed)
    assert soft > 1.5 * hard


def test_a_strength_limit_holds_for_the_task_too(clip, body):
    heavy = Staff(mass=6.0, grip=0.2)
    take = us.track(clip, body, props=[heavy], tasks=[Upright()], torque_limits="human")
    limit = float(np.max(body.link("right_wrist").torque_limit))
    part = take.scene.parts[0]
    wrist = [link.joint for link in body.links].index("right_wrist")
    from understudy.evaluate import measured

    torque = measured(take, rate=60.0).joint_torques()[:, wrist - 1]
    assert part.dofs.stop >= 0
    assert np.linalg.norm(torque, axis=1).max() < 1.05 * limit
