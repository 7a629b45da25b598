"""Make a simulated body perform a motion, and say how well it did."""

import understudy as us

clip = us.sample("gesture")  # or us.read("walk.bvh")
character = us.Character.from_clip(clip)  # its own bones; mass and inertia from anthropometry
take = us.track(clip, character)
print(us.score(take))  # degrees, millimeters, ms of lag, help in % of body weight
us.write(take, "gesture_sim.bvh", "gesture_sim.glb")
us.write_report(take, "gesture.html")  # scores, plots and a 3D player
