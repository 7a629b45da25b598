"""Contacts: only what is named collides, and it collides well."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from understudy.character import Character
from understudy.character.bodies import adult_man
from understudy.errors import InvalidValue, UnknownName
from understudy.evaluate.events import contact_events
from understudy.evaluate.overlap import overlap
from understudy.motion.samples import sample, striking
from understudy.performance import tracked
from understudy.scene import Ball, Box, Drum, Scene, Staff, Table
from understudy.simulate import simulate
from understudy.take import Take

DRUM = Drum(position=(0.5, -0.2, 0.9))


@pytest.fixture(scope="module")
def man() -> Character:
    return adult_man(plan="upper")


def touching(scene: Scene, **places: tuple[float, float, float]) -> set[frozenset[str]]:
    """Names of bodies in contact with loose props set at places."""
    model = scene.model
    data = mujoco.MjData(model)
    for part, body in zip(scene.parts, scene.characters, strict=True):
        data.qpos[part.qpos.start : part.qpos.start + 3] = body.links[0].offset
    for name, place in places.items():
        start = model.joint(name).qposadr[0]
        data.qpos[start : start + 3] = place
    mujoco.mj_forward(model, data)
    out = set()
    for contact in data.contact:
        out.add(frozenset(model.body(model.geom_bodyid[g]).name for g in contact.geom))
    return out


def hand_of(scene: Scene, name: str = "right_hand") -> np.ndarray:
    data = mujoco.MjData(scene.model)
    body = scene.characters[0]
    data.qpos[:3] = body.links[0].offset
    mujoco.mj_forward(scene.model, data)
    return data.site(name.replace("hand", "palm")).xpos.copy()


def test_by_default_nothing_collides_but_with_the_ground(man):
    scene = Scene(characters=(man,), props=(DRUM, Ball(position=(0.0, 0.0, 3.0))))
    assert scene.model.npair == 0
    x, y, z = hand_of(scene)
    assert frozenset({"ball", "right_hand"}) not in touching(scene, ball=(x, y, z + 0.1))


def test_only_named_parts_collide(man):
    ball = Ball(position=(0.0, 0.0, 3.0))
    scene = Scene(characters=(man,), ground=None, props=(ball,), contacts=(("right_hand", "ball"),))
    x, y, z = hand_of(scene)
    assert touching(scene, ball=(x, y, z + 0.1)) == {frozenset({"ball", "right_hand"})}
    x, y, z = hand_of(scene, "left_hand")
    assert touching(scene, ball=(x, y, z + 0.1)) == set()


def test_contacts_off_is_the_same_scene(man):
    scene = Scene(characters=(man,), props=(DRUM,), contacts=(("right_hand", "drum"),))
    off = replace(scene, contacts=())
    assert off.model.npair == 0
    assert (off.model.nq, off.model.nv, off.model.nu) == (
        scene.model.nq,
        scene.model.nv,
        scene.model.nu,
    )
    np.testing.assert_array_equal(off.model.body_mass, scene.model.body_mass)
    np.testing.assert_array_equal(off.model.body_inertia, scene.model.body_inertia)


def test_all_is_every_prop_with_every_link_and_prop_and_the_characters_with_each_other(man):
    props = (DRUM, Table(position=(1.0, 1.0)), Ball(position=(0.0, 0.0, 3.0)), Staff())
    scene = Scene(characters=(man, man), props=props, contacts="all")
    model = scene.model
    pairs = {
        frozenset(model.body(model.geom_bodyid[g]).name for g in pair)
        for pair in zip(model.pair_geom1, model.pair_geom2, strict=True)
    }
    assert frozenset({"drum", "b/head"}) in pairs
    assert frozenset({"left_hand", "b/right_hand"}) in pairs
    assert frozenset({"ball", "table"}) in pairs
    # Fixed things, one character's own links, and a staff and its hand never do.
    assert frozenset({"drum", "table"}) not in pairs
    assert frozenset({"left_hand", "right_hand"}) not in pairs
    assert frozenset({"staff", "right_hand"}) not in pairs
    assert frozenset({"staff", "right_forearm"}) not in pairs
    assert frozenset({"staff", "b/right_hand"}) in pairs


def test_a_box_rests_on_a_table_when_they_are_named(man):
    props = (Table(position=(2.0, 0.0)), Box(position=(2.0, 0.0, 0.9), mass=2.0))
    for contacts, height in (((("box", "table"),), 0.74 + 0.15), ((), 0.15)):
        scene = Scene(characters=(man,), props=props, contacts=contacts)
        model = scene.model
        data = mujoco.MjData(model)
        for _ in range(500):
            mujoco.mj_step(model, data)
        assert data.body("box").xpos[2] == pytest.approx(height, abs=0.004)


def test_the_shapes_a_hand_touches_with_are_the_hand_that_is_seen(man):
    scene = Scene(characters=(man,), props=(DRUM,), contacts=(("right_hand", "drum"),))
    model = scene.model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    ids = [g for g in model.pair_geom1 if "hand" in model.geom(g).name]
    ids += [g for g in model.pair_geom2 if "hand" in model.geom(g).name]
    seen = [g for g in ids if model.geom(g).group[0] == 0]
    plates = [g for g in ids if "plate" in model.geom(g).name]
    assert len(plates) == 2 and model.geom("right_hand_0").id in seen
    for plate in plates:
        size, place = model.geom_size[plate], data.geom_xpos[plate]
        turn = data.geom_xmat[plate].reshape(3, 3)
        # Under the middle of the palm the plates are flush with it.
        for along in (-0.5, 0.0, 0.5):
            low = place + turn @ (size * np.array([0.0, along, -1.0]))
            start, down = low - np.array([0.0, 0.0, 0.05]), np.array([0.0, 0.0, 1.0])
            found = np.zeros(1, np.int32)
            group = np.array([1, 0, 0, 0, 0, 0], np.uint8)
            body = model.body("right_hand").id
            distance = mujoco.mj_ray(model, data, start, down, group, 1, -1, found)
            assert model.geom_bodyid[found[0]] == body
            assert distance == pytest.approx(0.05, abs=0.002)


@pytest.mark.parametrize("timestep", [0.001, 0.002, 0.004])
def test_a_contact_is_never_stiffer_than_two_steps(man, timestep):
    scene = Scene(
        characters=(man,), props=(DRUM,), contacts=(("right_hand", "drum"),), timestep=timestep
    )
    assert (scene.model.pair_solref[:, 0] >= 2 * timestep - 1e-12).all()
    assert (scene.model.pair_dim == 3).all()


@pytest.mark.parametrize(
    ("contacts", "error", "message"),
    [
        ((("right_hand", "dum"),), UnknownName, "Did you mean 'drum'"),
        ((("b/right_hand", "drum"),), UnknownName, "right_hand"),
        ("some", InvalidValue, "'all'"),
        (5, InvalidValue, "'all'"),
        (("right_hand", "drum"), InvalidValue, "two names"),
        ((("right_hand",),), InvalidValue, "two names"),
        (((1, "drum"),), InvalidValue, "two names"),
        ((("drum", "drum"),), InvalidValue, "touch itself"),
    ],
)
def test_contacts_that_make_no_sense_are_refused(man, contacts, error, message):
    with pytest.raises(error, match=message):
        Scene(characters=(man,), props=(DRUM,), contacts=contacts)


def test_pairs_that_can_never_touch_are_refused(man):
    props = (DRUM, Table(position=(1.0, 1.0)), Staff())
    with pytest.raises(InvalidValue, match="both fixed"):
        _ = Scene(characters=(man,), props=props, contacts=(("drum", "table"),)).model
    with pytest.raises(InvalidValue, match="joined"):
        _ = Scene(characters=(man,), props=props, contacts=(("staff", "right_hand"),)).model
    with pytest.raises(InvalidValue, match="joined"):
        _ = Scene(characters=(man,), contacts=(("right_hand", "right_forearm"),)).model


def test_a_pair_named_twice_counts_once(man):
    once = Scene(characters=(man,), props=(DRUM,), contacts=(("right_hand", "drum"),))
    twice = replace(once, contacts=(("right_hand", "drum"), ("drum", "right_hand")))
    assert once.model.npair == twice.model.npair


def stroke(man: Character, timestep: float, *, contact: bool = True) -> Take:
    """One stroke of 3.2 m/s onto a drum."""
    whole = tracked(
        sample("strike").trimmed(0.0, 1.6),
        man,
        timestep=timestep,
        props=(Drum(position=striking.DRUM),),
        contacts=(("right_hand", "drum"),) if contact else (),
    )
    return simulate(whole)


def test_a_fast_hand_stops_at_the_skin_of_a_drum_and_not_without_contact(man):
    take = stroke(man, 1.0 / 480.0)
    (event,) = contact_events(take, "right_hand", "drum")
    assert event.approach_m_s > 2.5
    assert event.penetration_mm < 2.0
    assert overlap(take, "right_hand", "drum").max() < 0.002
    through = stroke(man, 1.0 / 480.0, contact=False)
    assert overlap(through, "right_hand", "drum").max() > 0.015
    assert not contact_events(through, "right_hand")


def test_the_impulse_of_a_stroke_hardly_depends_on_the_step(man):
    impulses = [
        contact_events(stroke(man, 1.0 / rate), "right_hand", "drum")[0].impulse_ns
        for rate in (960.0, 480.0, 240.0)
    ]
    np.testing.assert_allclose(impulses, impulses[1], rtol=0.1)
