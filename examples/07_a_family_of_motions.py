"""Vary one motion: a limp arm by hand, then a small family with what each member cost."""

import understudy as us
from understudy.variations import Grip, Limp, Mass, Scaling, Together

clip = us.sample("walk").trimmed(0.5, 2.0)
walk = us.tracked(clip, us.Character.from_clip(clip))

# A variation makes a performance of a performance. A loose grip lets its effects spread.
limp = Together(Grip(to=0.5), Limp(joint="right_arm"))
errors = us.score(us.simulate(limp(walk))).joint_errors_deg
print(f"limp right arm: shoulder {errors['right_shoulder']:.0f} deg from the clip, ", end="")
print(f"left shoulder {errors['left_shoulder']:.1f} deg")

# Ranges are drawn from; members take the alternatives in turn, the same from the same seed.
boots = Together(
    Mass(link="left_foot", by=(3.0, 8.0)), Mass(link="right_foot", by=(3.0, 8.0)), name="boots"
)
swing = Together(Scaling(joint="arms", by=(1.2, 1.8)), name="swing")
family = us.family(walk, 6, seed=7, variations=["zombie", boots, swing], out="walk_family")
for member in family.members:
    print(
        f"{member.name:<12} {member.away_mm:4.0f} mm away, "
        f"torque x {member.total['torque_ratio']:.2f}, "
        f"most in {member.total['most_changed']}; {', '.join(member.flags) or 'no flag'}"
    )
print(f"{sum(bool(m.flags) for m in family.members)} flagged; open walk_family/family.html")
