"""The servo of Zordan & Hodgins 1999 lags by damping over stiffness; the modern law does not."""

import understudy as us

clip = us.sample("gesture")
character = us.Character.from_clip(clip, plan="upper")  # the paper simulates the upper body

for law in ("paper", "modern"):
    for stiffness in (300.0, 1000.0, 3000.0):
        take = us.track(clip, character, law=law, stiffness=stiffness)
        score = us.score(take)
        print(
            f"{law:<6} k = {stiffness:4.0f} /s^2: {score.joint_error_deg:5.2f} deg, "
            f"lag {score.lag_ms:4.0f} ms, hands {score.hands_mm:5.1f} mm"
        )
print("The paper's damping is a tenth of its stiffness: slow motion lags by 100 ms, however stiff,")
print("and a gesture, which is not slow everywhere, by about as much.")
