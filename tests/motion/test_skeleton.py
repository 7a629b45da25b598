"""Skeletons check themselves and answer by name."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from understudy.errors import InvalidValue, UnknownName
from understudy.motion.figure import figure
from understudy.motion.skeleton import Skeleton, joint_indices


def chain(**changes) -> Skeleton:
    fields = {
        "names": ("hip", "knee", "foot"),
        "parents": (-1, 0, 1),
        "offsets": np.array([[0, 0, 1.0], [0, 0, -0.5], [0, 0, -0.4]]),
        "end_joints": (2,),
        "end_offsets": np.array([[0.1, 0, 0]]),
    } | changes
    return Skeleton(**fields)


def test_rest_positions_add_offsets_up_the_tree():
    np.testing.assert_allclose(chain().rest_positions()[:, 2], [1.0, 0.5, 0.1])


def test_children_and_indices_follow_the_tree():
    body = figure()
    assert [body.names[i] for i in body.children(0)] == ["lower_back", "left_hip", "right_hip"]
    assert joint_indices(body, ["neck", "pelvis"]) == [3, 0]
    assert len(body) == 18


def test_unknown_joint_suggests_the_nearest():
    with pytest.raises(UnknownName, match="Did you mean 'left_knee'"):
        figure().index("left_nee")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"names": ()}, "at least one joint"),
        ({"parents": (-1, 0)}, "2 parents for 3 joints"),
        ({"names": ("a", "a", "b")}, "Two joints are named 'a'"),
        ({"parents": (-1, 2, 1)}, "every parent before its children"),
        ({"parents": (0, 0, 1)}, "root must come first"),
        ({"parents": (-1, -1, 1)}, "every parent before its children"),
        ({"end_joints": (3,)}, "belongs to a joint that does not exist"),
        ({"offsets": np.zeros((2, 3))}, "offsets has shape"),
        ({"offsets": np.full((3, 3), np.nan)}, "not finite"),
        ({"end_offsets": np.zeros((2, 3))}, "end_offsets has shape"),
        ({"offsets": "abc"}, "must be numbers"),
    ],
)
def test_bad_skeletons_are_refused_with_the_reason(changes, message):
    with pytest.raises(InvalidValue, match=message):
        chain(**changes)


def test_arrays_are_copied_and_read_only():
    offsets = np.zeros((3, 3))
    body = chain(offsets=offsets)
    offsets[0] = 7.0
    assert body.offsets[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        body.offsets[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        body.names = ()  # type: ignore[misc]


def test_scaled_skeleton_scales_every_length():
    twice = chain().scaled(2.0)
    np.testing.assert_allclose(twice.rest_positions(), 2.0 * chain().rest_positions())
    np.testing.assert_allclose(twice.end_offsets, 2.0 * chain().end_offsets)
    with pytest.raises(InvalidValue):
        chain().scaled(0.0)


def test_equal_skeletons_are_equal_and_hash_alike():
    assert chain() == chain()
    assert hash(chain()) == hash(chain())
    assert chain() != chain().scaled(1.1)
    assert chain() != "chain"


def test_a_skeleton_may_have_no_ends():
    assert chain(end_joints=(), end_offsets=np.zeros((0, 3))).end_offsets.shape == (0, 3)
