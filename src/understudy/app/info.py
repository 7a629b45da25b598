"""`understudy info`: what is in a clip, and which body it would get."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from tyro.conf import Positional, arg

from understudy.app.body import Body, character_for
from understudy.app.outcome import Outcome
from understudy.app.reading import Reading, clip_from, stem

if TYPE_CHECKING:
    from understudy.character import Character
    from understudy.feasibility import Feasibility
    from understudy.motion.clip import Clip
    from understudy.performance import Performance

STAYS = 0.05
"""A clip that ends nearer to where it started travels nowhere [m]."""

EXAMPLE = """\
  understudy info walk.bvh
  understudy info walk.bvh --out out"""


@dataclass(frozen=True, kw_only=True)
class Options(Body, Reading):
    """Say what is in a clip: skeleton, rate, duration, what was detected, and its body.

    Attributes:
        clip: A motion file, or sample:NAME.
        out: Folder for NAME.html (the clip as read beside the clip as prepared, and the force that
            the ground cannot give, over time) and NAME.png (both motions as a sheet).
        json: Print one JSON object.
    """

    clip: Positional[Annotated[str, arg(metavar="CLIP")]]
    out: Annotated[Path | None, arg(metavar="DIR", help_behavior_hint="(default: no files)")] = None
    json: bool = False


def run(options: Options) -> Outcome:
    """Describe one clip."""
    import understudy as us
    from understudy.evaluate.preparation import preparation as prepared
    from understudy.take import posed

    clip = clip_from(options.clip, options)
    character = character_for(clip, options)
    performance = us.tracked(clip, character)
    changes = preparation(clip, character, performance)
    found = outlook(performance)
    moved = prepared(posed(performance))
    files = {} if options.out is None else written_out(performance, options.out, options.clip)
    result = {
        "clip": options.clip,
        **described(clip),
        **whereabouts(clip, character),
        "preparation": changes,
        "changed": moved.as_dict(),
        "feasibility": None if found is None else found.as_dict(),
        "character": embodied(character),
        "files": files,
    }
    said = [text(clip, character, [*changes, f"Changed in all: {moved}"], found)]
    said += ["", "files:", *(f"  {path}" for path in files.values())] if files else []
    return Outcome(result=result, text="\n".join(said))


def written_out(performance: Performance, folder: Path, clip: str) -> dict[str, str]:
    """Write the page and the sheet of a clip that has ground under it; ending to path.

    Raises:
        InvalidValue: There is no ground.
    """
    from understudy.app.performing import ready, staged
    from understudy.clip_report import write_clip_page
    from understudy.output import contact_sheet
    from understudy.take import posed

    ready(folder)
    name = stem(clip)
    with staged(folder, name) as (inside, files):
        write_clip_page(performance, inside / f"{name}.html")
        contact_sheet(posed(performance), inside / f"{name}.png")
    return files


def preparation(clip: Clip, character: Character, performance: Performance) -> list[str]:
    """What would be changed before the body performs the clip: repairs, feet set on the ground."""
    (tracking, *_) = performance.controllers
    reference: Clip = getattr(tracking, "reference", clip)
    known = {*clip.notes, *character.notes}
    return [note for note in reference.notes if note not in known]


def outlook(performance: Performance) -> Feasibility | None:
    """Whether the body can perform the clip without help; None where there is no ground."""
    from understudy.feasibility import assess

    return None if performance.scene.ground is None else assess(performance)


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


def whereabouts(clip: Clip, character: Character) -> dict[str, Any]:
    """Where a clip starts, faces and travels over the ground; angles from +x toward +y."""
    way = clip.root_positions[-1, :2] - clip.root_positions[0, :2]
    travel = float(np.linalg.norm(way))
    return {
        "start_m": clip.root_positions[0, :2].round(6).tolist(),
        "facing_deg": facing(clip, character),
        "travel_m": travel,
        "travel_deg": degrees(*way) if travel >= STAYS else None,
    }


def facing(clip: Clip, character: Character) -> float | None:
    """Which way hips and shoulders face in the first frame; None where there are none."""
    joints, places = character.roles.joints, clip.forward_kinematics().positions[0]
    ahead = np.zeros(2)
    for part in ("hip", "shoulder"):
        pair = [joints.get(f"{side}_{part}") for side in ("left", "right")]
        if all(joint in clip.skeleton.names for joint in pair):
            left, right = (places[clip.skeleton.index(str(joint)), :2] for joint in pair)
            x, y = left - right
            ahead += np.array([y, -x]) / max(float(np.hypot(x, y)), 1e-9)
    return degrees(*ahead) if np.linalg.norm(ahead) > 1e-6 else None


def degrees(x: float, y: float) -> float:
    """The direction of a vector over the ground from +x toward +y."""
    return float(np.degrees(np.arctan2(y, x)))


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


def text(
    clip: Clip, character: Character, changes: Sequence[str], found: Feasibility | None
) -> str:
    """What a person reads."""
    lines = [
        f"{clip.name}: {len(clip.skeleton)} joints, {clip.frames} frames at {clip.rate:g} Hz, "
        f"{clip.duration:.2f} s; lowest point at {lowest(clip):+.3f} m",
        course(clip, character),
        *(f"  {note}" for note in clip.notes),
        "",
        f"body: {character.name}, plan {character.plan}, {len(character.links)} links, "
        f"{character.mass:.1f} kg, {character.height:.2f} m",
        *(f"  {note}" for note in character.notes),
    ]
    if changes:
        lines += ["", "before the body performs it:", *(f"  {note}" for note in changes)]
    if found is not None:
        lines += ["", "what the ground cannot give, in % of body weight:", f"  {found}"]
        lines += [f"  {moment}" for moment in found.moments]
    if character.humanoid:
        lines += ["", "roles:", *(f"  {line}" for line in str(character.roles).splitlines())]
    else:
        lines += ["", f"no human roles: {character.roles.reason or 'links keep joint names'}"]
    lines += ["", "skeleton:", *(f"  {line}" for line in tree(clip))]
    return "\n".join(lines)


def course(clip: Clip, character: Character) -> str:
    """Where it starts, faces and travels, in one line."""
    found = whereabouts(clip, character)
    x, y = found["start_m"]
    parts = [f"starts at x {x:.2f}, y {y:.2f} m"]
    if found["facing_deg"] is not None:
        parts.append(f"facing {found['facing_deg']:z.0f} degrees")
    if found["travel_deg"] is None:
        parts.append("ends where it starts")
    else:
        parts.append(f"travels {found['travel_m']:.2f} m toward {found['travel_deg']:z.0f} degrees")
    return ", ".join(parts) + " (from +x toward +y)"


def tree(clip: Clip) -> list[str]:
    """One line per joint, indented by depth."""
    skeleton = clip.skeleton
    depth = [0] * len(skeleton)
    for i, parent in enumerate(skeleton.parents[1:], 1):
        depth[i] = depth[parent] + 1
    return [f"{'  ' * depth[i]}{name}" for i, name in enumerate(skeleton.names)]
