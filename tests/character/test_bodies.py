from __future__ import annotations

import numpy as np
import pytest

from understudy.character import adult_man, adult_woman, alien, body, child
from understudy.character.bodies import BODIES
from understudy.character.outline import SKIN
from understudy.errors import UnknownName


@pytest.mark.parametrize("name", BODIES)
def test_bodies_are_found_by_name(name):
    assert body(name).name == name
    assert len(body(name).links) == 18


def test_an_unknown_body_gets_a_suggestion():
    with pytest.raises(UnknownName, match="Did you mean 'adult_woman'"):
        body("adult_women")


def length(character, joint: str) -> float:
    return float(np.linalg.norm(character.link(joint).offset))


def test_the_alien_has_long_arms_and_small_legs():
    creature, man = alien(), adult_man(height=1.75)
    for joint in ("left_elbow", "right_wrist"):
        assert length(creature, joint) == pytest.approx(1.5 * length(man, joint))
    for joint in ("left_knee", "right_ankle"):
        assert length(creature, joint) == pytest.approx(0.62 * length(man, joint))
    assert not any(s.rgba == SKIN for link in creature.links for s in link.shapes)


def test_a_child_has_a_larger_head_and_shorter_legs_for_its_height():
    small, woman = child(), adult_woman(height=1.22, mass=23.0)
    assert small.link("head").mass > 1.5 * woman.link("head").mass
    assert length(small, "left_knee") < length(woman, "left_knee")
    assert small.simulated_mass == pytest.approx(23.0)


def test_sizes_and_plans_are_options():
    man = adult_man(height=1.9, mass=95.0, plan="upper8")
    assert man.height == 1.9
    assert man.mass == 95.0
    assert man.controlled_dof == 24


def test_a_woman_is_no_small_man():
    woman, man = adult_woman(height=1.7, mass=65.0), adult_man(height=1.7, mass=65.0)
    assert woman.link("left_thigh").mass > man.link("left_thigh").mass
    assert woman.link("left_upper_arm").torque_limit[2] < man.link("left_upper_arm").torque_limit[2]
