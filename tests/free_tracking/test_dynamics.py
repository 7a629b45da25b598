"""Fits find linear systems, and the regulator is the best there is for them."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.control.guidance_law import DEVIATION
from understudy.free_tracking.dynamics import Dynamics, Moments, prior, regulator

AXES = 4


def system(rng: np.random.Generator) -> Dynamics:
    a = 0.3 * rng.standard_normal((DEVIATION, DEVIATION + AXES))
    b, c = rng.standard_normal((DEVIATION, AXES)), rng.standard_normal(DEVIATION)
    return Dynamics(a, b, c)


def test_fit_finds_a_linear_system_and_leaves_help_out() -> None:
    rng = np.random.default_rng(0)
    true, more = system(rng), rng.standard_normal((DEVIATION, 6))
    z = rng.standard_normal((400, DEVIATION + AXES))
    a, held = rng.standard_normal((400, AXES)), rng.standard_normal((400, 6))
    x = z @ true.state.T + a @ true.offsets.T + held @ more.T + true.rest
    nothing = Dynamics(*(np.zeros_like(part) for part in true))
    found = Dynamics.fitted(Moments.of(z, a, held, x, nothing), nothing, 4e-7)
    for one, other in zip(found, true, strict=True):
        assert one == pytest.approx(other, abs=1e-5)


def test_without_samples_in_a_direction_the_prior_stays() -> None:
    rng = np.random.default_rng(1)
    known = prior(AXES, 0.05, np.ones(DEVIATION))
    z = np.zeros((50, DEVIATION + AXES))
    a = rng.standard_normal((50, AXES))
    x = a @ rng.standard_normal((AXES, DEVIATION))
    found = Dynamics.fitted(Moments.of(z, a, np.zeros((50, 6)), x, known), known, 0.3)
    assert found.state == pytest.approx(known.state)


def test_prior_moves_places_by_velocities() -> None:
    scales = np.linspace(0.5, 2.0, DEVIATION)
    off = np.zeros(DEVIATION)
    off[3] = 1.0 / scales[3]  # 1 m/s
    after = prior(0, 0.05, scales).state @ off
    assert after[0] * scales[0] == pytest.approx(0.05)


def test_regulator_is_the_optimum_of_the_whole_problem() -> None:
    rng = np.random.default_rng(2)
    dynamics = [system(rng) for _ in range(3)]
    cost = np.diag(rng.uniform(0.5, 2.0, DEVIATION))
    effort, change = rng.uniform(0.1, 1.0, AXES), rng.uniform(0.1, 1.0, AXES)
    gains, values = regulator(dynamics, cost, effort, change)
    start = rng.standard_normal(DEVIATION + AXES)

    def total(plan: np.ndarray | None) -> tuple[float, np.ndarray]:
        z, out, chosen = start, start[:DEVIATION] @ cost @ start[:DEVIATION], []
        for w, one in enumerate(dynamics):
            last = 5.0 if w == 2 else 1.0
            gain = gains[w]
            assert gain is not None
            a = gain[:, :-1] @ z + gain[:, -1] if plan is None else plan[w]
            x = one.state @ z + one.offsets @ a + one.rest
            out += effort @ a**2 + change @ (a - z[DEVIATION:]) ** 2 + last * x @ cost @ x
            z = np.concatenate((x, a))
            chosen.append(a)
        return float(out), np.array(chosen)

    least, plan = total(None)
    z = np.append(start, 1.0)
    assert z @ values[0] @ z == pytest.approx(least)
    for _ in range(20):
        assert total(plan + 0.01 * rng.standard_normal(plan.shape))[0] > least


def test_a_window_nothing_is_known_of_has_no_gain() -> None:
    rng = np.random.default_rng(3)
    cost = np.eye(DEVIATION)
    gains, values = regulator([system(rng), None], cost, np.ones(AXES), np.ones(AXES))
    assert gains[0] is not None and gains[1] is None
    assert values[1] == pytest.approx(values[2])
