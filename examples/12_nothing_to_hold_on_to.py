"""A walk with nothing to hold on to, then shoved: the body answers with its feedback."""

from dataclasses import replace

import understudy as us
from understudy.control import Push
from understudy.evaluate import following

clip = us.sample("walk").trimmed(0.5, 1.7)
take = us.track(clip, us.Character.from_clip(clip), pelvis="free")
found = following(take)
print(f"free: {found.free}; center of mass {found.com_mm:.0f} mm off, root mean square")

for force in (50.0, 100.0):  # for 0.1 s
    push = Push(time=0.4, on="pelvis", impulse=(0.0, 0.1 * force, 0.0))
    performance = take.performance
    shoved = us.simulate(replace(performance, controllers=(*performance.controllers, push)))
    lost = following(shoved).lost_s
    print(f"{force:.0f} N: {'kept its feet' if lost is None else f'lost at {lost:.2f} s'}")
us.write(take, "free.html")
