"""What counts as far off."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.control.guidance_law import DEVIATION, POSTURE
from understudy.free_tracking.goal import Goal


@pytest.fixture
def goal() -> Goal:
    return Goal(
        marks=np.zeros((1, POSTURE)),
        rotations=np.zeros((1, 1, 4)),
        coordinates=slice(0, 11),
        scales=np.ones(DEVIATION),
        cost=np.eye(DEVIATION),
        mass=70.0,
        size=1.0,
    )


def test_a_jerk_of_the_clip_is_no_displacement(goal: Goal) -> None:
    off = np.zeros((3, DEVIATION))
    off[0, 3:9] = off[0, 12:15] = 30.0  # velocities and momentum alone
    off[1, :3] = 3.0, 4.0, 0.0
    off[2, 9:12] = 0.0, 6.0, 8.0
    assert goal.displacements(off) == pytest.approx([0.0, 25.0, 100.0])
    assert goal.costs(off)[0] > 2000.0
