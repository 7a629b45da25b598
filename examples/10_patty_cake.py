"""One adult's clip, two children: inverse kinematics makes hands meet, contact does the rest."""

import numpy as np

import understudy as us
from understudy.character import child
from understudy.evaluate import contact_events
from understudy.motion.reaching import Meet, meeting
from understudy.performance import together, tracked

HANDS = {
    "right": [("right_wrist", "right_wrist")],
    "left": [("left_wrist", "left_wrist")],
    "both": [("right_wrist", "left_wrist"), ("left_wrist", "right_wrist")],
}
CLAPS = {1.0: "right", 2.0: "left", 3.0: "both", 4.0: "right", 5.0: "both"}  # of the sample

clip, body = us.sample("patty_cake"), child()
here = us.retargeted(clip, body)
there = us.retargeted(clip.placed(at=(0.62, 0.0), heading=np.pi), body)
meets = [Meet(time=time, hands=pair) for time, kind in CLAPS.items() for pair in HANDS[kind]]
here, there = meeting(here, there, meets)

speed = 1.33
take = us.simulate(
    together(
        tracked(here.retimed(speed), body),
        tracked(there.retimed(speed), body),
        contacts=[
            (f"{a}_hand", f"b/{b}_hand") for a in ("left", "right") for b in ("left", "right")
        ],
    )
)
for time, kind in CLAPS.items():
    events = [
        event
        for event in contact_events(take)
        if "hand" in event.between[0]
        and "hand" in event.between[1]
        and abs(event.start_s - time / speed) < 0.1
    ]
    print(f"{time / speed:.2f} s, {kind}: " + ", ".join(" and ".join(e.between) for e in events))
us.write(take, "patty_cake.html")
