"""What joint names say: a side, and which role a person's joint could have.

One table of words for the dialects in use: MotionBuilder and HumanIK, the 3ds Max conversion, DAZ,
Acclaim, SMPL, Biped, Unreal, Blender, Xsens. A word may fit several roles ("foot" is the ankle in
most files and the ball of the foot in SMPL); topology then decides.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

# Kinds of joint each word may name, best first. A kind is a role without its side; "collar", "hand"
# (a wrist, unless another joint is called that) and "finger" are none, and say so.
WORDS: dict[str, tuple[str, ...]] = {
    "hips": ("pelvis",),
    "pelvis": ("pelvis",),
    "hip": ("hip", "pelvis"),
    "root": ("pelvis",),
    "hipjoint": (),
    "buttock": (),
    "upleg": ("hip",),
    "upperleg": ("hip",),
    "legupper": ("hip",),
    "thigh": ("hip",),
    "femur": ("hip",),
    "leg": ("knee", "hip"),
    "lowleg": ("knee",),
    "lowerleg": ("knee",),
    "leglower": ("knee",),
    "knee": ("knee",),
    "shin": ("knee",),
    "shank": ("knee",),
    "calf": ("knee",),
    "tibia": ("knee",),
    "ankle": ("ankle",),
    "foot": ("ankle", "ball"),
    "toe": ("ball",),
    "toes": ("ball",),
    "toebase": ("ball",),
    "ball": ("ball",),
    "forefoot": ("ball",),
    "collar": ("collar",),
    "clavicle": ("collar",),
    "scapula": ("collar",),
    "shoulder": ("shoulder", "collar"),
    "shldr": ("shoulder",),
    "arm": ("shoulder",),
    "uparm": ("shoulder",),
    "upperarm": ("shoulder",),
    "armupper": ("shoulder",),
    "humerus": ("shoulder",),
    "elbow": ("elbow",),
    "forearm": ("elbow",),
    "lowarm": ("elbow",),
    "lowerarm": ("elbow",),
    "armlower": ("elbow",),
    "radius": ("elbow",),
    "ulna": ("elbow",),
    "wrist": ("wrist",),
    "hand": ("hand", "wrist"),
    "lowerback": ("spine",),
    "upperback": ("spine",),
    "spine": ("spine",),
    "abdomen": ("spine",),
    "belly": ("spine",),
    "waist": ("spine",),
    "torso": ("spine",),
    "back": ("spine",),
    "chest": ("spine",),
    "thorax": ("spine",),
    "ribcage": ("spine",),
    "neck": ("neck",),
    "lowerneck": ("neck",),
    "upperneck": ("neck",),
    "head": ("head",),
    "skull": ("head",),
    "eye": ("finger",),
    "jaw": ("finger",),
    "thumb": ("finger",),
    "finger": ("finger",),
    "fingers": ("finger",),
    "fingerbase": ("finger",),
    "handindex": ("finger",),
    "handend": ("finger",),
    "index": ("finger",),
    "pinky": ("finger",),
    "ring": ("finger",),
    "middle": ("finger",),
    "mid": ("finger",),
}

_SIDE = re.compile(
    r"(?P<word>[Ll]eft|LEFT|[Rr]ight|RIGHT)|^(?P<letter>[lrLR])(?=[A-Z_. -])"
    r"|(?<=[_. -])(?P<last>[lrLR])(?=$|[_. -])|(?<=[a-z0-9])(?P<camel>[LR])$"
)
_LOWER_SIDE = re.compile(r"^(?P<letter>[lr])(?=[a-z])")


@dataclass(frozen=True)
class Hint:
    """What a name says.

    Attributes:
        side: "left", "right" or "".
        kinds: Kinds it may name, best first; empty when it says nothing.
    """

    side: str
    kinds: tuple[str, ...]


def hints(names: Sequence[str]) -> tuple[Hint, ...]:
    """A hint per joint name; prefixes all names share ("mixamorig:", "Bip01 ") are ignored."""
    bare = [name.split(":")[-1].split("|")[-1] for name in names]
    shared = ""
    if len(bare) > 1:
        first, last = min(bare), max(bare)
        same = next((i for i, c in enumerate(first) if last[i : i + 1] != c), len(first))
        shared = first[:same]
    shared = shared if re.search(r"[_ .-]$|^mixamorig\d*$", shared) else ""
    return tuple(_hint(name[len(shared) :]) for name in bare)


def _hint(name: str) -> Hint:
    name = re.sub(r"^(Bip\d*|bip\d+)[ _]", "", name)
    found = _SIDE.search(name)
    if found is not None:
        text = found.group().lower()
        rest = name[: found.start()] + " " + name[found.end() :]
        kinds = _kinds(rest)
        if kinds is not None or found["word"]:
            return Hint("left" if text[0] == "l" else "right", kinds or ())
    kinds = _kinds(name)
    if kinds is not None:
        return Hint("", kinds)
    found = _LOWER_SIDE.match(name)  # Acclaim: lfemur, rhumerus
    if found is not None:
        kinds = _kinds(name[1:])
        if kinds is not None:
            return Hint("left" if found["letter"] == "l" else "right", kinds)
    return Hint("", ())


def _kinds(text: str) -> tuple[str, ...] | None:
    """Kinds of a name without its side; None for a word not in the table."""
    word = re.sub(r"[^a-z]", "", text.lower())
    if word in WORDS:
        return WORDS[word]
    parts = [p.lower() for p in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", text)]
    # Helpers beside the real joint ("upperarm_twist_01_l", "foot_ik_l") are no joints of a person.
    if any(p in ("twist", "roll", "ik", "end", "nub", "site", "helper") for p in parts):
        return ("finger",)
    if any(WORDS.get(p) == ("finger",) for p in parts):
        return ("finger",)
    for first in range(len(parts)):
        for last in range(len(parts), first, -1):
            joined = "".join(parts[first:last])
            if joined in WORDS:
                return WORDS[joined]
    return None
