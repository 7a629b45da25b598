"""CSV out: positions and angles under headers that say what they are."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from texts import person

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.table import write_csv


@pytest.mark.parametrize("order", ["ZXY", "XYZ"])
def test_the_table_holds_positions_in_meters_and_angles_in_degrees(tmp_path, order):
    clip = person()
    write_csv(clip, tmp_path / "a.csv", order=order)
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert len(rows) == clip.frames
    table = {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}
    np.testing.assert_allclose(table["time"], clip.times, atol=1e-6)
    j = clip.skeleton.index("left_wrist")
    for k, axis in enumerate("xyz"):
        expected = clip.forward_kinematics().positions[:, j, k]
        np.testing.assert_allclose(table[f"left_wrist.{axis}"], expected, atol=1e-6)
    angles = np.radians(np.stack([table[f"left_knee.{axis}"] for axis in order], axis=1))
    apart = rot.angle_between(rot.from_euler(order, angles), clip.joint("left_knee"))
    assert apart.max() < 1e-7


def test_an_order_without_three_axes_is_refused(tmp_path):
    with pytest.raises(InvalidValue, match="ZXZ"):
        write_csv(person(2), tmp_path / "a.csv", order="ZXZ")
