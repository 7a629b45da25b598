"""A runner without a clip: along a path, with a clip's arms, beside people, and a second one."""

import numpy as np

import understudy as us
from understudy.athletics.course import Course
from understudy.character import adult_woman, athlete_man, athlete_woman
from understudy.evaluate.gait import gait_of
from understudy.evaluate.layered import layered
from understudy.evaluate.running import likeness
from understudy.performance import running, together
from understudy.running_report import write_running

# A wave of a path, run at 3 m/s; the woman in the lane to the right of the man.
x = np.linspace(0.0, 30.0, 100)
course = Course.along(np.column_stack((x, 1.0 - np.cos(x / 8.0))), 3.0)
man = running(athlete_man(), course, duration=5.0, upper=us.sample("gesture"))
woman = running(athlete_woman(), course.beside(1.22), duration=5.0)
take = us.simulate(together(man, woman))

arms = layered(take)
print(f"arms follow {arms.clip} within {arms.joint_error_deg:.1f} degrees rms")
for k, who in enumerate(("man", "woman")):
    gait = gait_of(take, character=k, start=1.0, name=who)
    knee = likeness(gait).curves["knee"]
    print(f"{who}: {gait.speed:.2f} m/s, {gait.figures()['step_rate_hz'].mean:.2f} steps a second,")
    print(f"  knee correlates {knee.correlation:.2f} with people's over the cycle")
write_running(gait_of(take, character=1, start=1.0), "woman.html")

# What ran is a clip like any other: another body tracks it.
tracked = us.track(take.clip(1), adult_woman())
print(f"tracked within {us.score(tracked).joint_error_deg:.1f} degrees rms")
us.write(take, "run.bvh", "run.html")
