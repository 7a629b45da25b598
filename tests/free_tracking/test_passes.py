"""Chance is drawn so that a fit can tell its parts from one another and from what is known."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.free_tracking.passes import telling


def drawn(count: int, axes: int, known: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    return rng.standard_normal((count, axes)), rng.standard_normal((count, known))


def test_telling_chance_is_white_and_has_nothing_of_what_is_known() -> None:
    noise, known = drawn(60, 15, 36)
    out = telling(noise, known)
    assert out.T @ out == pytest.approx(60 * np.eye(15), abs=1e-9)
    assert out.mean(axis=0) == pytest.approx(np.zeros(15), abs=1e-9)
    assert out.T @ known == pytest.approx(np.zeros((15, 36)), abs=1e-9)


def test_it_stays_near_the_chance_it_was_made_of() -> None:
    noise, known = drawn(2000, 5, 3)
    assert telling(noise, known) == pytest.approx(noise, abs=0.3)


def test_children_of_one_parent_tell_as_much() -> None:
    noise, known = drawn(40, 15, 36)
    out = telling(noise, np.repeat(known[:1], 40, axis=0))
    assert out.T @ out == pytest.approx(40 * np.eye(15), abs=1e-9)
    assert np.isfinite(out).all()


def test_too_few_children_keep_their_chance() -> None:
    noise, known = drawn(50, 15, 36)
    assert telling(noise, known) is noise
