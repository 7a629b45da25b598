"""A character from a clip: the clip's bones, the masses of a person, shapes to see and touch with.

Bones of zero length and joints that no role needs are folded into the link inboard of them. A
folded joint still moves what hangs on it in the clip; the link's child then sits at the median of
where the clip puts it, and a note says how far the clip strays from that.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from numbers import Real
from typing import Literal

import numpy as np

from understudy.character import anthropometry as human
from understudy.character.anthropometry import Sex
from understudy.character.body import Character, Link, Plan
from understudy.character.bones import bone_character
from understudy.character.mapping import Mapping
from understudy.character.masses import link_properties, measured_properties
from understudy.character.outline import dressed
from understudy.character.retarget import retargeted
from understudy.character.roles import Role, Roles, find_roles
from understudy.character.soles import fitted_soles
from understudy.character.stance import Stance, neutral_stance
from understudy.character.strength import RANGE_OF_MOTION, joint_kind, torque_limits
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import LINKS, PARENTS, ROLES
from understudy.motion.rotations import Array

PLANS = ("full", "full16", "upper", "upper8")
_LEGS = ("hip", "knee", "ankle", "ball")
_SAMPLES = 500
# Joint limits keep this far from the widest angle of the clip [rad].
_LIMIT_MARGIN = np.radians(10.0)
# Masses of any body [kg], and of a person the least, a third of a newborn's.
_MASSES, _LIGHTEST_PERSON = (0.01, 1000.0), 1.0
# Hardly a person stands outside this [m]; a wrong unit is likelier.
_LIKELY = (0.8, 2.3)

# Links that touch each other when a scene asks for it: hands and forearms against trunk, head,
# thighs and each other; legs against each other. Neighbors never touch.
_SELF_COLLISIONS = (
    ("left_hand", "right_hand"),
    ("left_hand", "right_forearm"),
    ("left_forearm", "right_hand"),
    ("left_forearm", "right_forearm"),
    ("left_shank", "right_shank"),
    ("left_thigh", "right_thigh"),
    ("left_shank", "right_thigh"),
    ("left_thigh", "right_shank"),
    ("left_foot", "right_foot"),
    ("left_foot", "right_shank"),
    ("left_shank", "right_foot"),
    *(
        (f"{side}_{arm}", other)
        for side in ("left", "right")
        for arm in ("hand", "forearm")
        for other in ("pelvis", "abdomen", "chest", "head", "left_thigh", "right_thigh")
    ),
)


def from_clip(
    clip: Clip,
    *,
    plan: Plan = "full",
    sex: Sex = "male",
    mass: float | None = None,
    height: float | None = None,
    mapping: Mapping | None = None,
    inertia: Literal["anthropometry", "geometry"] = "anthropometry",
    segment_parameters: Literal["de_leva", "dempster"] = "de_leva",
    name: str | None = None,
    head: float = 1.0,
) -> Character:
    """A character with the bones of a clip.

    Args:
        clip: Any skeleton. A person's gets the links of the plan; any other gets one link per bone.
        plan: "full": 17 driven joints, 51 controlled degrees of freedom; "full16": the same with a
            rigid back, 16 and 48; "upper": no legs, the pelvis led, 9 and 27; "upper8": the same
            with a rigid back, 8 and 24 (Zordan & Hodgins 1999 count links by their joints).
        sex: "female" or "male".
        mass: Mass of the whole body [kg]; None takes a body-mass index of 22 kg/m2.
        height: Stature [m]; None takes thigh and shank to be 0.491 of it (Drillis & Contini 1966).
            Sizes masses and shapes; bone lengths are always the clip's.
        mapping: Roles said by a person.
        inertia: "anthropometry": published segments; "geometry": the visible shapes filled with
            Dempster's densities, scaled to `mass` when that is given.
        segment_parameters: Table for inertia="anthropometry".
        name: Short name; None takes the clip's.
        head: Size of the head over an adult's of the same stature; its mass goes with the cube, and
            the other segments share what is left.

    Raises:
        InvalidValue: An option outside its choices, or a skeleton that is no size of a person.
        UnknownName: The mapping names what does not exist.
    """
    _check_options(plan, inertia, mass, height)
    human.segments(segment_parameters, sex)
    roles = find_roles(clip, mapping=mapping)
    if not roles:
        return bone_character(clip, mass=mass, mapping=mapping, roles=roles, name=name)
    if mass is not None:
        _check_mass(mass, _LIGHTEST_PERSON, _MASSES[1])
    stance = neutral_stance(clip, roles)
    given_height = height
    height, height_note = _stature(clip, roles, height)
    doubts = size_doubts(height) if given_height is None else ()
    mass_note = f"Mass {mass:.1f} kg, given." if mass is not None else ""
    given_mass = mass
    if mass is None:
        mass = human.default_mass(height)
        mass_note = f"Mass {mass:.1f} kg: a body-mass index of {human.DEFAULT_BMI:g} kg/m2."
    plans = _planned(roles, plan)
    bones = _bones(clip, plans, stance)
    placed = _rest(bones)
    figure = Figure(
        sex=sex,
        mass=mass,
        height=height,
        positions={b.role: p for b, p in zip(bones, placed, strict=True)},
        tips={b.role: b.tip for b in bones if b.tip is not None},
        dropped=_plan_dropped(plan),
        head=head,
    )
    shapes = dressed(figure)
    if inertia == "geometry":
        properties = measured_properties(shapes, total=given_mass)
        if given_mass is None:
            mass = sum(p.mass for p in properties.values())
            mass_note = f"Mass {mass:.1f} kg: the shapes filled with Dempster's densities."
    else:
        table = human.with_head(human.segments(segment_parameters, sex), head)
        properties = link_properties(figure, table)
    links = []
    for bone in bones:
        own = properties[bone.role]
        limit = None
        if bone.role != "pelvis":
            limit = np.abs(torque_limits(bone.role, sex=sex, mass=mass, height=height)).max(axis=1)
        links.append(
            Link(
                name=LINKS[bone.role],
                joint=bone.role,
                role=bone.role,
                parent=bone.parent,
                offset=bone.offset,
                ends=bone.ends,
                mass=own.mass,
                com=own.com,
                inertia=own.inertia,
                shapes=shapes[bone.role],
                torque_limit=limit,
                motion_limit=_motion_limit(bone),
                clip_joint=bone.joint,
                origin_joint=bone.origin,
                alignment=bone.alignment,
            )
        )
    sole = figure.sole_height
    links[0] = _standing(links, placed, sole)
    names = {link.name for link in links}
    neighbors = {(links[k.parent].name, k.name) for k in links[1:]}
    pairs = tuple(
        (a, b)
        for a, b in _SELF_COLLISIONS
        if a in names and b in names and (a, b) not in neighbors and (b, a) not in neighbors
    )
    notes = [height_note, mass_note, *doubts, stance.note, *_fold_notes(bones)]
    character = Character(
        name=name or clip.name,
        links=tuple(links),
        plan=plan,
        sex=sex,
        mass=mass,
        height=height,
        sole_height=sole,
        source=clip.skeleton,
        roles=roles,
        self_collisions=pairs,
        notes=tuple(notes),
    )
    return fitted_soles(retargeted(clip, character), character)


@dataclass(frozen=True, kw_only=True)
class Figure:
    """What sizes and places a person's masses and shapes.

    Attributes:
        sex: "female" or "male".
        mass: Whole body [kg].
        height: Stature [m].
        positions: Origin of each link in the neutral T-pose, mid-hip at the origin [m], by role.
        tips: Outboard end of links that have one, in the link frame [m], by role.
        dropped: Kinds of joints the plan leaves out with their mass.
        head: Size of the head over an adult's of the same stature.
    """

    sex: Sex
    mass: float
    height: float
    positions: dict[str, Array]
    tips: dict[str, Array]
    dropped: tuple[str, ...] = ()
    head: float = 1.0

    @property
    def sole_height(self) -> float:
        """Height of the soles in the foot frame [m]."""
        sole = -human.ANKLE_HEIGHT * self.height
        for side in ("left", "right"):
            ball = self.positions.get(f"{side}_ball")
            if ball is not None:
                drop = float(ball[2] - self.positions[f"{side}_ankle"][2])
                sole = min(sole, drop - 0.008 * self.height)
        return sole


@dataclass(frozen=True, kw_only=True)
class _Bone:
    """A link to be: which joints of the clip make it, and what the clip says of it."""

    role: str
    parent: int
    joint: str
    origin: str
    alignment: Array
    offset: Array
    spread: float
    ends: Array
    tip: Array | None
    widest: float


def _check_options(plan: str, inertia: str, mass: float | None, height: float | None) -> None:
    if plan not in PLANS:
        raise InvalidValue(f"plan is {plan!r}; it must be one of {', '.join(PLANS)}.")
    if inertia not in ("anthropometry", "geometry"):
        raise InvalidValue(f"inertia is {inertia!r}; it must be 'anthropometry' or 'geometry'.")
    if mass is not None:
        _check_mass(mass, *_MASSES)
    if height is not None and not (isinstance(height, Real) and 0.3 <= height <= 4):
        raise InvalidValue(f"height is {height!s:.40} m; it must lie in 0.3 to 4 m (--height).")


def _check_mass(mass: float, low: float, high: float) -> None:
    if not (isinstance(mass, Real) and low <= mass <= high):
        raise InvalidValue(
            f"mass is {mass!s:.40} kg; it must lie in {low:g} to {high:g} kg (--mass)."
        )


def _plan_dropped(plan: str) -> tuple[str, ...]:
    return _LEGS if plan.startswith("upper") else ()


def _planned(roles: Roles, plan: str) -> list[Role]:
    """Roles that become links; a rigid back turns with the chest about the lower back."""
    out = []
    for role in roles.found:
        if role.role.split("_")[-1] in _plan_dropped(plan):
            continue
        if plan in ("full16", "upper8") and role.role == "lower_back" and "upper_back" in roles:
            continue
        if plan in ("full16", "upper8") and role.role == "upper_back":
            lower = roles.get("lower_back") or role
            role = Role(
                role="upper_back",
                joint=role.joint,
                origin=lower.origin,
                confidence=role.confidence,
                evidence=role.evidence,
            )
        out.append(role)
    return out


def _parent(role: str, present: set[str]) -> str | None:
    parent = PARENTS.get(role)
    while parent is not None and parent not in present:
        parent = PARENTS.get(parent)
    return parent


def _bones(clip: Clip, plans: list[Role], stance: Stance) -> list[_Bone]:
    """Offsets, ends and widest angles of the links, measured over the clip."""
    skeleton, pose = clip.skeleton, clip.forward_kinematics()
    step = max(1, clip.frames // _SAMPLES)
    at, ends = pose.positions[::step], pose.ends[::step]
    present = {r.role for r in plans}
    order = [r for r in ROLES if r in present]
    by_role = {r.role: r for r in plans}
    turned = {
        r: rot.multiply(
            pose.rotations[::step, skeleton.index(by_role[r].joint)], stance.alignments[r]
        )
        for r in order
    }
    bones = []
    for role in order:
        own = by_role[role]
        parent = _parent(role, present)
        here = at[:, skeleton.index(own.origin)]
        offset, spread, widest = np.zeros(3), 0.0, 0.0
        if parent is not None:
            there = at[:, skeleton.index(by_role[parent].origin)]
            offset, spread = _settled(rot.rotate(rot.conjugate(turned[parent]), here - there))
            relative = rot.multiply(rot.conjugate(turned[parent]), turned[role])
            widest = float(rot.angle(relative).max())
        carried = _carried(clip, role, by_role, ends, at)
        local = [_settled(rot.rotate(rot.conjugate(turned[role]), p - here))[0] for p in carried]
        tip = max(local, key=lambda v: float(np.linalg.norm(v)), default=None)
        bones.append(
            _Bone(
                role=role,
                parent=-1 if parent is None else order.index(parent),
                joint=own.joint,
                origin=own.origin,
                alignment=stance.alignments[role],
                offset=offset,
                spread=spread,
                ends=np.array([tip]).reshape(-1, 3) if tip is not None else np.zeros((0, 3)),
                tip=tip,
                widest=widest,
            )
        )
    return bones


def _settled(track: Array) -> tuple[Array, float]:
    """Median of a track of points [m] and how far it strays on average."""
    middle = np.median(track, axis=0)
    strays = np.linalg.norm(track - middle, axis=1)
    # A point that never moves is taken as it is, so that rounding does not add up along a chain.
    return (track[0] if strays.max() < 1e-9 else middle), float(strays.mean())


def _carried(
    clip: Clip, role: str, by_role: dict[str, Role], ends: Array, at: Array
) -> list[Array]:
    """World tracks of end sites and dropped joints outboard of a link that ends a chain."""
    skeleton = clip.skeleton
    if role.split("_")[-1] not in ("neck", "wrist", "ball", "ankle", "elbow", "knee"):
        return []
    others = {skeleton.index(r.joint) for r in by_role.values()}
    joint = skeleton.index(by_role[role].joint)
    inside = {joint}
    for i in range(joint + 1, len(skeleton)):
        if skeleton.parents[i] in inside:
            if i in others:
                return []
            inside.add(i)
    return [ends[:, k] for k, j in enumerate(skeleton.end_joints) if j in inside] + [
        at[:, j] for j in inside - {joint}
    ]


def _rest(bones: list[_Bone]) -> list[Array]:
    """Origins of the links in the neutral T-pose with the pelvis joint at the origin [m]."""
    out: list[Array] = []
    for bone in bones:
        out.append(bone.offset + (out[bone.parent] if bone.parent >= 0 else 0.0))
    return out


def _standing(links: list[Link], placed: list[Array], sole: float) -> Link:
    """The root link, raised so that the soles (or the lowest point) rest on z = 0."""
    feet = [p[2] + sole for k, p in zip(links, placed, strict=True) if k.joint.endswith("ankle")]
    lowest = min(feet) if feet else min(float(p[2]) for p in placed)
    return replace(links[0], offset=np.array([0.0, 0.0, -lowest]))


def size_doubts(height: float) -> tuple[str, ...]:
    """A warning when hardly anybody is as tall as this [m], else nothing."""
    low, high = _LIKELY
    if low <= height <= high:
        return ()
    return (f"Stands {height:.2f} m tall: check unit= (--unit).",)


def _stature(clip: Clip, roles: Roles, given: float | None) -> tuple[float, str]:
    """Stature [m] from bone lengths, and a note."""
    if given is not None:
        return float(given), f"Height {given:.3f} m, given."
    at = clip.forward_kinematics().positions[:: max(1, clip.frames // 50)]
    index = clip.skeleton.index

    def length(a: str, b: str) -> float | None:
        one, two = roles.get(a), roles.get(b)
        if one is None or two is None:
            return None
        way = at[:, index(one.origin)] - at[:, index(two.origin)]
        return float(np.median(np.linalg.norm(way, axis=1)))

    sizes = human.LENGTHS
    for joints, parts, words in (
        (("hip", "knee", "ankle"), ("thigh", "shank"), "thigh and shank"),
        (("shoulder", "elbow", "wrist"), ("upper_arm", "forearm"), "upper arm and forearm"),
        (("hip", "knee"), ("thigh",), "thighs"),
        (("shoulder", "elbow"), ("upper_arm",), "upper arms"),
    ):
        found = []
        for side in ("left", "right"):
            lengths = [length(f"{side}_{a}", f"{side}_{b}") for a, b in pairwise(joints)]
            if all(v is not None for v in lengths):
                found.append(sum(v for v in lengths if v is not None))
        if found:
            fraction = sum(sizes[part] for part in parts)
            height = float(np.mean(found)) / fraction
            if not 0.3 <= height <= 4:
                raise InvalidValue(
                    f"{clip.name}: {words} measure {np.mean(found):.3g} m, a person of "
                    f"{height:.3g} m. Read the clip with the right unit, or give height."
                )
            return height, (
                f"Height {height:.3f} m: {words} are {fraction:.3f} of it (Drillis & Contini 1966)."
            )
    raise InvalidValue(f"{clip.name}: no limb is complete, so give height.")


def _motion_limit(bone: _Bone) -> float | None:
    """Widest angle allowed [rad]: the human's or the clip's own with a margin, or None."""
    human_limit = RANGE_OF_MOTION.get(joint_kind(bone.role)) if bone.role != "pelvis" else None
    if human_limit is None:
        return None
    limit = max(np.radians(human_limit), bone.widest + _LIMIT_MARGIN)
    return float(limit) if limit < np.radians(170.0) else None


def _fold_notes(bones: list[_Bone]) -> list[str]:
    moved = [(b.spread, b.role) for b in bones if b.spread > 1e-3]
    if not moved:
        return []
    listed = ", ".join(f"{role} {1000 * spread:.0f} mm" for spread, role in sorted(moved)[::-1])
    return [f"Folded joints let the clip stray from fixed bones on average by: {listed}."]
