"""Two-bone limbs in closed form: where the elbow or knee goes when the hand or foot is placed."""

from __future__ import annotations

import numpy as np

from understudy.motion import rotations as rot
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton


def bent(
    start: Array,
    target: Array,
    pole: Array,
    upper: Array,
    lower: Array,
    *,
    softness: float = 0.004,
) -> tuple[Array, Array]:
    """World rotations of the two bones that carry a limb's end to `target`.

    The joint between bends in the plane of the limb and `pole`. Near and beyond full reach the
    target is approached smoothly and not reached.

    Args:
        start: World position of the limb's first joint [m], shape (frames, 3).
        target: World position wanted for its end [m], shape (frames, 3).
        pole: World direction in which the middle joint points, shape (frames, 3).
        upper: Rest offset of the middle joint from the first [m], (3,).
        lower: Rest offset of the end from the middle joint [m], (3,), parallel to `upper`.
        softness: Fraction of the reach over which it is approached.

    Returns:
        Rotations of the upper and the lower bone, each (frames, 4), world; the middle joint turns
        about one fixed axis of the bones: the cross product of `upper` and world x at rest.
    """
    a, b = float(np.linalg.norm(upper)), float(np.linalg.norm(lower))
    along = target - start
    wanted = np.maximum(np.linalg.norm(along, axis=-1), 1e-9)
    along = along / wanted[..., None]
    # Soft reach: exact up to (1 - softness) of the full length, then bends toward it exponentially.
    full, knee = a + b, (1.0 - softness) * (a + b)
    room = full - knee
    over = np.maximum(wanted - knee, 0.0)
    reach = np.where(over > 0.0, knee + room * (1.0 - np.exp(-over / room)), wanted)
    reach = np.clip(reach, abs(a - b) + 1e-6, full * (1.0 - 1e-9))
    side = pole - np.sum(pole * along, axis=-1, keepdims=True) * along
    side = side / np.maximum(np.linalg.norm(side, axis=-1, keepdims=True), 1e-9)
    cosine = (a * a + reach * reach - b * b) / (2.0 * a * reach)
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    middle = a * (cosine[..., None] * along + sine[..., None] * side)
    end = reach[..., None] * along
    return (
        _frame(middle / a, side, along, upper / a),
        _frame((end - middle) / b, side, along, lower / b),
    )


def _frame(direction: Array, side: Array, along: Array, rest: Array) -> Array:
    """Rotation that turns `rest` into `direction` and the rest hinge into the bend plane's normal.

    The hinge is side x along: for a leg (rest -z, knee forward) that is y, for an arm (rest y or
    -y, elbow backward) it is vertical.
    """
    hinge = np.cross(side, along)
    hinge = hinge / np.maximum(np.linalg.norm(hinge, axis=-1, keepdims=True), 1e-9)
    # The middle joint points forward for legs and backward for arms at rest.
    forward = np.array([1.0, 0.0, 0.0]) if abs(rest[2]) > 0.5 else np.array([-1.0, 0.0, 0.0])
    rest_hinge = np.cross(forward, rest)
    now = np.stack((direction, hinge, np.cross(direction, hinge)), axis=-1)
    then = np.stack((rest, rest_hinge, np.cross(rest, rest_hinge)), axis=-1)
    return rot.from_matrix(now @ then.T)


def place_foot(
    turned: Array, skeleton: Skeleton, side: str, root: Array, ankle: Array, foot: Array
) -> None:
    """Set hip, knee and ankle in `turned` so that the foot stands where it should.

    Args:
        turned: Local rotations of the standard figure, (frames, joints, 4); the leg's three joints
            are overwritten, the pelvis is read.
        skeleton: The standard figure.
        side: "left" or "right".
        root: Pelvis position [m], (frames, 3).
        ankle: Ankle position wanted [m], (frames, 3), world.
        foot: World rotation of the foot, (frames, 4); the knee points along its heading.
    """
    hip, knee, heel = (skeleton.index(f"{side}_{part}") for part in ("hip", "knee", "ankle"))
    pelvis = turned[:, 0]
    start = root + rot.rotate(pelvis, skeleton.offsets[hip])
    heading = rot.rotate(foot, np.array([1.0, 0.0, 0.0])) * np.array([1.0, 1.0, 0.0])
    upper, lower = bent(start, ankle, heading, skeleton.offsets[knee], skeleton.offsets[heel])
    turned[:, hip] = rot.multiply(rot.conjugate(pelvis), upper)
    turned[:, knee] = rot.multiply(rot.conjugate(upper), lower)
    turned[:, heel] = rot.multiply(rot.conjugate(lower), foot)


def place_hand(
    turned: Array,
    skeleton: Skeleton,
    side: str,
    chest: tuple[Array, Array],
    wrist: Array,
    elbow: Array,
    hand: Array,
) -> None:
    """Set shoulder, elbow and wrist in `turned` so that the hand is where it should be.

    Args:
        turned: Local rotations of the standard figure, (frames, joints, 4); the arm's three joints
            are overwritten.
        skeleton: The standard figure.
        side: "left" or "right".
        chest: World position [m] (frames, 3) and rotation (frames, 4) of the upper back.
        wrist: Wrist position wanted [m], (frames, 3), world.
        elbow: World direction in which the elbow points, (frames, 3).
        hand: World rotation of the hand, (frames, 4). Turning about the forearm is left to the
            elbow (pronation), so the wrist only bends.
    """
    joints = [skeleton.index(f"{side}_{part}") for part in ("shoulder", "elbow", "wrist")]
    position, turn = chest
    start = position + rot.rotate(turn, skeleton.offsets[joints[0]])
    upper, lower = bent(
        start, wrist, elbow, skeleton.offsets[joints[1]], skeleton.offsets[joints[2]]
    )
    # Twist of the hand about the forearm's axis y: swing-twist decomposition of the wrist.
    bend = rot.multiply(rot.conjugate(lower), hand)
    twist = rot.normalized(bend * np.array([1.0, 0.0, 1.0, 0.0]))
    lower = rot.multiply(lower, twist)
    turned[:, joints[0]] = rot.multiply(rot.conjugate(turn), upper)
    turned[:, joints[1]] = rot.multiply(rot.conjugate(upper), lower)
    turned[:, joints[2]] = rot.multiply(rot.conjugate(lower), hand)
