"""One motion, four bodies: the same gesture with other masses and proportions."""

import understudy as us
from understudy.character import adult_man, adult_woman, alien, child

clip = us.sample("gesture")
for body in (adult_woman(), adult_man(), child(), alien()):
    take = us.track(clip, body)  # joint rotations go over by role, feet stay on the ground
    score = us.score(take)
    print(
        f"{body.name:<12} {body.mass:5.1f} kg  joints {score.joint_error_deg:.2f} deg, "
        f"peak torque {score.torque_peak_nm:3.0f} N m at {score.torque_peak_joint}"
    )
    us.write(take, f"gesture_{body.name}.glb")
