"""A clip whose pelvis path is one that the ground can give.

Captured accelerations are off: markers shake, segment masses are guessed, feet leave the floor some
frames early or late. In flight a body that falls with 11 m/s^2 has to be pulled down. The pelvis is
moved by as little as makes the unexplained force small: with d the shift over time, r the force
that contact leaves over and m the mass,

    minimize  sum |d'' + r / m|^2 + STIFFNESS |d|^2

a banded least-squares problem per axis. Feet on the floor stay where they are and legs close the
gap; a foot in the air goes along. Contact changes a little with the path, so it is repeated.

A stretch without ground under it that does not fall as a flight does (a support is missing from the
scene) is left as it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import solveh_banded
from scipy.ndimage import find_objects, gaussian_filter1d, label

from understudy.character.body import Character
from understudy.character.leaning import bearing_hands
from understudy.character.planting import ARM, LATERAL, LEG, VERTICAL, moved_end
from understudy.character.soles import sole_paths
from understudy.control.feedforward import REACH, required
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.scene import Ground, Scene, timestep_for

ROUNDS = 4
# What a shift costs [1/s^4]: at 0.9 Hz half of the force is taken away by a shift, faster ones cost
# millimeters, slower ones are left to the body.
STIFFNESS = 1000.0
# Accelerations beyond this [m/s^2] come from glitches; they count as this much.
MOST = 6.0
# Most the pelvis moves along an axis [m].
MOST_SHIFT = 0.06
# A stretch borne by less than the first share of the weight is in the air; one whose mean
# unexplained force, up or down, exceeds the second is no flight.
BORNE, FLIGHT = 0.05, 0.3
BRIEF = 0.1  # And lasts longer than this [s].
# A foot lower than this stays where it is, one higher than that goes with the pelvis [m].
NEAR, HIGH = 0.03, 0.2
# Window of the accelerations [s].
SMOOTHING = 0.125


def supported(clip: Clip, character: Character, ground: Ground) -> Clip:
    """The clip with its pelvis shifted a little, so that the ground explains more of it.

    Args:
        clip: On the character's own skeleton, its feet planted on the ground.
        character: The body.
        ground: What it stands on.
    """
    limbs = _limbs(clip, character, ground)
    if clip.frames < 10 or not limbs:
        return clip
    scene = Scene(characters=(character,), ground=ground, timestep=timestep_for(clip.rate))
    shift, best, least = np.zeros_like(clip.root_positions), clip, np.inf
    for round_ in range(ROUNDS + 1):
        moved = _moved(clip, shift, limbs)
        need = required(
            scene, scene.model, 0, moved, contact=True, reach=REACH, smoothing=SMOOTHING
        )
        left = float(np.sum(need.root[:, :3] ** 2))
        if left < least:
            best, least = moved, left
        if round_ < ROUNDS:
            wanted = -need.root[:, :3] / character.simulated_mass
            shift = _shift(shift, wanted, _counted(need.ground, wanted, clip.rate), clip.rate)
    most = 1000.0 * float(np.linalg.norm(best.root_positions - clip.root_positions, axis=1).max())
    if most < 0.5:
        return clip
    note = f"Moved the pelvis by up to {most:.0f} mm, so that the ground can give what it takes."
    return replace(best, notes=(*best.notes, note))


def _counted(borne: Array, wanted: Array, rate: float) -> Array:
    """Weight of each frame: 0 in a stretch in the air that is no flight, else 1, (frames,)."""
    weight = np.ones(len(borne))
    aloft = borne < BORNE * borne.max(initial=1.0)
    labeled: tuple[Array, int] = label(aloft)  # type: ignore[assignment]
    for (span,) in find_objects(labeled[0]):
        lasts = (span.stop - span.start) / rate
        if lasts > BRIEF and abs(float(wanted[span, 2].mean())) > FLIGHT * 9.81:
            weight[span] = 0.0
    return weight


def _shift(shift: Array, wanted: Array, weight: Array, rate: float) -> Array:
    """The shift [m] whose acceleration comes near `wanted` [m/s^2] more than it is, (frames, 3)."""
    size = np.linalg.norm(wanted, axis=1, keepdims=True)
    wanted = wanted * np.minimum(1.0, MOST / np.maximum(size, 1e-9))
    frames, curve = len(shift), np.array([1.0, -2.0, 1.0]) * rate**2
    inner = np.arange(frames - 2)
    target = wanted[1:-1] + sum(c * shift[inner + k] for k, c in enumerate(curve))
    band, right = np.zeros((3, frames)), np.zeros_like(shift)
    band[2] = STIFFNESS
    for i in range(3):
        right[inner + i] += curve[i] * weight[1:-1, None] * target
        for j in range(i, 3):
            band[2 - (j - i), inner + j] += curve[i] * curve[j] * weight[1:-1]
    return np.clip(solveh_banded(band, right), -MOST_SHIFT, MOST_SHIFT)


def _limbs(
    clip: Clip, character: Character, ground: Ground
) -> list[tuple[list[int], Array, Array]]:
    """Joints of each limb, how far its end stays, (frames, 1), and what it bends about.

    A foot stays, 1, on the floor and not, 0, high up; a hand stays while it bears the body.
    """
    joints, limbs = [link.joint for link in character.links], []
    for side in ("left", "right"):
        leg = [f"{side}_{name}" for name in LEG]
        paths = sole_paths(clip, character, side=side)
        if set(leg) <= set(joints) and paths.shape[1]:
            height = (paths[..., 2] - ground.height(paths)).min(axis=1)
            high = np.clip((height - NEAR) / (HIGH - NEAR), 0.0, 1.0)
            stays = 1.0 - high * high * (3.0 - 2.0 * high)
            limbs.append(([joints.index(name) for name in leg], stays[:, None], LATERAL))
    for side, bears in bearing_hands(clip, character, ground).items():
        arm = [f"{side}_{name}" for name in ARM]
        if bears.any() and set(arm) <= set(joints):
            stays = gaussian_filter1d(bears.astype(float), 0.5 * BRIEF * clip.rate, mode="nearest")
            limbs.append(([joints.index(name) for name in arm], stays[:, None], VERTICAL))
    return limbs


def _moved(clip: Clip, shift: Array, limbs: list[tuple[list[int], Array, Array]]) -> Clip:
    """The clip with its pelvis shifted [m] and what rests on the floor where it was."""
    moved = replace(clip, root_positions=clip.root_positions + shift)
    local = np.array(clip.rotations)
    for limb, stays, hinge in limbs:
        moved_end(moved, limb, -stays * shift, local, hinge)
    return replace(moved, rotations=rot.continuous(local))
