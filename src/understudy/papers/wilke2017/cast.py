"""Which clips play the paper's five, and their joints under the paper's names."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from understudy.character.roles import find_roles
from understudy.errors import ClipError, InvalidValue, UnderstudyError
from understudy.motion.clip import Clip
from understudy.motion.fetch import fetch, fetchable
from understudy.motion.read import read
from understudy.motion.samples import sample


@dataclass(frozen=True, kw_only=True)
class Part:
    """One of the paper's clips, and who may stand in for it.

    Attributes:
        file: The paper's file, by its CMU number.
        motion: What it shows, as far as the paper says.
        standins: CMU numbers of similar motions, best first.
        sample: Bundled sample for when there is no other.
    """

    file: str
    motion: str
    standins: tuple[str, ...]
    sample: str


# Section 2 says what 08, 14, 15 and 30 show; 02 is seen walking or running in figures 3 and 9.
PARTS = (
    Part(file="141_02", motion="run", standins=("127_03", "35_17", "02_03"), sample="walk"),
    Part(
        file="141_08",
        motion="step up and down",
        standins=("14_21", "16_31", "02_01"),
        sample="walk",
    ),
    Part(file="141_14", motion="punch and kick", standins=("135_04", "02_05"), sample="gesture"),
    Part(
        file="141_15",
        motion="range of motion",
        standins=("02_10", "127_02", "02_05"),
        sample="clapping",
    ),
    Part(file="141_30", motion="random walk", standins=("09_12", "29_01"), sample="walk"),
)

# The joints of the CMU skeletons: in Acclaim files and in their conversion to BVH.
_ACCLAIM = {
    "root": "Hips",
    "lhipjoint": "LHipJoint",
    "lfemur": "LeftUpLeg",
    "ltibia": "LeftLeg",
    "lfoot": "LeftFoot",
    "ltoes": "LeftToeBase",
    "rhipjoint": "RHipJoint",
    "rfemur": "RightUpLeg",
    "rtibia": "RightLeg",
    "rfoot": "RightFoot",
    "rtoes": "RightToeBase",
    "lowerback": "LowerBack",
    "upperback": "Spine",
    "thorax": "Spine1",
    "lowerneck": "Neck",
    "upperneck": "Neck1",
    "head": "Head",
    "lclavicle": "LeftShoulder",
    "lhumerus": "LeftArm",
    "lradius": "LeftForeArm",
    "lwrist": "LeftHand",
    "lhand": "LeftFingerBase",
    "lfingers": "LeftHandIndex1",
    "lthumb": "LThumb",
    "rclavicle": "RightShoulder",
    "rhumerus": "RightArm",
    "rradius": "RightForeArm",
    "rwrist": "RightHand",
    "rhand": "RightFingerBase",
    "rfingers": "RightHandIndex1",
    "rthumb": "RThumb",
}
_ROLES = {
    "pelvis": "Hips",
    "lower_back": "Spine",
    "upper_back": "Spine1",
    "neck": "Head",
    **{
        f"{side}_{role}": f"{side.title()}{name}"
        for side in ("left", "right")
        for role, name in (
            ("hip", "UpLeg"),
            ("knee", "Leg"),
            ("ankle", "Foot"),
            ("ball", "ToeBase"),
            ("shoulder", "Arm"),
            ("elbow", "ForeArm"),
            ("wrist", "Hand"),
        )
    },
}
_NEEDED = frozenset({"Hips", "RightFoot", "LeftFoot", "LeftLeg", "LeftHand", "RightHand", "Head"})


def with_paper_names(clip: Clip) -> Clip:
    """The clip with its joints under the names of the paper's files, as far as it has them.

    Raises:
        InvalidValue: The clip's skeleton is not a person's.
    """
    names = clip.skeleton.names
    if set(names) >= _NEEDED:
        return clip
    new = tuple(_ACCLAIM.get(name, name) for name in names)
    if not set(new) >= _NEEDED:
        known = {found.joint: _ROLES.get(found.role) for found in find_roles(clip).found}
        new = tuple(known.get(name) or name for name in names)
    if not set(new) >= _NEEDED or len(set(new)) < len(new):
        raise InvalidValue(f"The clip {clip.name!r} has no joints that play those of the paper.")
    return replace(clip, skeleton=replace(clip.skeleton, names=new))


@dataclass(frozen=True, kw_only=True)
class Cast:
    """Who plays what.

    Attributes:
        clips: By the paper's file name, joints under the paper's names.
        sources: What was read for each: a file's name, or sample:NAME.
        own: The paper's files that are there themselves.
    """

    clips: dict[str, Clip] = field(repr=False)
    sources: dict[str, str]
    own: frozenset[str]


def casting(folder: Path | None, *, seconds: float | None = None, online: bool = False) -> Cast:
    """Find the paper's clips, or stand-ins, in a folder and below it.

    Args:
        folder: Where to look; None for the bundled samples alone.
        seconds: Keep only so much of the beginning of each clip [s].
        online: Download what is missing, where a public source is known.

    Raises:
        ClipError: No such folder.
    """
    if folder is not None and not folder.is_dir():
        raise ClipError(str(folder), "no such folder.")
    clips, sources, own = {}, {}, set()
    for part in PARTS:
        clip, source, number = _found(part, folder, online)
        if seconds is not None and clip.duration > seconds:
            clip = clip.trimmed(0.0, seconds)
        clips[part.file], sources[part.file] = with_paper_names(clip).renamed(source), source
        if number == part.file:
            own.add(part.file)
    return Cast(clips=clips, sources=sources, own=frozenset(own))


def _found(part: Part, folder: Path | None, online: bool) -> tuple[Clip, str, str]:
    for number in (part.file, *part.standins):
        for path in _files(number, folder, online):
            try:
                clip = read(path)
                with_paper_names(clip)
            except UnderstudyError:
                continue
            return clip, path.stem, number
    return sample(part.sample), f"sample:{part.sample}", ""


def _files(number: str, folder: Path | None, online: bool) -> Iterator[Path]:
    """Files of a CMU number: BVH before Acclaim, the conversion with the paper's joints first."""
    if folder is not None:
        for ending in ("bvh", "amc"):
            found = sorted(folder.rglob(f"{number}.{ending}"))
            yield from sorted(found, key=lambda p: "LHipJoint" not in p.read_text("latin-1")[:4000])
    if online and f"cmu/{number}" in fetchable():
        yield fetch(f"cmu/{number}")
