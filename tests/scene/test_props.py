"""Props: what they weigh, where they are, what they touch, and what they refuse."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest

from bodies import chain
from understudy.character import Character
from understudy.character.bodies import adult_man, child
from understudy.errors import InvalidValue, UnknownName
from understudy.scene import Ball, Box, Drum, Ground, Scene, Staff, Table

EVERY = (
    Drum(position=(0.5, -0.2, 0.9), normal=(0.2, 0.0, 1.0)),
    Table(position=(1.0, 1.0)),
    Staff(),
    Box(position=(1.0, 1.0, 1.2), mass=2.0),
    Ball(position=(0.0, 0.5, 3.0)),
)


@pytest.fixture(scope="module")
def man() -> Character:
    return adult_man(plan="upper")


def fallen(scene: Scene, seconds: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = scene.model
    data = mujoco.MjData(model)
    for _ in range(round(seconds / scene.timestep)):
        mujoco.mj_step(model, data)
    return model, data


def test_props_come_after_the_characters_and_move_none_of_their_numbers(man):
    alone, full = Scene(characters=(man, man)), Scene(characters=(man, man), props=EVERY)
    assert [p.qpos for p in alone.parts] == [p.qpos for p in full.parts]
    assert [p.dofs for p in alone.parts] == [p.dofs for p in full.parts]
    assert full.model.nq == alone.model.nq + 2 * 7
    assert full.model.nu == alone.model.nu


@pytest.mark.parametrize(
    ("prop", "sites"),
    [
        (EVERY[0], ["drum/skin"]),
        (EVERY[1], ["table/top"]),
        (EVERY[2], ["staff/grip", "staff/head", "staff/foot"]),
        (EVERY[3], ["box/center", "box/top"]),
        (EVERY[4], ["ball/center"]),
    ],
)
def test_props_have_their_sites_and_a_touch_sensor(man, prop, sites):
    model = Scene(characters=(man,), props=(prop,)).model
    for site in sites:
        assert model.site(site).id >= 0
    assert model.sensor(f"{prop.name}/touch").id >= 0


def test_a_dropped_box_and_ball_fall_as_long_as_galileo_says():
    # h = g t^2 / 2; the semi-implicit step is half a step ahead.
    height, props = 1.0, (Box(position=(0.0, 2.0, 3.0), mass=3.0), Ball(position=(0.0, -2.0, 3.0)))
    scene = Scene(characters=(chain(1),), ground=None, props=props, timestep=0.001)
    seconds = np.sqrt(2 * height / scene.gravity)
    _, data = fallen(scene, seconds)
    for name in ("box", "ball"):
        assert data.body(name).xpos[2] == pytest.approx(3.0 - height, abs=0.004)


def test_loose_props_rest_on_the_ground_and_fixed_ones_stay():
    props = (
        Box(position=(0.0, 2.0, 0.4), mass=3.0, size=(0.4, 0.3, 0.2)),
        Ball(position=(0.0, -2.0, 0.5), radius=0.11),
        Box(name="rock", position=(2.0, 0.0, 1.0)),
    )
    _, data = fallen(Scene(characters=(chain(1),), props=props), 1.0)
    assert data.body("box").xpos[2] == pytest.approx(0.1, abs=0.002)
    assert data.body("ball").xpos[2] == pytest.approx(0.11, abs=0.002)
    np.testing.assert_array_equal(data.body("rock").xpos, [2.0, 0.0, 1.0])


def test_the_touch_sensor_of_a_resting_box_feels_its_weight():
    scene = Scene(characters=(chain(1),), props=(Box(position=(0.0, 2.0, 0.16), mass=3.0),))
    _, data = fallen(scene, 1.0)
    assert data.sensor("box/touch").data[0] == pytest.approx(3.0 * 9.81, rel=0.02)


def test_a_ball_rolls_down_a_slope_at_five_sevenths_of_its_pull():
    # A solid ball that does not slip: a = 5/7 g sin(slope).
    slope, radius = np.radians(5.0), 0.11
    ground = Ground(slope=-slope, heading=0.0)
    up = float(ground.height((0.0, 3.0))) + radius / np.cos(slope)
    scene = Scene(
        characters=(chain(1),), ground=ground, props=(Ball(position=(0.0, 3.0, up), radius=radius),)
    )
    _, data = fallen(scene, 1.0)
    along = data.body("ball").xpos[0] / np.cos(slope)
    assert along == pytest.approx(0.5 * 5 / 7 * 9.81 * np.sin(slope), rel=0.03)


def test_a_held_staff_adds_its_mass_and_inertia_to_the_hand(man):
    # The parallel axis theorem, through the engine's own composite inertia of the hand's subtree.
    staff = Staff(length=1.4, mass=0.9, grip=0.3, direction=(1.0, 0.0, 0.5))
    with_it, without = Scene(characters=(man,), props=(staff,)), Scene(characters=(man,))
    masses, data = [], []
    for scene in (with_it, without):
        state = mujoco.MjData(scene.model)
        mujoco.mj_forward(scene.model, state)
        masses.append(scene.model.body("right_hand").subtreemass[0])
        data.append(state)
    assert masses[0] - masses[1] == pytest.approx(0.9, abs=1e-12)
    model, state = with_it.model, data[0]
    joint = state.body("right_hand").xpos
    middle = state.body("staff").xipos - joint
    axis = np.array(staff.direction)
    along, across = staff.inertia[2], staff.inertia[0]
    own = across * np.eye(3) + (along - across) * np.outer(axis, axis)
    added = own + 0.9 * (middle @ middle * np.eye(3) - np.outer(middle, middle))
    dofs = model.joint("right_wrist").dofadr[0] + np.arange(3)

    def inertia(scene: Scene, state: mujoco.MjData) -> np.ndarray:
        full = np.zeros((scene.model.nv, scene.model.nv))
        mujoco.mj_fullM(scene.model, state, full)
        return full[np.ix_(dofs, dofs)]

    # In the neutral pose the link frames are the world's.
    gained = inertia(with_it, data[0]) - inertia(without, data[1])
    np.testing.assert_allclose(gained, added, atol=1e-9)


@pytest.mark.parametrize("make", [adult_man, child])
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_staff_passes_through_the_hand_and_along_the_thumb(make, side):
    body = make(plan="upper")
    scene = Scene(characters=(body,), props=(Staff(held_by=f"{side}_hand", grip=0.4),))
    data = mujoco.MjData(scene.model)
    mujoco.mj_forward(scene.model, data)
    grip = data.site("staff/grip").xpos - data.body(f"{side}_hand").xpos
    hand = next(s for k in body.links if k.name == f"{side}_hand" for s in k.shapes)
    low, high = hand.vertices.min(axis=0), hand.vertices.max(axis=0)
    assert (grip > low).all() and (grip < high).all()
    # Beyond the wrist, before the finger tips.
    assert 0.3 < abs(grip[1]) / max(abs(low[1]), abs(high[1])) < 0.7
    pointing = data.site("staff/head").xpos - data.site("staff/foot").xpos
    np.testing.assert_allclose(pointing / 1.5, [1.0, 0.0, 0.0], atol=1e-12)


def test_a_held_box_lies_against_the_palm(man):
    scene = Scene(
        characters=(man,), props=(Box(held_by="left_hand", mass=1.0, size=(0.2, 0.2, 0.1)),)
    )
    data = mujoco.MjData(scene.model)
    mujoco.mj_forward(scene.model, data)
    top = data.site("box/top").xpos[2] - data.body("left_hand").xpos[2]
    assert -0.026 < top < -0.015


def test_a_second_character_can_hold_a_staff(man):
    scene = Scene(characters=(man, man), props=(Staff(held_by="b/left_hand"),))
    model = scene.model
    assert model.body("staff").parentid[0] == model.body("b/left_hand").id


def test_a_prop_held_by_nobody_is_refused_with_the_nearest_name(man):
    with pytest.raises(UnknownName, match="Did you mean 'right_hand'"):
        _ = Scene(characters=(man,), props=(Staff(held_by="right_han"),)).model


def test_names_of_props_must_differ_from_each_other_and_from_links(man):
    with pytest.raises(InvalidValue, match="'drum', as a prop"):
        Scene(characters=(man,), props=(EVERY[0], EVERY[0]))
    with pytest.raises(InvalidValue, match="'head', as a link"):
        Scene(characters=(man,), props=(Ball(name="head", position=(0.0, 0.0, 1.0)),))


def test_several_props_of_one_kind_stand_side_by_side(man):
    drums = tuple(
        Drum(name=name, position=(0.4, y, 0.9)) for name, y in (("low", 0.2), ("high", -0.2))
    )
    model = Scene(characters=(man,), props=drums).model
    assert model.site("low/skin").id != model.site("high/skin").id


GOOD: dict[type, dict[str, Any]] = {
    Drum: {"position": (0.0, 0.0, 1.0)},
    Table: {"position": (1.0, 0.0)},
    Staff: {},
    Box: {"position": (1.0, 0.0, 1.0), "mass": 1.0},
    Ball: {"position": (1.0, 0.0, 1.0)},
}
BAD: tuple[Any, ...] = (float("nan"), float("inf"), -1.0, 1e9, "x", None, True, (), (1.0, "y", 2.0))
MEANT = {
    (Box, "mass", None),
    (Box, "held_by", None),
    (Box, "heading", -1.0),
    (Table, "heading", -1.0),
    (Box, "held_by", "x"),
    (Staff, "held_by", "x"),
    *((kind, "name", "x") for kind in GOOD),
}


@pytest.mark.parametrize("kind", list(GOOD), ids=lambda kind: kind.__name__)
def test_wrong_values_are_refused_with_the_name_of_the_field(kind):
    fields = kind.__dataclass_fields__
    for field in fields:
        for bad in BAD:
            if (kind, field, bad) in MEANT:
                continue
            with pytest.raises(InvalidValue, match=r"\.$") as caught:
                kind(**{**GOOD[kind], field: bad})
            assert field in str(caught.value) or field == "name"


@pytest.mark.parametrize("kind", list(GOOD), ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("scale", [0.3, 1.0, 3.0])
def test_the_engine_takes_every_prop_that_is_not_refused(kind, scale, man):
    sizes = ("radius", "depth", "length", "mass", "height", "thickness", "friction")
    plain = kind(**GOOD[kind])
    scaled = {f: scale * getattr(plain, f) for f in sizes if hasattr(plain, f)}
    prop = replace(plain, **scaled)
    assert Scene(characters=(man,), props=(prop,), contacts="all").model.npair > 0


def test_held_boxes_need_a_mass():
    with pytest.raises(InvalidValue, match="held"):
        Box(held_by="left_hand")
