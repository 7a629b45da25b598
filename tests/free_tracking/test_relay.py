"""Pieces of a long performance join without a seam, and one that fails is tried again by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import understudy as us
from understudy.control import Guidance
from understudy.control.guidance_law import DEVIATION, HELP, POSTURE
from understudy.free_tracking import Effort, relay
from understudy.free_tracking.checkpoint import restore, save
from understudy.free_tracking.free import FREE, STEP
from understudy.free_tracking.relay import Done, Relay
from understudy.free_tracking.windows import States
from understudy.performance import Performance, tracked
from understudy.simulate import simulate

SMALL = Effort(children=60, elites=40)
EVERY = round(SMALL.window / STEP)


@pytest.fixture(scope="module")
def walk() -> Performance:
    clip = us.sample("walk").trimmed(1.0, 1.5)
    character = us.Character.from_clip(clip)
    return tracked(clip, character, pelvis="free", timestep=STEP, **FREE)


def relay_of(performance: Performance) -> Relay:
    return Relay(performance, effort=SMALL, piece=0.2, ahead=0.1)


@pytest.fixture(scope="module")
def found(walk: Performance) -> Guidance:
    one = relay_of(walk)
    for _ in one.passes():
        pass
    assert one.best is not None
    return one.best


def test_pieces_make_one_guidance_that_is_free(walk: Performance, found: Guidance) -> None:
    assert found.found["pieces"] >= 2
    assert len(found.offsets) == 10
    assert not found.help.any() and found.found["helped"] == []
    take = simulate(replace(walk, controllers=(*walk.controllers, found)))
    assert us.score(take).fell_s is None
    silent = replace(walk, controllers=(*walk.controllers, replace(found, gains=found.gains[:0])))
    assert np.array_equal(simulate(silent).qpos, take.qpos)


def test_a_relay_goes_on_between_pieces_and_within(
    walk: Performance, found: Guidance, tmp_path: Path
) -> None:
    first = relay_of(walk)
    for count, _ in enumerate(first.passes()):
        save(first, tmp_path / f"{count}.npz")
        if count == 4:
            break
    assert first.done is not None
    for file in ("1.npz", "4.npz"):
        second = relay_of(walk)
        restore(second, tmp_path / file)
        for _ in second.passes():
            pass
        assert second.best is not None
        assert np.array_equal(second.best.offsets, found.offsets)
        assert np.array_equal(second.best.gains, found.gains)
        assert second.best.found == found.found


class Scripted:
    """A search that finds what a list says: newtons of help, or None for no way to the end."""

    script: list[float | None]
    tried: list[tuple[int, int]]

    def __init__(self, performance: Performance, *, stretch: Any, **_: Any):
        self.performance, self.model = performance, performance.scene.model
        self.reference = performance.controllers[0].reference  # type: ignore[union-attr]
        self.commands = (np.zeros(1), np.zeros(1))
        self.borders = list(range(stretch.first, stretch.last + 1, EVERY))
        Scripted.tried.append((stretch.first // EVERY, stretch.last // EVERY))
        self.ladder = SimpleNamespace(free=False)
        self.best: Guidance | None = None
        self.states: States | None = None
        self.fallen: Guidance | None = None
        self.fallen_states: States | None = None

    def passes(self, told: Any) -> Iterator[None]:
        windows, newtons = len(self.borders) - 1, Scripted.script.pop(0)
        self.ladder.free = newtons == 0.0
        if newtons is not None:
            help_ = np.zeros((windows, HELP))
            help_[:, 2] = newtons
            count = self.borders[0] // EVERY + np.arange(float(windows))
            self.best = Guidance(
                window=0.05,
                offsets=np.repeat(count[:, None], 2, axis=1),
                help=help_,
                postures=np.zeros((windows, POSTURE)),
                gains=np.zeros((windows, 2, DEVIATION + 2)),
                found={
                    "passes": 3,
                    "rounds": 0,
                    "help_scale": 0.0,
                    "help_percent": 0.0,
                    "cost": 1.0,
                },
            )
            rows = np.arange(count[0], count[0] + windows + 1.0)[:, None]
            self.states = States(rows, rows, rows)
        yield


@pytest.fixture
def scripted(monkeypatch: pytest.MonkeyPatch) -> type[Scripted]:
    monkeypatch.setattr(relay, "Search", Scripted)
    Scripted.tried = []
    return Scripted


@pytest.fixture(scope="module")
def long(walk: Performance) -> Performance:
    return replace(walk, duration=15.0)


def run(performance: Performance, script: list[float | None]) -> Relay:
    Scripted.script = script
    one = Relay(performance)
    for _ in one.passes():
        pass
    return one


def test_every_piece_begins_where_the_one_before_hands_over(
    long: Performance, scripted: type[Scripted]
) -> None:
    best = run(long, [0.0, 0.0, 0.0]).best
    assert best is not None
    assert scripted.tried == [(0, 120), (100, 220), (200, 300)]
    assert np.array_equal(best.offsets[:, 0], np.arange(300))


def test_a_piece_that_fails_is_tried_again_from_earlier(
    long: Performance, scripted: type[Scripted]
) -> None:
    best = run(long, [0.0, None, 0.0, 0.0]).best
    assert best is not None
    assert scripted.tried == [(0, 120), (100, 220), (70, 220), (200, 300)]
    assert np.array_equal(best.offsets[:, 0], np.arange(300))
    assert best.found["help_percent"] == 0.0


def test_only_the_piece_that_fails_again_is_helped_by_the_least_found(
    long: Performance, scripted: type[Scripted]
) -> None:
    best = run(long, [0.0, 40.0, 50.0, 0.0]).best
    assert best is not None
    assert np.array_equal(best.offsets[:, 0], np.arange(300))
    weight = long.scene.characters[0].mass * 9.81
    ((begin, end, percent),) = best.found["helped"]
    assert (begin, end) == (5.0, 10.0)
    assert percent == pytest.approx(4000.0 / weight, abs=1e-3)
    assert best.found["help_percent"] == pytest.approx(percent / 3.0, abs=1e-3)


def test_what_comes_before_a_fall_is_kept(long: Performance, scripted: type[Scripted]) -> None:
    one = run(long, [0.0, *[None] * 5])
    assert one.best is not None
    assert np.array_equal(one.best.offsets[:, 0], np.arange(100))
    assert run(long, [None] * 4).best is None


def test_a_piece_that_cannot_be_passed_is_made_shorter(
    long: Performance, scripted: type[Scripted]
) -> None:
    best = run(long, [0.0, None, None, None, 9.0, 0.0, 0.0, 0.0]).best
    assert best is not None
    assert scripted.tried[3:6] == [(100, 170), (100, 145), (125, 245)]
    assert np.array_equal(best.offsets[:, 0], np.arange(300))
    assert [span[:2] for span in best.found["helped"]] == [[5.0, 6.25]]


def test_memory_of_what_is_done_does_not_grow_with_it(
    long: Performance, scripted: type[Scripted]
) -> None:
    one = run(long, [0.0, 0.0, 0.0])
    assert isinstance(one.done, Done)
    assert len(one.done.states.qpos) <= 31
