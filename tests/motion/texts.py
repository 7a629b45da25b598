"""Small motion files made by hand for the tests of the readers."""

from __future__ import annotations

from typing import Any

import numpy as np

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import figure

TWO_JOINTS = """HIERARCHY
ROOT Hips
{
    OFFSET 0 90 0
    CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
    JOINT Chest
    {
        OFFSET 0 20 0
        CHANNELS 3 Yrotation Xrotation Zrotation
        End Site
        {
            OFFSET 0 30 0
        }
    }
}
MOTION
Frames: 3
Frame Time: 0.0333333
1 91 2 10 20 30 40 50 60
1 91 3 11 21 31 41 51 61
1 91 4 12 22 32 42 52 62
"""


def person(frames: int = 40, rate: float = 30.0, seed: int = 3, **options: Any) -> Clip:
    """The standard figure moving smoothly along x."""
    rng = np.random.default_rng(seed)
    skeleton = figure(1.75)
    times = np.arange(frames) / rate
    turn = 0.3 * np.sin(4 * times[:, None, None] + rng.uniform(0, 6, (len(skeleton), 3)))
    path = skeleton.offsets[0] + np.stack((times, 0.1 * times, 0.01 * np.sin(9 * times)), axis=1)
    return Clip(
        skeleton=skeleton,
        rotations=rot.from_rotvec(turn),
        root_positions=path,
        rate=rate,
        **options,
    )
