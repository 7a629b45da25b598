from __future__ import annotations

import numpy as np
import pytest

from understudy.character import anthropometry as human
from understudy.character.anthropometry import MassProperties, combined, segments
from understudy.character.strength import EXERTIONS, joint_kind, torque_limits
from understudy.errors import InvalidValue, UnknownName

TABLES = [(table, sex) for table in ("de_leva", "dempster") for sex in ("female", "male")]


@pytest.mark.parametrize(("table", "sex"), TABLES)
def test_segment_masses_add_up_to_the_body(table, sex):
    own = segments(table, sex)
    total = sum(s.mass * (2 if name in human.PAIRED else 1) for name, s in own.items())
    assert total == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(("table", "sex"), TABLES)
def test_every_segment_is_a_possible_rigid_body(table, sex):
    own = segments(table, sex)
    for name in own:
        part = human.segment_properties(
            name, np.zeros(3), np.array([0.0, 0.0, -0.3]), table=own, mass=70.0
        )
        moments = np.linalg.eigvalsh(part.inertia)
        assert moments[0] > 0, name
        assert moments[0] + moments[1] >= moments[2], name


def test_a_thigh_has_the_published_mass_center_and_radius():
    part = human.segment_properties(
        "thigh",
        np.zeros(3),
        np.array([0.0, 0.0, -0.4222]),
        table=segments("de_leva", "male"),
        mass=73.0,
    )
    assert part.mass == pytest.approx(0.1416 * 73.0)
    assert part.com == pytest.approx([0, 0, -0.4095 * 0.4222])
    radii = np.sqrt(np.diag(part.inertia) / part.mass) / 0.4222
    assert radii == pytest.approx([0.329, 0.329, 0.149])


def test_an_arm_held_out_keeps_its_long_axis():
    table = segments("de_leva", "female")
    part = human.segment_properties(
        "forearm", np.zeros(3), np.array([0.0, 0.26, 0.0]), table=table, mass=60.0
    )
    radii = np.sqrt(np.diag(part.inertia) / part.mass) / 0.26
    # Sagittal stays x; the transverse axis of the hanging arm now points up.
    assert radii == pytest.approx([0.261, 0.094, 0.257])


def test_two_point_masses_combine_by_parallel_axes():
    point = np.zeros((3, 3))
    parts = [
        MassProperties(mass=2.0, com=np.array([1.0, 0, 0]), inertia=point),
        MassProperties(mass=1.0, com=np.array([-2.0, 0, 0]), inertia=point),
    ]
    both = combined(parts)
    assert both.mass == 3.0
    assert both.com == pytest.approx([0, 0, 0])
    assert both.inertia == pytest.approx(np.diag([0, 6.0, 6.0]))  # m1 m2 / (m1 + m2) d^2


@pytest.mark.parametrize(("table", "sex"), TABLES)
def test_foot_and_toes_add_up_to_the_foot(table, sex):
    own = segments(table, sex)
    heel, tip = np.array([-0.06, 0.1, -0.03]), np.array([0.2, 0.1, -0.03])
    whole = human.segment_properties("foot", heel, tip, table=own, mass=70.0)
    foot, toes = human.foot_and_toes(heel, tip, table=own, mass=70.0)
    both = combined([foot, toes])
    assert both.mass == pytest.approx(whole.mass)
    assert both.com == pytest.approx(whole.com)
    assert both.inertia == pytest.approx(whole.inertia)
    assert toes.mass < 0.4 * foot.mass
    for part in (foot, toes):
        moments = np.linalg.eigvalsh(part.inertia)
        assert moments[0] > 0
        assert moments[0] + moments[1] >= moments[2]


def test_a_larger_head_keeps_the_whole():
    table = human.with_head(segments("de_leva", "female"), 1.25)
    total = sum(s.mass * (2 if name in human.PAIRED else 1) for name, s in table.items())
    assert total == pytest.approx(1.0)
    assert table["head"].mass == pytest.approx(0.0668 / 0.9999 * 1.25**3)


def test_unknown_tables_and_sexes_are_refused():
    with pytest.raises(InvalidValue, match="'de_leva' or 'dempster'"):
        segments("zatsiorsky", "male")  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="'female' or 'male'"):
        segments("de_leva", "child")  # type: ignore[arg-type]


def test_torques_are_those_of_the_published_example():
    # Anderson et al. 2007: a man of 1.78 m and 75 kg, a woman of 1.65 m and 61 kg [N m].
    man = torque_limits("left_knee", sex="male", mass=75, height=1.78)
    woman = torque_limits("left_knee", sex="female", mass=61, height=1.65)
    assert man[1] == pytest.approx([213, 114], abs=1)
    assert woman[1] == pytest.approx([157, 79], abs=1)
    ankle = torque_limits("right_ankle", sex="male", mass=75, height=1.78)
    assert ankle[1] == pytest.approx([43, 124], abs=1)


@pytest.mark.parametrize("joint", ["shoulder", "elbow", "wrist", "hip", "knee", "ankle", "ball"])
def test_strength_is_mirrored(joint):
    options = {"sex": "female", "mass": 60.0, "height": 1.7}
    left, right = (torque_limits(f"{s}_{joint}", **options) for s in ("left", "right"))
    assert left[1] == pytest.approx(right[1])
    assert left[[0, 2]] == pytest.approx(right[[0, 2], ::-1])


def test_strength_grows_with_mass_and_height():
    small = torque_limits("lower_back", sex="male", mass=60, height=1.6)
    large = torque_limits("lower_back", sex="male", mass=90, height=1.6 * 1.1)
    assert large == pytest.approx(small * 1.5 * 1.1)


def test_every_axis_names_its_source():
    for kind, exertions in EXERTIONS.items():
        assert sorted(e.axis for e in exertions) == [0, 1, 2], kind
        assert all(e.source for e in exertions)
    with pytest.raises(UnknownName):
        joint_kind("left_tail")
