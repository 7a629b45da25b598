"""A task on top of a clip: the wrist keeps a staff upright; somebody knocks it."""

import numpy as np

import understudy as us
from understudy.control import LookAt, Push, Upright
from understudy.motion import rotations as rot
from understudy.scene import Staff

clip = us.sample("staff")
character = us.Character.from_clip(clip)
staff = Staff(length=1.5, mass=0.8, grip=0.4)
knock = Push(time=3.0, on="staff", impulse=(2.0, 4.0, 0.0))


def tilt(take: us.Take) -> np.ndarray:
    """Angle of the staff from vertical at every frame [deg]."""
    _, _, turned = take.poses(rate=60.0)
    axis = rot.rotate(turned[:, take.model.body("staff").id], np.array([0.0, 0.0, 1.0]))
    return np.degrees(np.arccos(np.clip(axis[:, 2], -1.0, 1.0)))


captured = us.track(clip, character, props=[staff])
held = us.track(
    clip, character, props=[staff], tasks=[Upright(), LookAt(target="staff/head"), knock]
)
print(f"with the clip's own wrist the staff tilts by up to {tilt(captured).max():.0f} degrees")
print(f"held upright and knocked: {tilt(held)[60:].max():.0f}; at the end {tilt(held)[-1]:.1f}")
us.write(held, "staff.html", "staff_sim.bvh")
