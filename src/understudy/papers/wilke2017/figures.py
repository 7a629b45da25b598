"""The paper's variations, run again: a scaled kick, a stronger left side, limp limbs, zombies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from understudy.control.drive import scaling_for
from understudy.drive_tuning import PAPER_RATE
from understudy.fidelity import drive_error, drive_forces
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.papers.sheets import Sheet
from understudy.papers.wilke2017 import published
from understudy.papers.wilke2017.runs import UNIT, driven_take
from understudy.take import Take


def kick_table(clip: Clip, takes: dict[str, Take]) -> tuple[Sheet, dict[str, Any]]:
    """Table 3: what scaling RightFoot does to the force and torque on every joint."""
    from scipy.stats import spearmanr

    reference = clip.resampled(PAPER_RATE)
    first, last = kick_window(reference)
    scaling = scaling_for(
        reference, ["RightFoot"], published.KICK_SCALE, start=first / 60.0, end=last / 60.0
    )
    takes["kick"] = driven_take(reference)
    takes["kick scaled"] = driven_take(reference, scaling=scaling)
    force, torque = drive_forces(takes["kick scaled"]).change(drive_forces(takes["kick"]))
    names = clip.skeleton.names
    joints = [joint for joint in published.TABLE_3 if joint in names]
    at = [names.index(joint) for joint in joints]
    theirs = np.array([published.TABLE_3[joint] for joint in joints])
    ours = np.stack((force[at] / UNIT**2, torque[at] / UNIT**4), axis=1)
    orders = [float(spearmanr(theirs[:, k], ours[:, k])[0]) for k in (0, 1)]  # type: ignore[arg-type]
    ranks = [np.argsort(np.argsort(-v)) + 1 for v in (theirs[:, 0], ours[:, 0])]
    rows = tuple(
        (
            joint,
            *(float(v) for v in theirs[i]),
            *(float(v) for v in ours[i]),
            float(theirs[i, 0] / theirs[0, 0]),
            float(ours[i, 0] / ours[0, 0]),
            int(ranks[0][i]),
            int(ranks[1][i]),
        )
        for i, joint in enumerate(joints)
    )
    facts = {
        "table_3_spearman_force": orders[0],
        "table_3_spearman_torque": orders[1],
        "table_3_window_s": [first / 60.0, last / 60.0],
    }
    sheet = Sheet(
        name="Table 3",
        caption="Mean squared change of control force [(kg units/s^2)^2] and torque "
        f"[(kg units^2/s^2)^2] when RightFoot is scaled by {published.KICK_SCALE} from "
        f"{first / 60:.2f} to {last / 60:.2f} s of {clip.name}.",
        head=(
            "Joint",
            "published F^2",
            "published T^2",
            "F^2",
            "T^2",
            "published F^2 / foot",
            "F^2 / foot",
            "published rank",
            "rank",
        ),
        rows=rows,
        notes=(
            f"Spearman correlation of the order with the published one: force {orders[0]:.2f}, "
            f"torque {orders[1]:.2f}.",
        ),
    )
    return sheet, facts


def kick_window(clip: Clip) -> tuple[int, int]:
    """First and last frame of the 200 about the greatest speed of RightFoot."""
    path = clip.forward_kinematics().positions[:, clip.skeleton.index("RightFoot")]
    speed = np.linalg.norm(np.gradient(path, axis=0), axis=1)
    peak, half = int(np.argmax(speed)), published.KICK_FRAMES // 2
    first = max(0, min(peak - half, clip.frames - 1 - published.KICK_FRAMES))
    return first, min(clip.frames - 1, first + published.KICK_FRAMES)


def stronger_left(clip: Clip, takes: dict[str, Take]) -> Sheet:
    """Table 4: the left side scaled, joint by joint; adds both takes."""
    reference = clip.resampled(PAPER_RATE)
    scaling = None
    for joint, factor in published.TABLE_4.items():
        scaling = scaling_for(reference, [joint], factor, base=scaling)
    takes["range"] = driven_take(reference)
    takes["range scaled"] = driven_take(reference, scaling=scaling)
    plain, scaled = joints_of(takes["range"]), joints_of(takes["range scaled"])
    rows = []
    for joint in (*published.TABLE_4, "Hips", "Head"):
        j = clip.skeleton.index(joint)
        away = np.sqrt(np.mean(np.sum((scaled[:, j] - plain[:, j]) ** 2, axis=1))) / UNIT
        paths = [np.linalg.norm(np.diff(p[:, j], axis=0), axis=1).sum() for p in (plain, scaled)]
        ratio = float(paths[1] / paths[0]) if paths[0] > 0 else None
        rows.append((joint, published.TABLE_4.get(joint, 1.0), float(away), ratio))
    return Sheet(
        name="Table 4",
        caption=f"The asymmetric scales, and what they did on {clip.name}.",
        head=("Joint", "K_v (published, used)", "rms shift [units]", "path length ratio"),
        rows=tuple(rows),
        notes=("The paper gives no numbers of the effect.",),
    )


def joints_of(take: Take) -> Array:
    """Joint positions of a driven linkage at its clip's frames [m], shape (frames, joints, 3)."""
    linkage, reference = take.scene.characters[0], take.references[0]
    assert reference is not None
    every = take.stride(reference.rate)
    placed, turned = linkage.poses(take.qpos[::every, take.scene.parts[0].qpos])
    return placed + rot.rotate(turned, linkage.ends)


