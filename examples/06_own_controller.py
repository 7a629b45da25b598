"""Add a controller of your own, in plain Python, to a performance: a push on the chest."""

from dataclasses import replace

import mujoco
import numpy as np

import understudy as us
from understudy.control import PythonController

clip = us.sample("gesture").trimmed(0.0, 3.0)
character = us.Character.from_clip(clip)
performance = us.tracked(clip, character)
model = performance.scene.model
chest = model.body("chest").id


def push(time: float, data: mujoco.MjData) -> None:
    """Push the chest backward with 200 N for a tenth of a second."""
    if 1.0 <= time < 1.1:
        force, torque, point = np.array([-200.0, 0.0, 0.0]), np.zeros(3), data.xipos[chest]
        mujoco.mj_applyFT(model, data, force, torque, point, chest, data.qfrc_applied)


pushed = replace(
    performance,
    controllers=(*performance.controllers, PythonController(function=push, period=0.01)),
)
quiet, shoved = us.simulate(performance), us.simulate(pushed)
neck = character.skeleton.index("neck")
paths = [take.clip().forward_kinematics().positions[:, neck] for take in (quiet, shoved)]
away = 1e3 * np.linalg.norm(paths[1] - paths[0], axis=1)
print(f"the push moves the neck by up to {away.max():.0f} mm")
print(f"{away[-1]:.1f} mm are left {quiet.duration - 1.1:.1f} s later")
us.write(shoved, "shoved.glb")
