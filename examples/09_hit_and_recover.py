"""A shove and a thrown ball: the body gives way and comes back to the clip."""

import numpy as np

import understudy as us
from understudy.control import GiveWay, Push, Throw
from understudy.evaluate import compare, contact_events
from understudy.scene import Ball

clip = us.sample("gesture")
shove = Push(time=1.5, on="chest", impulse=(-60.0, 30.0, 0.0))
throw = Throw(time=3.6, ball="ball", at="chest", flight=0.4)
take = us.track(
    clip,
    us.Character.from_clip(clip),
    props=[Ball(position=(3.0, 0.5, 1.5), mass=2.0)],
    contacts=[("ball", part) for part in ("chest", "abdomen", "head")],
    tasks=[shove, throw, GiveWay.after(shove, throw)],
)
found = compare.compared(take.clip(), take.references[0])
away = np.degrees(found.joint_angles.max(axis=1))
for name, at in (("shove", 1.5), ("ball", 3.6)):
    during = away[(found.times > at) & (found.times < at + 1.0)].max()
    later = away[np.argmin(np.abs(found.times - at - 1.5))]
    print(f"{name}: up to {during:.0f} degrees off the clip, {later:.1f} left 1.5 s later")
for event in contact_events(take, "ball"):
    if "ground" not in event.between:
        print(f"{event.between[1]} hit at {event.start_s:.2f} s: {event.impulse_ns:.1f} N s")
us.write(take, "hit.html")
