"""Reads npz files laid out as AMASS does: axis-angle poses of a parametric body.

The body model itself is not needed and not included: the 22 joints of the body move a skeleton of
our own with the proportions of `understudy.motion.figure`, so bone lengths are approximate and
joint rotations are exact. Layout: Mahmood et al., "AMASS: Archive of Motion Capture as Surface
Shapes", ICCV 2019; joints and rest pose: Loper et al., "SMPL", ACM TOG 34(6), 2015.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from understudy.errors import ClipError, InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip, Conventions
from understudy.motion.figure import figure
from understudy.motion.npz import arrays_of
from understudy.motion.rotations import Array
from understudy.motion.settle import checked_options
from understudy.motion.skeleton import Skeleton
from understudy.motion.source import file_bytes
from understudy.motion.values import LARGEST

# Name and parent of the body's joints, in the order of `poses` (the hands' joints follow).
JOINTS = (
    ("pelvis", -1),
    ("left_hip", 0),
    ("right_hip", 0),
    ("spine1", 0),
    ("left_knee", 1),
    ("right_knee", 2),
    ("spine2", 3),
    ("left_ankle", 4),
    ("right_ankle", 5),
    ("spine3", 6),
    ("left_foot", 7),
    ("right_foot", 8),
    ("neck", 9),
    ("left_collar", 9),
    ("right_collar", 9),
    ("head", 12),
    ("left_shoulder", 13),
    ("right_shoulder", 14),
    ("left_elbow", 16),
    ("right_elbow", 17),
    ("left_wrist", 18),
    ("right_wrist", 19),
)
_RATES = ("mocap_framerate", "mocap_frame_rate", "framerate", "fps")
ARRAYS = ("poses", "trans", "gender", *_RATES)  # what is read of a file
# The rest frame of the body has x left, y up, z forward; ours x forward, y left, z up.
_TURN = np.array([0.5, 0.5, 0.5, 0.5])
# The body turns about its pelvis, which rests here in the model's axes [m]; `trans` is added after
# that turn, so the same vector leads from `trans` to the pelvis at all times (SMPL, equation 4).
_PELVIS = np.array([0.0, -0.223, 0.028])


def read_amass(
    path: str | os.PathLike[str],
    *,
    up: str | None = None,
    rate: float | None = None,
    height: float | None = None,
) -> Clip:
    """An AMASS npz file (SMPL, SMPL-H or SMPL-X poses) as a clip on an approximate skeleton.

    Args:
        path: The file.
        up: Vertical axis of the world the motion was stored in; None means "z", as AMASS has it.
        rate: Frames per second [Hz]; None takes the file's `mocap_framerate`.
        height: Stature of the skeleton [m]; None finds the one whose feet reach the ground.

    Raises:
        ClipError: The file is damaged, is no AMASS file or states no rate.
        InvalidValue: An option that cannot be meant.
    """
    checked_options(up, rate, "auto")
    arrays = arrays_of(file_bytes(path), path, ARRAYS)
    return clip_of_amass(arrays, path, up=up, rate=rate, height=height)


def clip_of_amass(
    arrays: dict[str, np.ndarray[Any, Any]],
    path: str | os.PathLike[str],
    *,
    up: str | None = None,
    rate: float | None = None,
    height: float | None = None,
) -> Clip:
    """The clip of the arrays of an AMASS file; see `read_amass`."""
    poses, trans = _numbers(arrays, "poses", path), _numbers(arrays, "trans", path)
    frames = len(poses)
    poses = poses.reshape(frames, -1) if frames else poses
    body = 3 * len(JOINTS)
    if frames == 0 or poses.ndim != 2 or poses.shape[1] < body or poses.shape[1] % 3:
        raise ClipError(
            path, f"'poses' has shape {poses.shape}; expected (frames, 66 or more, three a joint)."
        )
    if trans.shape != (frames, 3):
        raise ClipError(path, f"'trans' has shape {trans.shape}; expected {(frames, 3)}.")
    hertz = _rate(arrays, path, rate)
    gender = str(arrays["gender"].reshape(-1)[0]) if arrays.get("gender", _NONE).size else ""
    sex = "female" if "female" in gender.lower() else "male"
    notes = ["Bone lengths are approximate: a standard figure stands in for the body model."]
    extra = poses.shape[1] // 3 - len(JOINTS)
    if extra:
        notes.append(f"{extra} joints of hands and face were left out.")
    local = rot.from_rotvec(poses[:, :body].reshape(frames, len(JOINTS), 3))
    world = Conventions(up=up or "z").axis_change
    rotations = rot.multiply(_TURN, rot.multiply(local, rot.conjugate(_TURN)))
    # The root's rotation leads from the rest frame to the world, not from the rest frame to itself.
    rotations[:, 0] = rot.multiply(world, rot.multiply(local[:, 0], rot.conjugate(_TURN)))
    path_world = rot.rotate(world, trans + _PELVIS)
    try:
        size, note = _height(rotations, path_world, sex) if height is None else (height, "")
        if note:
            notes.append(note)
        return Clip(
            skeleton=skeleton(size, sex),
            rotations=rotations,
            root_positions=path_world,
            rate=hertz,
            name=Path(path).stem,
            notes=tuple(notes),
            conventions=Conventions(up="z", unit=1.0),
        )
    except InvalidValue as error:
        if height is not None and not 0.3 <= height <= 3.0:
            raise
        raise ClipError(path, str(error)) from None


_NONE = np.zeros(0)


def _numbers(
    arrays: dict[str, np.ndarray[Any, Any]], name: str, path: str | os.PathLike[str]
) -> Array:
    if name not in arrays:
        raise ClipError(path, f"has no array {name!r}; an AMASS file holds 'poses' and 'trans'.")
    array = arrays[name]
    if array.dtype.kind not in "fiu" or array.ndim < 1:
        raise ClipError(path, f"{name!r} holds no numbers.")
    with np.errstate(all="ignore"):
        values = array.astype(float)
    if not np.all(np.abs(values) <= LARGEST):
        raise ClipError(path, f"{name!r} has values that are not finite or above 1e9.")
    return values


def _rate(
    arrays: dict[str, np.ndarray[Any, Any]], path: str | os.PathLike[str], rate: float | None
) -> float:
    if rate is not None:
        return float(rate)
    for name in _RATES:
        if name in arrays and arrays[name].size == 1 and arrays[name].dtype.kind in "fiu":
            value = float(arrays[name].reshape(-1)[0])
            if 0.01 <= value <= 1e5:
                return value
            raise ClipError(
                path, f"{name!r} is {value:g}; pass rate= (--rate) in frames per second."
            )
    raise ClipError(path, "states no frame rate; pass rate= (--rate) in frames per second.")


def _height(rotations: Array, root: Array, sex: str) -> tuple[float, str]:
    """The stature [m] whose lowest point over the clip is on z = 0, and a note."""
    usual = 1.75 if sex == "male" else 1.63
    some = np.unique(np.linspace(0, len(rotations) - 1, 200).astype(int))
    # Everything but the root path grows with the height: one clip of height 1 serves all.
    unit = Clip(
        skeleton=skeleton(1.0, sex),
        rotations=rotations[some],
        root_positions=np.zeros((len(some), 3)),
        rate=1.0,
    )
    pose = unit.forward_kinematics()
    below = np.minimum(pose.positions[..., 2].min(1), pose.ends[..., 2].min(1))
    with np.errstate(all="ignore"):
        fits = np.percentile(root[some, 2] / np.maximum(-below, 1e-9), 10)
    if 1.4 <= fits <= 2.1:
        return float(fits), f"Height {fits:.2f} m: with it the feet reach the ground."
    return usual, f"Height {usual} m assumed; `read_amass` takes height= for another."


def skeleton(height: float, sex: str) -> Skeleton:
    """The 22 joints of the body with the proportions of the standard figure, z up, facing +x."""
    person = figure(height, sex)
    rest = dict(zip(person.names, person.rest_positions(), strict=True))
    chest, neck = rest["upper_back"], rest["neck"]
    pelvis, low = rest["pelvis"], rest["lower_back"]
    places = {
        "pelvis": pelvis,
        "spine1": low,
        "spine2": 0.5 * (low + chest),
        "spine3": chest,
        "neck": neck - 0.25 * (neck - chest),
        "head": neck,
    }
    for side in ("left", "right"):
        shoulder = rest[f"{side}_shoulder"]
        places |= {
            f"{side}_hip": rest[f"{side}_hip"],
            f"{side}_knee": rest[f"{side}_knee"],
            f"{side}_ankle": rest[f"{side}_ankle"],
            f"{side}_foot": rest[f"{side}_ball"],
            f"{side}_collar": chest + (shoulder - chest) * [1.0, 0.3, 0.9],
            f"{side}_shoulder": shoulder,
            f"{side}_elbow": rest[f"{side}_elbow"],
            f"{side}_wrist": rest[f"{side}_wrist"],
        }
    names = [name for name, _ in JOINTS]
    parents = tuple(parent for _, parent in JOINTS)
    same = {"neck": "head", "left_ball": "left_foot", "right_ball": "right_foot"}
    ends = [names.index(same.get(n, n)) for n in (person.names[j] for j in person.end_joints)]
    return Skeleton(
        names=tuple(names),
        parents=parents,
        offsets=np.array([places[n] - (places[names[p]] if p >= 0 else 0.0) for n, p in JOINTS]),
        end_joints=tuple(ends),
        end_offsets=person.end_offsets,
    )
