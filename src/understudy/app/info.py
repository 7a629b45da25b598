"""`understudy info`: what is in a clip, and which body it would get."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from understudy.app.body import Body, character_for
from understudy.app.outcome import Outcome
from understudy.app.reading import Reading, clip_from

if TYPE_CHECKING:
    from understudy.character import Character
    from understudy.motion.clip import Clip

EXAMPLE = "  understudy info walk.bvh"


@dataclass(frozen=True, kw_only=True)
class Options(Body, Reading):
    """Say what is in a clip: skeleton, rate, duration, what was detected, and its body.

    Attributes:
        clip: A motion file, or sample:NAME.
        json: Print one JSON object.
    """

    clip: Positional[Annotated[str, arg(metavar="CLIP")]]
    json: bool = False


def run(options: Options) -> Outcome:
    """Describe one clip."""
    clip = clip_from(options.clip, options)
    character = character_for(clip, options)
    changes = preparation(clip, character)
    result = {
        "clip": options.clip,
        **described(clip),
        "preparation": changes,
        "character": embodied(character),
    }
    return Outcome(result=result, text=text(clip, character, changes))


def preparation(clip: Clip, character: Character) -> list[str]:
    """What would be changed before the body performs the clip: repairs, feet set on the ground."""
    import understudy as us

    (tracking, *_) = us.tracked(clip, character).controllers
    reference: Clip = getattr(tracking, "reference", clip)
    known = {*clip.notes, *character.notes}
    return [note for note in reference.notes if note not in known]


def described(clip: Clip) -> dict[str, Any]:
    """A clip as plain values."""
    skeleton = clip.skeleton
    return {
        "name": clip.name,
        "skeleton": [
            {
                "joint": name,
                "parent": None if parent < 0 else skeleton.names[parent],
                "offset_m": offset.round(6).tolist(),
            }
            for name, parent, offset in zip(
                skeleton.names, skeleton.parents, skeleton.offsets, strict=True
            )
        ],
        "rate_hz": clip.rate,
        "frames": clip.frames,
        "duration_s": clip.duration,
        "synthetic": clip.synthetic,
        "lowest_m": lowest(clip),
        "notes": list(clip.notes),
    }


def embodied(character: Character) -> dict[str, Any]:
    """A character as plain values."""
    return {
        "name": character.name,
        "plan": character.plan,
        "sex": character.sex,
        "mass_kg": character.mass,
        "simulated_mass_kg": character.simulated_mass,
        "height_m": character.height,
        "links": [
            {"link": link.name, "joint": link.joint, "mass_kg": link.mass, "from": link.clip_joint}
            for link in character.links
        ],
        "controlled_dof": character.controlled_dof,
        "roles": character.roles.joints,
        "folded": list(character.roles.folded),
        "dropped": list(character.roles.dropped),
        "notes": list(character.notes),
    }


def lowest(clip: Clip) -> float:
    """Height of the lowest joint or end over the clip [m]."""
    pose = clip.forward_kinematics()
    heights = [pose.positions[..., 2].min()]
    if pose.ends.size:
        heights.append(pose.ends[..., 2].min())
    return float(min(heights))


def text(clip: Clip, character: Character, changes: Sequence[str]) -> str:
    """What a person reads."""
    lines = [
        f"{clip.name}: {len(clip.skeleton)} joints, {clip.frames} frames at {clip.rate:g} Hz, "
        f"{clip.duration:.2f} s; lowest point at {lowest(clip):+.3f} m",
        *(f"  {note}" for note in clip.notes),
        "",
        f"body: {character.name}, plan {character.plan}, {len(character.links)} links, "
        f"{character.mass:.1f} kg, {character.height:.2f} m",
        *(f"  {note}" for note in character.notes),
    ]
    if changes:
        lines += ["", "before the body performs it:", *(f"  {note}" for note in changes)]
    if character.humanoid:
        lines += ["", "roles:", *(f"  {line}" for line in str(character.roles).splitlines())]
    else:
        lines += ["", f"no human roles: {character.roles.reason or 'links keep joint names'}"]
    lines += ["", "skeleton:", *(f"  {line}" for line in tree(clip))]
    return "\n".join(lines)


def tree(clip: Clip) -> list[str]:
    """One line per joint, indented by depth."""
    skeleton = clip.skeleton
    depth = [0] * len(skeleton)
    for i, parent in enumerate(skeleton.parents[1:], 1):
        depth[i] = depth[parent] + 1
    return [f"{'  ' * depth[i]}{name}" for i, name in enumerate(skeleton.names)]
