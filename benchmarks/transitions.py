"""Goes over from one real clip into another and prints how fast the hands move meanwhile.

    python benchmarks/transitions.py FOLDER [--body adult_man] [--pairs 10] [--kinematic]

The clips of the folder, sorted by name, repaired and on one body, are paired by rule: number k
with number k + half of them, so that the two differ in subject and deed. Each pair is joined twice:
where `transitions` suggests, and from the middle of the one to the middle of the other, whatever
they do there. Per pair:

    clip          peak hand speed in the blend over the greater of both clips' own peaks
    upper, full   the same of the simulated transition (1.5 s on either side), to 0.3 s after it
    turn          greatest turn of a joint from frame to frame, in the blend and in both clips at
                  those times: a flip would be greater in the blend
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import understudy as us
from understudy.character.bodies import BODIES
from understudy.errors import UnderstudyError
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.transitions import transitions

AROUND = 1.5


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--body", default="adult_man", choices=sorted(BODIES))
    parser.add_argument("--pairs", type=int, default=10)
    parser.add_argument("--blend", type=float, default=0.5)
    parser.add_argument("--kinematic", action="store_true", help="simulate nothing")
    arguments = parser.parse_args()
    clips = on_one_body(arguments.folder, arguments.body)
    half = len(clips) // 2
    pairs = [(clips[k], clips[(k + half) % len(clips)]) for k in range(arguments.pairs)]
    print("                        hand speed / own peak          turn [deg/frame]")
    print("pair               how  cost    clip   upper    full    blend   clips")
    worst: dict[str, list[float]] = {"found": [], "middle": []}
    for a, b in pairs:
        for how, (at, start, cost) in places(a, b, arguments.blend).items():
            ratios, turns = measured(a, b, at, start, arguments)
            worst[how].append(max(ratios))
            print(
                f"{a.name + ' ' + b.name:16s} {how:>6s} {cost:5.3f}  "
                + "  ".join(f"{r:6.2f}" for r in ratios)
                + "  " * (8 * (3 - len(ratios)) // 2)
                + f"  {turns[0]:6.1f}  {turns[1]:6.1f}",
                flush=True,
            )
    for how, ratios in worst.items():
        within = sum(ratio <= 1.3 for ratio in ratios)
        print(f"{how:>6s}: worst {max(ratios):.2f}; {within} of {len(ratios)} pairs within 1.3")


def on_one_body(folder: Path, body: str) -> list[Clip]:
    """Every clip of a folder on one body, glitches repaired; what cannot be read is left out."""
    clips, character = [], BODIES[body]()
    for path in sorted(p for p in folder.iterdir() if p.suffix in (".bvh", ".amc")):
        try:
            clips.append(us.retargeted(us.read(path).repaired(), character).grounded())
        except UnderstudyError as error:
            print(f"left out: {error}")
    return clips


def places(a: Clip, b: Clip, blend: float) -> dict[str, tuple[float, float, float]]:
    """Times in both clips at which to begin, and what they cost."""
    keep = float(np.clip(0.5 * (min(a.duration, b.duration) - blend), 0.0, 0.5))
    best = transitions(a, b, count=1, blend=blend, keep=keep)[0]
    middle = 0.5 * (a.duration - blend), 0.5 * (b.duration - blend)
    return {"found": (best.time_a, best.time_b, best.cost), "middle": (*middle, np.nan)}


def measured(
    a: Clip, b: Clip, at: float, start: float, arguments: argparse.Namespace
) -> tuple[list[float], tuple[float, float]]:
    """Ratios of hand speeds; greatest turns from frame to frame [degrees], blend and clips."""
    own = max(hand_speed(a).max(), hand_speed(b).max())
    whole = a.spliced(b, at=at, start=start, blend=arguments.blend)
    within = (whole.times >= at) & (whole.times <= at + arguments.blend)
    ratios = [float(hand_speed(whole)[within[1:]].max() / own)]
    turns = (
        frame_turns(whole)[within[1:]].max(),
        max(
            frame_turns(clip.trimmed(time, time + arguments.blend)).max()
            for clip, time in ((a, at), (b, start))
        ),
    )
    if not arguments.kinematic:
        first = max(0.0, at - AROUND)
        part = whole.trimmed(first, min(at + arguments.blend + AROUND, whole.duration))
        for plan in ("upper", "full"):
            take = us.track(part, BODIES[arguments.body](plan=plan))
            motion = take.clip()
            late = (motion.times >= at - first) & (
                motion.times <= at - first + arguments.blend + 0.3
            )
            ratios.append(float(hand_speed(motion)[late[1:]].max() / own))
    return ratios, turns


def hand_speed(clip: Clip) -> np.ndarray:
    """Speed of the faster wrist from frame to frame [m/s], shape (frames - 1,)."""
    joints = [clip.skeleton.index(f"{side}_wrist") for side in ("left", "right")]
    places = clip.forward_kinematics().positions[:, joints]
    return np.linalg.norm(np.diff(places, axis=0), axis=-1).max(axis=1) * clip.rate


def frame_turns(clip: Clip) -> np.ndarray:
    """Greatest turn of a joint from frame to frame [degrees], shape (frames - 1,)."""
    return np.degrees(rot.angle_between(clip.rotations[1:], clip.rotations[:-1]).max(axis=1))


if __name__ == "__main__":
    main()
