"""Segment orientations: equation 1 on the standard figure, uneven samples, gaps, other axes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from texts import person

from understudy.errors import ClipError
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import LINKS, ROLES
from understudy.motion.orientations import read_orientations

COMMA = ("time", "segment", "w", "x", "y", "z", "px", "py", "pz")


def rows_of(clip: Clip, times: np.ndarray | None = None, names=LINKS, positions=True) -> list[list]:
    pose = clip.forward_kinematics()
    rows = []
    for k, time in enumerate(clip.times if times is None else times):
        for j, role in enumerate(ROLES):
            place = (
                [f"{v:.12g}" for v in pose.positions[k, 0]] if j == 0 and positions else [""] * 3
            )
            turn = [f"{v:.12g}" for v in pose.rotations[k, j]]
            rows.append([f"{time:.12g}", names[role], *turn, *place])
    return rows


@pytest.fixture
def saved(tmp_path: Path):
    def read(rows: list[list], header=COMMA, mark: str = ",", **options) -> Clip:
        path = tmp_path / "suit.csv"
        lines = ["# a comment", mark.join(header), *(mark.join(map(str, row)) for row in rows)]
        path.write_text("\n".join(lines) + "\n")
        return read_orientations(path, **options)

    return read


def test_joint_rotations_are_inboard_transposed_times_outboard(saved):
    clip = person()
    back = saved(rows_of(clip))
    assert back.rate == clip.rate and back.frames == clip.frames
    assert rot.angle_between(back.rotations, clip.rotations).max() < 1e-9
    np.testing.assert_allclose(back.root_positions, clip.root_positions, atol=1e-9)
    assert back.notes == ()


@pytest.mark.parametrize("mark", [",", ";", "\t", ", "])
@pytest.mark.parametrize(
    "header",
    [COMMA, ("Timestamp [s]", "Link", "qw", "qx", "qy", "qz", "x", "y", "z")],
)
def test_headers_and_separators_may_differ(saved, mark, header):
    clip = person(5)
    back = saved(rows_of(clip), header=header, mark=mark)
    assert rot.angle_between(back.rotations, clip.rotations).max() < 1e-9
    np.testing.assert_allclose(back.root_positions, clip.root_positions, atol=1e-9)


@pytest.mark.parametrize(
    "rename",
    [
        lambda role: role,
        lambda role: LINKS[role].upper().replace("_", " "),
        lambda role: "".join(w.title() for w in LINKS[role].split("_")),
        lambda role: LINKS[role].replace("left_", "l_").replace("right_", "R-"),
    ],
)
def test_segments_go_by_link_or_joint_in_any_spelling(saved, rename):
    clip = person(5)
    back = saved(rows_of(clip, names={role: rename(role) for role in ROLES}))
    assert rot.angle_between(back.rotations, clip.rotations).max() < 1e-9


def test_uneven_samples_in_any_order_are_resampled(saved):
    fine = person(400, rate=100.0)
    rng = np.random.default_rng(0)
    rows = rows_of(fine)
    kept = [row for row in rows if float(row[0]) in (0.0, 3.99) or rng.random() < 0.7]
    rng.shuffle(kept)
    back = saved(kept, rate=50)
    assert back.rate == 50 and back.frames == 200
    # A gap h costs h^2 / 8 times the acceleration: .06 s and 8 rad/s2 on both segments, .4 degrees.
    assert np.degrees(rot.angle_between(back.rotations, fine.rotations[::2]).max()) < 0.5


def test_the_rate_is_that_of_the_samples(saved):
    rng = np.random.default_rng(1)
    clip = person(60, rate=15.0)
    times = clip.times + rng.uniform(-0.01, 0.01, 60)
    back = saved(rows_of(clip, times=np.sort(times)))
    assert back.rate == pytest.approx(15, rel=0.1)
    assert any("irregular" in note for note in back.notes)


def test_gaps_are_filled_and_reported(saved):
    rows = [
        row
        for row in rows_of(person(60))
        if not (row[1] == "left_hand" and 0.5 < float(row[0]) < 1.2)
    ]
    back = saved(rows)
    assert any("left_hand: 1 gaps" in note and "0.7" in note for note in back.notes)


def test_missing_segments_move_with_their_inboard_segment(saved):
    rows = [row for row in rows_of(person()) if row[1] not in ("left_toes", "abdomen")]
    back = saved(rows)
    assert rot.angle(back.joint("left_ball")).max() < 1e-9
    assert rot.angle(back.joint("lower_back")).max() < 1e-9
    # The chest keeps its measured world orientation.
    chest = back.skeleton.index("upper_back")
    there = person().forward_kinematics().rotations[:, chest]
    assert rot.angle_between(back.forward_kinematics().rotations[:, chest], there).max() < 1e-9
    assert any("No samples of abdomen, left_toes" in note for note in back.notes)


def test_without_positions_the_body_stays_on_the_ground(saved):
    back = saved(rows_of(person(), positions=False))
    pose = back.forward_kinematics()
    lowest = np.minimum(pose.positions[..., 2].min(1), pose.ends[..., 2].min(1))
    np.testing.assert_allclose(lowest, 0, atol=1e-12)
    np.testing.assert_allclose(back.root_positions[:, :2], 0)
    assert any("no positions" in note for note in back.notes)


def test_orientations_with_y_up_are_turned(saved):
    clip = person(5)
    pose = clip.forward_kinematics()
    turn = rot.conjugate([0.5, 0.5, 0.5, 0.5])  # x forward, y left, z up to z, x, y
    rows = []
    for k, time in enumerate(clip.times):
        place = rot.rotate(turn, pose.positions[k, 0]) * 100
        for j, role in enumerate(ROLES):
            q = rot.multiply(turn, rot.multiply(pose.rotations[k, j], rot.conjugate(turn)))
            rows.append([time, LINKS[role], *q, *(place if j == 0 else [""] * 3)])
    back = saved(rows, up="y", unit="cm")
    assert rot.angle_between(back.rotations, clip.rotations).max() < 1e-9
    np.testing.assert_allclose(back.root_positions, clip.root_positions, atol=1e-9)


@pytest.mark.parametrize(
    ("rows", "header", "message"),
    [
        (
            [[0, "left_nee", 1, 0, 0, 0]],
            COMMA[:6],
            r"csv:3: No segment named 'left_nee'.*'left_knee'",
        ),
        ([[0, "chest", 0, 0, 0, 0]], COMMA[:6], "csv:3: the quaternion is zero"),
        ([[0, "chest", 1, 0, "x", 0]], COMMA[:6], "csv:3: 'x' is not a usable number"),
        ([[0, "chest", 1, 0, "nan", 0]], COMMA[:6], "csv:3: 'nan' is not a usable number"),
        ([[0, "chest", 1, 0]], COMMA[:6], "csv:3: 4 columns are fewer"),
        ([[0, "chest", 1, 0, 0, 0]], ("time", "w", "x"), "csv:2: .* lacks segment, y, z"),
        ([], COMMA[:6], "holds no samples"),
        (
            [
                [0, "chest", 1, 0, 0, 0],
                [1e8, "chest", 1, 0, 0, 0],
                [1e8 + 0.01, "chest", 1, 0, 0, 0],
            ],
            COMMA[:6],
            "more than 1000000 frames|time must be in seconds",
        ),
        (
            [[0, "chest", 1, 0, 0, 0], [5, "pelvis", 1, 0, 0, 0]],
            COMMA[:6],
            "do not overlap",
        ),
    ],
)
def test_tables_that_do_not_fit_are_refused_with_their_line(saved, rows, header, message):
    options = {"rate": 100} if rows and rows[0][0] == 0 and len(rows) == 3 else {}
    with pytest.raises(ClipError, match=message):
        saved(rows, header=header, **options)