def _bend(points: Array, a: int, b: int, c: int) -> float:
    """Angle at b between a and c [deg]; 180 is straight."""
    u, v = points[a] - points[b], points[c] - points[b]
    cosine = u @ v / max(np.linalg.norm(u) * np.linalg.norm(v), 1e-12)
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def kick_height(take: Take) -> int:
    """Frame within the scaled window at which RightFoot is highest."""
    reference = take.references[0]
    assert reference is not None
    first, last = kick_window(reference)
    foot = reference.skeleton.index("RightFoot")
    heights = reference.forward_kinematics().positions[first : last + 1, foot, 2]
    return first + int(np.argmax(heights))


def kick_figure(takes: Mapping[str, Take]) -> Sheet:
    """Figure 6: the pose at the height of the kick, scaled and not."""
    frame = kick_height(takes["kick"])
    reference = takes["kick"].references[0]
    assert reference is not None
    index = reference.skeleton.index

    def poses(name: str) -> dict[str, float]:
        p = joints_of(takes[name])[frame]
        leg = p[index("RightFoot")] - p[index("RightUpLeg")]
        flat = np.linalg.norm(leg[:2])
        across = p[index("LeftUpLeg")] - p[index("RightUpLeg")]
        level = np.degrees(np.arctan2(across[2], np.linalg.norm(across[:2])))
        spine = p[index("Head")] - p[index("Hips")]
        left = across * [1.0, 1.0, 0.0]
        lean = spine @ left / max(np.linalg.norm(left), 1e-12)
        return {
            "right leg above level [deg]": float(np.degrees(np.arctan2(leg[2], flat))),
            "right knee [deg]": _bend(
                p, index("RightUpLeg"), index("RightLeg"), index("RightFoot")
            ),
            "left knee [deg]": _bend(p, index("LeftUpLeg"), index("LeftLeg"), index("LeftFoot")),
            "left hip above right [deg]": float(level),
            "left elbow [deg]": _bend(p, index("LeftArm"), index("LeftForeArm"), index("LeftHand")),
            "spine toward the left [deg]": float(np.degrees(np.arctan2(lean, spine[2]))),
            "right foot height [units]": float(p[index("RightFoot"), 2] / UNIT),
        }

    said = {
        "right leg above level [deg]": "below level, then level or more",
        "right knee [deg]": "bent past 90 degrees",
        "left knee [deg]": "less bent",
        "left hip above right [deg]": "less level",
        "left elbow [deg]": "bent away from the body",
        "spine toward the left [deg]": "bent more to the left",
    }
    plain, scaled = poses("kick"), poses("kick scaled")
    return Sheet(
        name="Figure 6",
        caption=f"At the height of the kick, {frame / 60:.2f} s.",
        head=("Quantity", "paper, when scaled", "unscaled", "RightFoot x 1.2"),
        rows=tuple((k, said.get(k), plain[k], scaled[k]) for k in plain),
    )


