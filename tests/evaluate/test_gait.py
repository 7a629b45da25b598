"""Gait of made and captured motion: known angles, known timing, symmetry, and free fall."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import understudy as us
from understudy.character import Character
from understudy.errors import InvalidValue
from understudy.evaluate import measured
from understudy.evaluate.gait import Gait, gait_of
from understudy.evaluate.gait_angles import _distance, angles, heading, legs_apart, travel
from understudy.evaluate.gait_body import of_clip, of_measured
from understudy.evaluate.gait_cycle import PHASE
from understudy.evaluate.gait_stances import stances_by_motion
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import ROLES, figure
from understudy.motion.keyframes import rotation

FRAMES, RATE, SPEED = 60, 60.0, 3.0
SIDES = ("left", "right")
AHEAD = np.array([1.0, 0.0, 0.0])


def striding() -> tuple[Clip, dict[str, np.ndarray]]:
    """A figure with known hip, knee, ankle and pelvis angles [deg], carried along +x."""
    phase = np.linspace(0.0, 2.0 * np.pi, FRAMES)
    known = {
        "pelvis": 6.0 + 2.0 * np.sin(2.0 * phase),
        "hip": 10.0 + 30.0 * np.cos(phase),
        "knee": 45.0 - 40.0 * np.cos(phase),
        "ankle": 15.0 * np.sin(phase),
    }
    turned = rot.identity(FRAMES, len(ROLES))
    turned[:, 0] = rot.from_euler("Y", np.radians(known["pelvis"])[:, None])
    for side in SIDES:
        for joint in ("hip", "knee", "ankle"):
            index = ROLES.index(f"{side}_{joint}")
            turned[:, index] = rotation(f"{side}_{joint}", {"flexion": known[joint]})
    path = np.zeros((FRAMES, 3))
    path[:, 0], path[:, 2] = SPEED * np.arange(FRAMES) / RATE, 1.1
    skeleton = figure(1.75)
    return Clip(skeleton=skeleton, rotations=turned, root_positions=path, rate=RATE), known


@pytest.fixture(scope="module")
def walk() -> Gait:
    return gait_of(us.sample("walk"))


@pytest.mark.parametrize("turn", [0.0, 2.0, -0.7])
def test_known_joint_angles_are_found_whichever_way_it_goes(turn: float) -> None:
    clip, known = striding()
    mover = of_clip(clip.placed(at=(3.0, -2.0), heading=turn))
    every = slice(0, FRAMES)
    found = angles(mover, "left", every, heading(mover, every))
    for name, degrees in known.items():
        assert np.allclose(np.degrees(found[name]), degrees, atol=0.5), name
    thigh = known["hip"] - known["pelvis"]
    assert np.allclose(np.degrees(found["thigh"]), thigh, atol=0.5)
    assert np.allclose(np.degrees(found["foot"]), thigh - known["knee"] + known["ankle"], atol=0.5)
    # The trunk is rigid on the pelvis and stands straight when the pelvis does.
    assert np.allclose(np.degrees(found["trunk"]), known["pelvis"], atol=0.5)


def test_an_even_turn_has_the_heading_of_its_tangent() -> None:
    clip, _ = striding()
    around = 0.5 * clip.times  # rad
    path = np.stack((6.0 * np.sin(around), 6.0 * (1.0 - np.cos(around)), 0 * around + 1.1), axis=1)
    turned = rot.identity(FRAMES, len(ROLES))  # stiff: its center of mass is fixed in it
    turned[:, 0] = rot.from_euler("Z", around[:, None])
    round_a_bend = Clip(
        skeleton=clip.skeleton, rotations=turned, root_positions=path, rate=clip.rate
    )
    mover = of_clip(round_a_bend)
    stride = slice(0, round(0.7 * RATE))
    ahead = heading(mover, stride)
    found = np.arctan2(ahead[:, 1], ahead[:, 0])
    assert np.degrees(np.abs(found - around[stride])).max() < 2.0
    assert np.linalg.norm(travel(mover, stride), axis=1) == pytest.approx(SPEED, abs=0.1)


def test_a_body_on_the_spot_heads_where_it_faces() -> None:
    clip, _ = striding()
    still = np.tile([0.0, 0.0, 1.1], (FRAMES, 1))
    clip = Clip(skeleton=clip.skeleton, rotations=clip.rotations, root_positions=still, rate=RATE)
    mover = of_clip(clip.placed(heading=1.0))
    assert np.allclose(heading(mover, slice(0, FRAMES)), [np.cos(1.0), np.sin(1.0), 0.0], atol=1e-6)


def test_distance_of_segments_is_that_of_their_nearest_points() -> None:
    rng = np.random.default_rng(3)
    a, b, c, d = rng.normal(size=(4, 200, 3))
    c, d = c + AHEAD, d + AHEAD
    share = np.linspace(0.0, 1.0, 101)[:, None, None]
    one, two = a + share * (b - a), c + share * (d - c)
    gaps = np.linalg.norm(one[:, None] - two[None], axis=-1).min(axis=(0, 1))
    found = _distance(a, b, c, d)
    assert np.all(found <= gaps + 1e-12)
    assert np.allclose(found, gaps, atol=0.05)
    line = np.zeros((1, 3))
    over = line + np.array([0.0, 0.2, 0.0])
    assert _distance(line, line + AHEAD, over, over + AHEAD)[0] == pytest.approx(0.2)  # parallel


def test_parallel_legs_are_a_hips_width_apart() -> None:
    clip, _ = striding()
    mover = of_clip(clip)
    apart = np.linalg.norm(mover.at("left_hip") - mover.at("right_hip"), axis=1)
    assert legs_apart(mover) == pytest.approx(apart)


def test_the_walk_has_the_timing_it_was_made_with(walk: Gait) -> None:
    figures = walk.figures()
    assert figures["speed_m_s"].mean == pytest.approx(1.32, abs=0.005)
    assert figures["step_rate_hz"].mean * figures["step_length_m"].mean == pytest.approx(1.32, 0.01)
    assert not walk.runs
    # Made to begin at 30 % of the left leg's stride, and to leave the floor at 59.5 %. Its soles
    # slow down smoothly before they land and roll on while they leave.
    stride = 2.0 / figures["step_rate_hz"].mean
    for stance in walk.stances:
        shift = 0.3 if stance.side == "left" else 0.8
        down, off = ((t / stride + shift) % 1.0 for t in (stance.start_s, stance.end_s))
        if stance.begins:
            assert stride * ((down + 0.5) % 1.0 - 0.5) == pytest.approx(0.0, abs=0.025)
        if stance.whole:
            assert stride * (off - 0.595) == pytest.approx(0.0, abs=0.025)
    leg = walk.leg_length
    assert figures["step_width_m"].mean == pytest.approx(0.13 * leg, abs=0.02)
    # Orendurff et al. 2004: 40 to 48 mm; the sample's pelvis rises 43, its arms and legs less.
    assert 0.03 < figures["com_rise_m"].mean < 0.048
    assert abs(figures["acceleration_m_s2"].mean) < 0.05
    # A foot that lands is slower than the body above it.
    assert 0.0 < figures["landing_forward_m_s"].mean < 1.32
    assert 0.0 < figures["landing_down_m_s"].mean < 0.5


def test_the_walk_has_the_curves_it_was_made_from(walk: Gait) -> None:
    from understudy.motion.gait import _ANKLE, _HIP, _KNEE

    mover, every = of_clip(us.sample("walk")), slice(None)
    found = angles(mover, "left", every, heading(mover, every))
    # Made to begin at 30 % of the left leg's stride; its legs are then closed onto its feet.
    at = (np.arange(20) / 20 + 1.0 - 0.3) * 2.0 / walk.figures()["step_rate_hz"].mean
    for name, table, least in (("hip", _HIP, 0.99), ("knee", _KNEE, 0.98), ("ankle", _ANKLE, 0.9)):
        mine = np.degrees(np.interp(at, mover.times, found[name]))
        assert np.corrcoef(mine, table)[0, 1] > least, name


def test_left_and_right_of_the_walk_are_alike(walk: Gait) -> None:
    each = {side: [c for c in walk.cycles if c.side == side] for side in SIDES}
    for name in ("hip", "knee", "ankle"):
        left, right = (np.mean([c.curves[name] for c in each[side]], axis=0) for side in SIDES)
        assert np.abs(np.degrees(left - right)).max() < 1.0


def test_a_mirrored_walk_has_the_same_figures(walk: Gait) -> None:
    other = gait_of(us.sample("walk").mirrored()).figures()
    for name, spread in walk.figures().items():
        assert other[name].mean == pytest.approx(spread.mean, abs=1e-3, rel=1e-2), name


def test_cycles_are_whole_and_begin_with_a_touchdown(walk: Gait) -> None:
    for cycle in walk.cycles:
        mine = [s for s in walk.stances if s.side == cycle.side and s.start_s == cycle.start_s]
        assert len(mine) == 1 and mine[0].begins
        assert cycle.stance_s == pytest.approx(mine[0].duration_s)
        for curve in cycle.curves.values():
            assert curve.shape == PHASE.shape
    starts = [c.start_s for c in walk.cycles]
    assert starts == sorted(starts)


def test_only_whole_stances_after_the_start_count() -> None:
    clip = us.sample("walk")
    late = gait_of(clip, start=2.0)
    assert min(s.start_s for s in late.stances) >= 2.0
    short = gait_of(clip.trimmed(0.0, 0.5))
    assert short.cycles == () and short.speed == 0.0 and not short.runs
    assert "hip" not in short.as_dict()["curves_deg"]
    with pytest.raises(InvalidValue, match="no whole cycle"):
        short.curve("hip")


def test_a_take_and_its_motion_tell_the_same_gait(walk: Gait) -> None:
    clip = us.sample("walk").trimmed(0.0, 3.0)
    take = us.track(clip, Character.from_clip(clip))
    m = measured(take)
    by_force = gait_of(m, name="walk, tracked")
    by_motion = gait_of(take.clip(rate=240.0))
    assert by_force.kind != by_motion.kind and by_force.name == "walk, tracked"
    one, two = by_force.figures(), by_motion.figures()
    for a, b in zip(by_force.stances, by_motion.stances, strict=True):
        assert (a.side, a.whole) == (b.side, b.whole)
        assert (a.start_s, a.end_s) == pytest.approx((b.start_s, b.end_s), abs=0.04)
    assert one["speed_m_s"].mean == pytest.approx(two["speed_m_s"].mean, abs=0.02)
    assert one["step_rate_hz"].mean == pytest.approx(two["step_rate_hz"].mean, rel=0.03)
    every = slice(None)
    movers = (of_measured(m), of_clip(take.clip(rate=240.0)))
    hips = [angles(mover, "left", every, heading(mover, every))["hip"] for mover in movers]
    same = np.interp(movers[0].times, movers[1].times, hips[1])
    assert np.degrees(np.abs(hips[0] - same)).max() < 0.5
    # What all stances gave is what the ground gave.
    total = sum(f.mean * s.duration_s for f, s in _pairs(by_force))
    rows = m.times >= min(s.start_s for s in by_force.stances if s.whole)
    rows &= m.times <= max(s.end_s for s in by_force.stances if s.whole)
    assert total <= m.ground_reaction()[rows, 2].sum() / m.rate / m.performer().weight + 1e-6
    assert by_force.force() is not None and by_motion.force() is None


def _pairs(gait: Gait) -> list:
    return [
        (f, next(s for s in gait.stances if (s.side, s.start_s) == (f.side, f.start_s)))
        for f in gait.forces
    ]


def test_what_has_no_legs_has_no_gait() -> None:
    from understudy.motion.skeleton import Skeleton

    snake = Skeleton(
        names=("a", "b"), parents=(-1, 0), offsets=np.array([[0, 0, 1.0], [0, 0, 0.5]])
    )
    clip = Clip(
        skeleton=snake,
        rotations=rot.identity(10, 2),
        root_positions=np.zeros((10, 3)),
        rate=30.0,
        name="snake",
    )
    with pytest.raises(InvalidValue, match="snake: has no pelvis"):
        gait_of(clip)
    with pytest.raises(InvalidValue, match="at least 5"):
        gait_of(us.sample("walk").trimmed(0.0, 0.02))
    with pytest.raises(InvalidValue, match="a clip or a take"):
        gait_of("walk.bvh")  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("start", [np.nan, -1.0, 5.0, 1e9, "late"])
def test_a_start_that_is_no_time_of_the_motion_is_refused(start: float) -> None:
    with pytest.raises(InvalidValue, match="start is"):
        gait_of(us.sample("walk"), start=start)


def test_without_a_whole_cycle_there_is_no_speed() -> None:
    short = gait_of(us.sample("walk").trimmed(0.0, 0.6))
    assert str(short).startswith("walk: no whole cycle, by motion of the soles")
    assert "m/s" not in str(short)
    assert (short.as_dict()["speed_m_s"], short.as_dict()["runs"]) == (None, None)


def test_a_linkage_is_measured_by_its_clip() -> None:
    clip = us.sample("walk").trimmed(0.0, 0.6)
    take = us.simulate(us.driven(clip, us.Linkage.from_clip(clip)))
    with pytest.raises(InvalidValue, match=r"take\.clip\(\)"):
        gait_of(take)
    assert gait_of(take.clip()).stances


@pytest.mark.clips
@pytest.mark.parametrize("name", ["02_03", "35_17"])
def test_captured_runners_fall_freely_while_no_foot_stands(clips: Path, name: str) -> None:
    mover = of_clip(us.read(clips / "cmu_bvh" / f"{name}.bvh"))
    height, falls = mover.center_of_mass[:, 2], []
    for a, b in pairwise(stances_by_motion(mover)):
        rows = (mover.times >= a.end_s) & (mover.times <= b.start_s)
        fit = np.polynomial.polynomial.polyfit(mover.times[rows], height[rows], 2)
        falls.append(-2.0 * fit[2])
    assert len(falls) == 3
    assert np.mean(falls) == pytest.approx(9.81, rel=0.08)


@pytest.mark.clips
def test_captured_runners_run_as_people_do(clips: Path) -> None:
    for name, speed in (("02_03", 2.6), ("35_17", 3.15)):
        gait = gait_of(us.read(clips / "cmu_bvh" / f"{name}.bvh"))
        figures = gait.figures()
        assert gait.runs and gait.speed == pytest.approx(speed, abs=0.05)
        assert 0.20 < figures["stance_s"].mean < 0.29
        assert 0.08 < figures["flight_s"].mean < 0.17
        assert 2.5 < figures["step_rate_hz"].mean < 3.0
        assert 0.05 < figures["com_rise_m"].mean < 0.12
    start = gait_of(us.read(clips / "cmu_asfamc" / "127_03.amc"))
    assert start.runs and start.figures()["acceleration_m_s2"].mean > 1.5  # from standing


@pytest.mark.clips
def test_captured_walkers_walk_as_people_do(clips: Path) -> None:
    # Winiarski et al. 2019: 101 to 116 steps a minute and a duty factor of .645 to .629 at 1.04 to
    # 1.32 m/s; Orendurff et al. 2004: the body rises by less than 48 mm.
    for name in ("02_01", "35_01"):
        gait = gait_of(us.read(clips / "cmu_bvh" / f"{name}.bvh"))
        figures = gait.figures()
        assert not gait.runs and len(gait.cycles) == 4
        assert figures["duty"].mean == pytest.approx(0.637, abs=0.02)
        assert figures["step_rate_hz"].mean == pytest.approx(1.81, abs=0.13)
        assert figures["com_rise_m"].mean < 0.048
