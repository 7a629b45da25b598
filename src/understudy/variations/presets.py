"""Ready-made variations, each with ranges to draw from."""

from __future__ import annotations

from understudy.errors import UnknownName
from understudy.variations.body import Mass
from understudy.variations.change import Together
from understudy.variations.intent import Limp, Lock, Scaling, Speed, Strength

# Wilke & Semwal 2017, section 2.2: LeftFoot, LeftLeg, LHipJoint 5, 10, 20 and LeftHand,
# LeftForeArm, LeftArm 0.25, 2, 5, where each of the other bodies of their 31 has 1 unit.
_UNIT = 1.0 / 31.0
_ZOMBIE_UNITS = {
    "left_foot": 5.0,
    "left_shank": 10.0,
    "left_thigh": 20.0,
    "left_hand": 0.25,
    "left_forearm": 2.0,
    "left_upper_arm": 5.0,
}

# A body that stands on the ground folds under those; here the same side is heavier, less so.
_ZOMBIE_FACTORS = {
    "left_foot": 2.0,
    "left_shank": 2.0,
    "left_thigh": 1.5,
    "left_hand": 0.5,
    "left_forearm": 1.25,
    "left_upper_arm": 1.5,
}
_ZOMBIE_JOINTS = (
    Lock(joint="left_knee"),
    Lock(joint="left_wrist"),
    Limp(joint="left_ankle"),
    Strength(joint="left_elbow", by=(0.0, 0.2)),
    Strength(joint="left_shoulder", by=(0.1, 0.5)),
    Strength(joint="neck", by=(0.3, 0.6)),
)

PRESETS: dict[str, Together] = {
    # The paper's Table 4, and what its text says of it: one side significantly stronger.
    "stronger_left": Together(
        Scaling(joint="left_arm", by=(1.15, 1.6)),
        Scaling(joint="left_leg", by=(1.05, 1.2)),
        Scaling(joint="right_arm", by=(0.4, 0.8)),
        Scaling(joint="right_leg", by=(0.8, 0.95)),
        Strength(joint="left_arm", by=(1.2, 2.0)),
        Strength(joint="right_arm", by=(0.4, 0.9)),
        name="stronger_left",
    ),
    "tired": Together(
        Scaling(joint="arms", by=(0.4, 0.8)),
        Scaling(joint="legs", by=(0.8, 0.95)),
        Strength(joint="neck", by=(0.3, 0.6)),
        Strength(joint="back", by=(0.3, 0.6)),
        Strength(joint="arms", by=(0.05, 0.4)),
        Strength(joint="legs", by=(0.5, 0.9)),
        Speed(by=(0.75, 0.95)),
        name="tired",
    ),
    "limp_right_arm": Together(
        Limp(joint="right_arm"),
        Mass(link="right_arm", by=(0.7, 1.5)),
        Speed(by=(0.85, 1.2)),
        name="limp_right_arm",
    ),
    "heavy_boots": Together(
        Mass(link="left_foot", by=(4.0, 10.0)),
        Mass(link="right_foot", by=(4.0, 10.0)),
        name="heavy_boots",
    ),
    "zombie": Together(
        *(Mass(link=link, by=factor) for link, factor in _ZOMBIE_FACTORS.items()),
        *_ZOMBIE_JOINTS,
        name="zombie",
    ),
    # The paper, section 2.1, of a leg that was injured: less muscle there, more in the other.
    "injured_leg": Together(
        Scaling(joint="right_leg", by=(0.4, 0.8)),
        Strength(joint="right_leg", by=(0.25, 0.6)),
        Mass(link="right_thigh", by=(0.8, 0.95)),
        Mass(link="right_shank", by=(0.8, 0.95)),
        Strength(joint="left_leg", by=(1.0, 1.3)),
        Mass(link="left_thigh", by=(1.0, 1.1)),
        Speed(by=(0.8, 0.95)),
        name="injured_leg",
    ),
}

# What differs on linkages: nothing there has to stand, so the masses are the paper's own.
LINKAGE_PRESETS: dict[str, Together] = {
    "zombie": Together(
        *(Mass(link=link, share=_UNIT * units) for link, units in _ZOMBIE_UNITS.items()),
        *_ZOMBIE_JOINTS,
        name="zombie",
    ),
}


def preset(name: str, *, linkage: bool = False) -> Together:
    """A ready-made variation, with its ranges; for a linkage or for an articulated character.

    Raises:
        UnknownName: No preset of that name.
    """
    if name not in PRESETS:
        raise UnknownName("preset", name, PRESETS)
    return LINKAGE_PRESETS.get(name, PRESETS[name]) if linkage else PRESETS[name]
