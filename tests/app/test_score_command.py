"""The score command prints what touched what."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from bodies import still
from understudy.app.main import main
from understudy.character.bodies import adult_woman
from understudy.control import Tracking
from understudy.scene import Ball, Scene


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """A take file: a ball falls on the second of two women who stand."""
    woman = adult_woman()
    here = still(woman, seconds=0.4)
    there = replace(here, root_positions=here.root_positions + np.array([1.5, 0.0, 0.0]))
    ball = Ball(position=(1.5, 0.0, woman.height + 0.2))
    scene = Scene(characters=(woman, woman), props=(ball,), contacts=(("b/head", "ball"),))
    servos = (Tracking(reference=here), Tracking(reference=there, character=1))
    take = us.simulate(us.Performance(scene=scene, controllers=servos, duration=0.4))
    path = tmp_path_factory.mktemp("score") / "two.take.npz"
    us.write(take, path)
    return path


def test_score_prints_contact_events_and_feet(saved, capsys):
    assert main(["score", str(saved)]) == 0
    lines = capsys.readouterr().out.splitlines()
    contacts = lines[lines.index("contacts") :]
    assert any(line.strip().startswith("b/head - ball") and "N s" in line for line in contacts)
    feet = [line.split()[0] for line in contacts if "on the ground" in line]
    assert feet == ["left_foot", "right_foot", "b/left_foot", "b/right_foot"]
    assert all(len(line) < 100 for line in contacts[: len(feet) + 3])


def test_score_tells_two_of_one_name_apart(saved, capsys):
    main(["score", str(saved)])
    shown = capsys.readouterr().out
    assert "adult_woman (a): still" in shown and "adult_woman (b): still" in shown
