"""Edit a clip, then let physics perform the edit: faster, and with the other hand."""

import understudy as us

clip = us.sample("gesture")
character = us.Character.from_clip(clip)

edits = {
    "as made": clip,
    "a third faster": clip.retimed(1.33),
    "mirrored": clip.mirrored(),
    "both": clip.mirrored().retimed(1.33),
}
for name, edited in edits.items():
    take = us.track(edited, character)
    score = us.score(take)
    print(
        f"{name:<15} {take.duration:.2f} s, joints {score.joint_error_deg:.2f} deg, "
        f"power {score.power_mean_w:3.0f} W, peak torque {score.torque_peak_nm:3.0f} N m"
    )

again = us.track(take.clip(), character)  # what was simulated can be tracked again
print(f"tracked again: {us.score(again).joint_error_deg:.2f} deg from the first take")
