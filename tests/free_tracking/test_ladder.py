"""Every window goes down by itself, and up again where a pass fell."""

from __future__ import annotations

import numpy as np

from understudy.free_tracking.ladder import MARGIN, Ladder


def test_three_passes_take_all_help_away() -> None:
    ladder = Ladder.first(20, 100)
    scales = []
    while not ladder.free:
        scales.append(ladder.scales[0])
        ladder = ladder.after(20)
    assert scales == [0.3, 0.1, 0.0]


def test_fewer_children_do_once_all_windows_were_passed_until_a_pass_falls() -> None:
    ladder = Ladder.first(40, 100)
    assert ladder.children == 100 and not ladder.fell
    ladder = ladder.after(40)
    assert ladder.children == 60 and not ladder.fell
    ladder = ladder.after(20)
    assert ladder.children == 130 and ladder.fell
    ladder = ladder.after(40)
    assert ladder.children == 100 and not ladder.fell


def test_a_pass_near_its_goal_spares_a_rung() -> None:
    ladder = Ladder.first(20, 100)
    scales = []
    while not ladder.free:
        scales.append(ladder.scales[0])
        ladder = ladder.after(20, cost=1.0)
    assert scales == [0.3, 0.0]


def test_a_pass_far_off_is_tried_again_once() -> None:
    ladder = Ladder.first(20, 100)
    scales = []
    while not ladder.free:
        scales.append(ladder.scales[0])
        ladder = ladder.after(20, cost=9.0)
    assert scales == [0.3, 0.3, 0.1, 0.1, 0.0]


def test_before_a_fall_windows_go_down_and_at_it_toward_whole_help() -> None:
    ladder = Ladder.first(40, 100).after(30)
    assert (ladder.scales[: 30 - MARGIN] == 0.1).all()
    assert (ladder.scales[30 - MARGIN : 31] == 0.65).all()
    assert (ladder.scales[31:] == 0.3).all()
    assert ladder.children == 130


def test_a_fall_without_help_goes_half_way_back_there_alone() -> None:
    ladder = Ladder.first(40, 100).after(40).after(40).after(20)
    assert (ladder.scales[20 - MARGIN : 21] == 0.05).all()
    assert not ladder.scales[21:].any() and not ladder.scales[: 20 - MARGIN].any()
    assert not ladder.after(40).free
    assert ladder.after(40).after(40).free


def test_help_comes_back_where_a_fall_began() -> None:
    ladder = Ladder.first(40, 100).after(30, strayed=20)
    assert (ladder.scales[: 20 - MARGIN] == 0.1).all()
    assert (ladder.scales[20 - MARGIN : 31] == 0.65).all()
    assert (ladder.scales[31:] == 0.3).all()


def test_children_grow_to_twice_at_most() -> None:
    ladder = Ladder.first(40, 100)
    for _ in range(6):
        ladder = ladder.after(10)
    assert ladder.children == 200
    assert ladder.tried == 6
    assert np.isinf(ladder.worked[10])