def gap_figure(takes: Mapping[str, Take]) -> Sheet:
    """Figures 4 and 5: how far joints come apart."""
    rows = []
    for kind in ("skeleton", "constrained"):
        found = drive_error(takes[f"walk {kind}"])
        last = found.gaps[-1]
        row = (float(last.mean()), float(last.max()), found.joints[int(np.argmax(last))])
        rows.append((published.KIND_NAMES[kind], found.gap_mean, found.gap_max, *row))
    return Sheet(
        name="Figures 4 and 5",
        caption="How far joints came apart.",
        head=(
            "Linkage",
            "mean gap [units]",
            "largest gap [units]",
            "mean at the end",
            "largest at the end",
            "where",
        ),
        rows=tuple(rows),
        notes=("The paper gives no numbers: joints drift apart, and with constraints do not.",),
    )


def _limp(clip: Clip) -> Array:
    strength = np.ones(len(clip.skeleton))
    for joint in published.UNCONTROLLED:
        strength[clip.skeleton.index(joint)] = 0.0
    return strength


def limp_figure(clip: Clip, takes: dict[str, Take]) -> Sheet:
    """Figure 8: a hand and a foot without control; adds the take."""
    takes["limp"] = driven_take(clip, strength=_limp(clip))
    plain, limp = joints_of(takes["walk constrained"]), joints_of(takes["limp"])
    rows = []
    for joint in ("LeftHand", "LeftFoot", "RightHand", "RightFoot", "Head"):
        j = clip.skeleton.index(joint)
        shift = (limp[:, j] - plain[:, j]) / UNIT
        rms = float(np.sqrt(np.mean(np.sum(shift**2, axis=1))))
        lift = float(shift[:, 2].mean()), float(shift[:, 2].max())
        rows.append((joint, joint in published.UNCONTROLLED, *lift, rms))
    return Sheet(
        name="Figure 8",
        caption="Left hand and left foot not controlled: change against full control.",
        head=(
            "Joint",
            "uncontrolled",
            "mean lift [units]",
            "greatest lift [units]",
            "rms shift [units]",
        ),
        rows=tuple(rows),
        notes=(
            'The paper says of its still that "the hand and foot lift up". That needs its gravity, '
            "1/18 of the real one: then the pull of moving parents can exceed the weight of what "
            "hangs from them, at times or on average, depending on the motion.",
        ),
    )


def zombie_figure(figure: str, clip: Clip, takes: dict[str, Take]) -> Sheet:
    """Figures 9 to 11: a zombie of a clip; adds the take."""
    skeleton = clip.skeleton
    masses = {k: v for k, v in published.ZOMBIE_MASSES.items() if k in skeleton.names}
    locks = [k for k in published.ZOMBIE_LOCKS if skeleton.children(skeleton.index(k))]
    take = driven_take(clip, masses=masses, locks=locks, strength=_limp(clip))
    takes[f"zombie {figure}"] = take
    reference = take.references[0]
    assert reference is not None
    moved, wanted = joints_of(take), reference.forward_kinematics().positions
    rows = []
    for side in ("Left", "Right"):
        chain = [skeleton.index(f"{side}{part}") for part in ("UpLeg", "Leg", "Foot")]
        knees = [[_bend(p, *chain) for p in poses[::4]] for poses in (wanted, moved)]
        foot = np.sum((moved[:, chain[2]] - wanted[: len(moved), chain[2]]) ** 2, axis=1)
        spans = [f"{min(k):.0f} to {max(k):.0f}" for k in knees]
        rows.append((f"{side} leg", *spans, float(np.sqrt(foot.mean()) / UNIT)))
    return Sheet(
        name=f"Figure {figure}",
        caption=f"Zombie on {clip.name}: knee and hand locked ({', '.join(locks)}), masses "
        f"{', '.join(f'{k} {v:g}' for k, v in masses.items())}.",
        head=("", "knee, captured [deg]", "knee, zombie [deg]", "foot from the clip, rms [units]"),
        rows=tuple(rows),
        notes=(f"Largest joint gap {drive_error(take).gap_max:.3g} units.",),
    )
