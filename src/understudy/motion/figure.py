"""The standard figure: a person's skeleton from published proportions.

It gives motion without a skeleton of its own (keyframed samples, segment orientations) something to
move, and the ready-made characters their bones. Neutral T-pose, facing +x, left +y, up +z.
"""

from __future__ import annotations

import numpy as np

from understudy.errors import InvalidValue
from understudy.motion.skeleton import Skeleton

ROLES = (
    "pelvis",
    "lower_back",
    "upper_back",
    "neck",
    "left_shoulder",
    "left_elbow",
    "left_wrist",
    "right_shoulder",
    "right_elbow",
    "right_wrist",
    "left_hip",
    "left_knee",
    "left_ankle",
    "left_ball",
    "right_hip",
    "right_knee",
    "right_ankle",
    "right_ball",
)

LINKS = {
    "pelvis": "pelvis",
    "lower_back": "abdomen",
    "upper_back": "chest",
    "neck": "head",
    "left_shoulder": "left_upper_arm",
    "left_elbow": "left_forearm",
    "left_wrist": "left_hand",
    "right_shoulder": "right_upper_arm",
    "right_elbow": "right_forearm",
    "right_wrist": "right_hand",
    "left_hip": "left_thigh",
    "left_knee": "left_shank",
    "left_ankle": "left_foot",
    "left_ball": "left_toes",
    "right_hip": "right_thigh",
    "right_knee": "right_shank",
    "right_ankle": "right_foot",
    "right_ball": "right_toes",
}

PARENTS = {
    "lower_back": "pelvis",
    "upper_back": "lower_back",
    "neck": "upper_back",
    **{
        f"{side}_{joint}": parent if parent in ("pelvis", "upper_back") else f"{side}_{parent}"
        for side in ("left", "right")
        for joint, parent in (
            ("shoulder", "upper_back"),
            ("elbow", "shoulder"),
            ("wrist", "elbow"),
            ("hip", "pelvis"),
            ("knee", "hip"),
            ("ankle", "knee"),
            ("ball", "ankle"),
        )
    },
}

# Heights of joint centers and lengths as fractions of stature H: Drillis & Contini 1966 as printed
# in Winter, Biomechanics and Motor Control of Human Movement, 4th ed. 2009, figure 4.1 (hip .530,
# knee .285, ankle .039, shoulder .818, upper arm .186, forearm .146, hand .108, foot .152 long).
# Lengths of the trunk parts follow de Leva 1996 (xiphoid and navel between hip and C7).
_HIP, _KNEE, _ANKLE, _SHOULDER = 0.530, 0.285, 0.039, 0.818
_UPPER_ARM, _FOREARM, _HAND, _FOOT = 0.186, 0.146, 0.108, 0.152
# Half the distance of the hip centers: .191 H is the skin width over the hips; joint centers lie at
# about half of it. Half the distance of the shoulder centers, likewise from the .259 H skin width.
_HALF_HIPS = {"male": 0.049, "female": 0.053}
_HALF_SHOULDERS = {"male": 0.104, "female": 0.098}


def plain_name(name: str) -> str:
    """A joint's or link's name as a person says it: `left_ball` is the ball of the left foot."""
    if name in ("left_ball", "right_ball"):
        return f"ball of {name.partition('_')[0]} foot"
    return name.replace("_", " ")


def figure(height: float = 1.75, sex: str = "male") -> Skeleton:
    """A person's skeleton in a neutral T-pose, feet flat on z = 0, facing +x.

    Args:
        height: Stature [m].
        sex: "male" or "female".

    Raises:
        InvalidValue: Height outside 0.3 to 3 m, or another sex.
    """
    if not 0.3 <= height <= 3.0:
        raise InvalidValue(f"height is {height} m; it must lie between 0.3 and 3.")
    if sex not in _HALF_HIPS:
        raise InvalidValue(f"sex is {sex!r}; the published tables have 'male' and 'female'.")
    hips, shoulders = _HALF_HIPS[sex], _HALF_SHOULDERS[sex]
    offsets = {
        "pelvis": (0.0, 0.0, _HIP + 0.020),
        "lower_back": (0.0, 0.0, 0.045),
        "upper_back": (0.0, 0.0, 0.095),
        "neck": (0.0, 0.0, _SHOULDER + 0.030 - _HIP - 0.160),
    }
    ends: list[tuple[str, tuple[float, float, float]]] = [("neck", (0.0, 0.0, 1.0 - 0.848))]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        offsets |= {
            f"{side}_shoulder": (0.0, sign * shoulders, _SHOULDER - _HIP - 0.160),
            f"{side}_elbow": (0.0, sign * _UPPER_ARM, 0.0),
            f"{side}_wrist": (0.0, sign * _FOREARM, 0.0),
            f"{side}_hip": (0.0, sign * hips, -0.020),
            f"{side}_knee": (0.0, 0.0, _KNEE - _HIP),
            f"{side}_ankle": (0.0, 0.0, _ANKLE - _KNEE),
            # The ankle center lies about a quarter of the foot's length ahead of the heel.
            f"{side}_ball": (0.45 * _FOOT, 0.0, 0.012 - _ANKLE),
        }
        ends += [
            (f"{side}_wrist", (0.0, sign * _HAND, 0.0)),
            (f"{side}_ball", (0.30 * _FOOT, 0.0, -0.002)),
        ]
    return Skeleton(
        names=ROLES,
        parents=tuple(-1 if r == "pelvis" else ROLES.index(PARENTS[r]) for r in ROLES),
        offsets=np.array([offsets[r] for r in ROLES]) * height,
        end_joints=tuple(ROLES.index(r) for r, _ in ends),
        end_offsets=np.array([v for _, v in ends]) * height,
    )
