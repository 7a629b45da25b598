"""Left and right exchanged: which joints are partners, where the sagittal plane is, the reflection.

Partners are found from names in any of the usual styles and, where names say nothing, from the
symmetry of the rest pose.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

# A side in a name: the word itself ("LeftArm", "arm_left"), or one letter that begins the name or
# stands after a separator ("lfemur", "LThumb", "Bip01 L Thigh", "mixamorig:L_Arm"), or one letter
# that ends it ("hand_l", "thigh.L", "ThighL").
_SIDE = re.compile(
    r"(?P<word>left|right)|(?P<start>(?:(?<=^)|(?<=[\s:._\-]))[lr])|(?P<end>(?<=[\s._\-])[lr]$)"
    r"|(?P<camel>(?-i:(?<=[a-z0-9])[LR]$))",
    re.IGNORECASE,
)
_OTHER = {"left": "right", "right": "left", "l": "r", "r": "l"}


def _exchanged_names(name: str) -> Iterator[tuple[str, int]]:
    """Names that `name`'s partner could have, each with the side of `name` (+1 left, -1 right)."""
    for found in _SIDE.finditer(name):
        text = found.group()
        other = _OTHER[text.lower()]
        if text.isupper():
            other = other.upper()
        elif text[0].isupper():
            other = other.capitalize()
        side = 1 if text.lower() in ("left", "l") else -1
        yield name[: found.start()] + other + name[found.end() :], side


def side(skeleton: Skeleton, joint: int) -> int:
    """+1 if the joint's name says left and the right one exists, -1 for right, 0 for neither."""
    names = set(skeleton.names)
    for other, sign in _exchanged_names(skeleton.names[joint]):
        if other in names:
            return sign
    return 0


def partners(skeleton: Skeleton) -> tuple[int, ...]:
    """For each joint the index of its partner on the other side; its own where it has none.

    Partners always hang on partners, so that exchanging them keeps the tree. Names decide; children
    of paired joints (or of one on the middle line) that names leave open are paired by the symmetry
    of their offsets.
    """
    index = {name: i for i, name in enumerate(skeleton.names)}
    axis = sagittal_axis(skeleton)
    partner = list(range(len(skeleton)))
    queue = [(0, 0)]
    while queue:
        a, b = queue.pop()
        for c, d in _paired_children(skeleton, index, axis, a, b):
            partner[c], partner[d] = d, c
            queue.append((c, d))
    return tuple(partner)


def _paired_children(
    skeleton: Skeleton, index: dict[str, int], axis: Array, a: int, b: int
) -> Iterator[tuple[int, int]]:
    left, right = list(skeleton.children(a)), list(skeleton.children(b))
    for c in tuple(left):
        for other, _ in _exchanged_names(skeleton.names[c]):
            d = index.get(other)
            if c in left and d in right and d != c:
                yield c, d
                left.remove(c)
                right.remove(d)
                if a == b:
                    left.remove(d)
                    right.remove(c)
                break
    while left:
        c = left.pop(0)
        mirrored_offset = reflected(skeleton.offsets[c], axis)
        if a == b:
            right.remove(c)
        gaps = [float(np.linalg.norm(skeleton.offsets[d] - mirrored_offset)) for d in right]
        own = float(np.linalg.norm(skeleton.offsets[c] - mirrored_offset)) if a == b else np.inf
        # Within a quarter of the bone's length.
        limit = 0.25 * float(np.linalg.norm(skeleton.offsets[c])) + 1e-6
        best = int(np.argmin(gaps)) if gaps else -1
        if best >= 0 and gaps[best] <= limit and gaps[best] < own:
            d = right.pop(best)
            if a == b:
                left.remove(d)
            yield c, d
        elif a == b:
            yield c, c


def sagittal_axis(skeleton: Skeleton) -> Array:
    """Unit vector (3,) across the rest pose's sagittal plane (to the left, where names say so).

    The mean of left minus right over the joints that names pair; without such names, the horizontal
    axis in which the rest pose is most symmetric. Within 15 degrees of a coordinate axis it is that
    axis.
    """
    rest = skeleton.rest_positions()
    index = {name: i for i, name in enumerate(skeleton.names)}
    across = np.zeros(3)
    for i, name in enumerate(skeleton.names):
        for other, sign in _exchanged_names(name):
            if other in index:
                across += sign * (rest[i] - rest[index[other]])
                break
    if np.linalg.norm(across) > 1e-6:
        across = across / np.linalg.norm(across)
        nearest = int(np.argmax(np.abs(across)))
        if abs(across[nearest]) > np.cos(np.radians(15.0)):
            across = np.sign(across[nearest]) * np.eye(3)[nearest]
        return across
    y, x = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    return y if _asymmetry(rest, y) <= _asymmetry(rest, x) else x


def _asymmetry(rest: Array, axis: Array) -> float:
    """Mean distance [m] from each rest joint's mirror image to the nearest rest joint."""
    centered = rest - rest[0]
    gaps = np.linalg.norm(reflected(centered, axis)[:, None] - centered[None], axis=-1).min(axis=1)
    return float(gaps.mean()) + 1e-9 * float(np.abs(centered @ axis).mean())


def reflected(vectors: Array, axis: Array) -> Array:
    """Vectors (..., 3) reflected in the plane through the origin at right angles to `axis`."""
    return vectors - 2.0 * (vectors @ axis)[..., None] * axis


def mirrored(clip: Clip) -> Clip:
    """The clip seen in a mirror, with left and right exchanged.

    The world is reflected in the vertical plane through its origin that is parallel to the rest
    pose's sagittal plane. The skeleton is reflected too, so every joint's path is the exact mirror
    image of its partner's: an actor whose left leg is longer becomes one whose right leg is longer.
    A symmetric skeleton stays as it is. A joint without a partner mirrors onto itself. Mirroring
    twice gives the clip back.
    """
    axis, partner = sagittal_axis(clip.skeleton), list(partners(clip.skeleton))
    # A rotation about v seen in a mirror is a rotation about the negative reflection of v.
    turned = clip.rotations[:, partner]
    vector = -reflected(turned[..., 1:], axis)
    pairs = sum(1 for i, j in enumerate(partner) if i < j)
    return replace(
        clip,
        skeleton=_reflected_skeleton(clip.skeleton, axis, partner),
        rotations=np.concatenate((turned[..., :1], vector), axis=-1),
        root_positions=reflected(clip.root_positions, axis),
        notes=(*clip.notes, f"Mirrored: left and right exchanged ({pairs} pairs of joints)."),
    )


def _reflected_skeleton(skeleton: Skeleton, axis: Array, partner: list[int]) -> Skeleton:
    carriers = list(skeleton.end_joints)
    slots: dict[int, list[int]] = {}
    for k, j in enumerate(carriers):
        slots.setdefault(j, []).append(k)
    if all(len(slots.get(partner[j], [])) == len(ks) for j, ks in slots.items()):
        source = [slots[partner[j]][slots[j].index(k)] for k, j in enumerate(carriers)]
    else:
        source, carriers = list(range(len(carriers))), [partner[j] for j in carriers]
    offsets = reflected(skeleton.offsets[partner], axis)
    ends = reflected(skeleton.end_offsets[source], axis)
    if (
        tuple(carriers) == skeleton.end_joints
        and np.allclose(offsets, skeleton.offsets, rtol=0.0, atol=1e-9)
        and np.allclose(ends, skeleton.end_offsets, rtol=0.0, atol=1e-9)
    ):
        return skeleton
    return replace(skeleton, offsets=offsets, end_joints=tuple(carriers), end_offsets=ends)
