"""Skeletons for the tests: the standard figure under the names of several dialects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import ROLES, figure
from understudy.motion.skeleton import Skeleton

SIDED = ("shoulder", "elbow", "wrist", "hip", "knee", "ankle", "ball")
MIDDLE = ("pelvis", "lower_back", "upper_back", "neck")


def _sided(pattern: str, words: str) -> dict[str, str]:
    """Names of the sided joints: "{S}" is Left or Right, "{s}" l or r, "{L}" L or R."""
    out = {}
    for side in ("left", "right"):
        for kind, word in zip(SIDED, words.split(), strict=True):
            out[f"{side}_{kind}"] = pattern.format(
                word, S=side.capitalize(), s=side[0], L=side[0].upper(), side=side
            )
    return out


def _middle(words: str) -> dict[str, str]:
    return dict(zip(MIDDLE, words.split(), strict=True))


DIALECTS: dict[str, dict[str, str]] = {
    "motionbuilder": _middle("Hips Spine Spine1 Neck")
    | _sided("{S}{0}", "Arm ForeArm Hand UpLeg Leg Foot ToeBase"),
    "mixamo": _middle("mixamorig:Hips mixamorig:Spine mixamorig:Spine1 mixamorig:Head")
    | _sided("mixamorig:{S}{0}", "Arm ForeArm Hand UpLeg Leg Foot ToeBase"),
    "3dsmax": _middle("Hips lowerback Chest2 Head")
    | _sided("{S}{0}", "Shoulder Elbow Wrist Hip Knee Ankle Toe"),
    "daz": _middle("hip abdomen chest head")
    | _sided("{s}{0}", "Shldr ForeArm Hand Thigh Shin Foot Toe"),
    "acclaim": _middle("root lowerback thorax head")
    | _sided("{s}{0}", "humerus radius wrist femur tibia foot toes"),
    "biped": _middle("Bip01_Pelvis Bip01_Spine Bip01_Spine1 Bip01_Head")
    | _sided("Bip01 {L} {0}", "UpperArm Forearm Hand Thigh Calf Foot Toe0"),
    "unreal": _middle("pelvis spine_01 spine_03 head")
    | _sided("{0}_{s}", "upperarm lowerarm hand thigh calf foot ball"),
    "blender": _middle("hips spine chest head")
    | _sided("{0}.{L}", "upper_arm forearm hand thigh shin foot toe"),
    "smpl": _middle("pelvis spine1 spine3 head")
    | _sided("{side}_{0}", "shoulder elbow wrist hip knee ankle foot"),
    "meaningless": {role: f"j{i:02d}" for i, role in enumerate(ROLES)},
}


def renamed(skeleton: Skeleton, names: dict[str, str]) -> Skeleton:
    return replace(skeleton, names=tuple(names.get(n, n) for n in skeleton.names))


def without(skeleton: Skeleton, *gone: str) -> Skeleton:
    """The skeleton less some joints and all outboard of them; ends take their place."""
    dropped = {skeleton.index(n) for n in gone}
    ends = [(j, o) for j, o in zip(skeleton.end_joints, skeleton.end_offsets, strict=True)]
    ends += [(skeleton.parents[j], skeleton.offsets[j]) for j in dropped]
    for i, p in enumerate(skeleton.parents):
        if p in dropped:
            dropped.add(i)
    kept = [i for i in range(len(skeleton)) if i not in dropped]
    ends = [(kept.index(j), o) for j, o in ends if j in kept]
    return Skeleton(
        names=tuple(skeleton.names[i] for i in kept),
        parents=tuple(kept.index(skeleton.parents[i]) if i else -1 for i in kept),
        offsets=skeleton.offsets[kept],
        end_joints=tuple(j for j, _ in ends),
        end_offsets=np.array([o for _, o in ends]).reshape(-1, 3),
    )


def still(skeleton: Skeleton, frames: int = 1) -> Clip:
    """The rest pose, held."""
    return Clip(
        skeleton=skeleton,
        rotations=rot.identity(frames, len(skeleton)),
        root_positions=np.repeat(skeleton.offsets[:1], frames, axis=0),
        rate=30.0,
        name="still",
    )


def moving(skeleton: Skeleton, *, frames: int = 40, seed: int = 0, size: float = 0.5) -> Clip:
    """Every joint swings smoothly, its phases drawn from a seed; the root travels."""
    random = np.random.default_rng(seed)
    t = np.linspace(0.0, 2 * np.pi, frames)
    phase = random.uniform(0, 2 * np.pi, (len(skeleton), 3))
    vectors = size * np.sin(t[:, None, None] + phase)
    path = skeleton.offsets[0] + np.stack([0.3 * t, 0.1 * np.sin(t), 0.02 * np.cos(t)], axis=-1)
    return Clip(
        skeleton=skeleton,
        rotations=rot.from_rotvec(vectors),
        root_positions=path,
        rate=30.0,
        name="moving",
    )


def person(**options: float) -> Skeleton:
    return figure(**options)
