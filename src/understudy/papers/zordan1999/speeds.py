"""Figure 6: speed of the hands, raw, played back and simulated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from understudy.character import Character, retargeted
from understudy.character.bodies import alien
from understudy.evaluate.chart import Chart, Series
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.papers.finding import Claim, Finding
from understudy.papers.sheets import Sheet
from understudy.papers.zordan1999.cast import Cast
from understudy.papers.zordan1999.finding import acceleration_of, at_times, hand_path, speed_of
from understudy.performance import tracked
from understudy.simulate import simulate
from understudy.take import Take

# What the sensors give: orientations at a rate [Hz] (paper: 15 to 25) with noise [deg].
SENSED, NOISE, SEED = 20.0, 1.0, 1999
# Hands are compared at this rate [Hz].
RATE = 120.0
# A sharp turn of the hand within a frame is a spike: compared by this part of the accelerations.
SPIKE = 99.9
# How the motion is tracked: name, law, stiffness [1/s^2].
WAYS = (
    ("the paper's law, stiffness 1000 /s^2", "paper", 1000.0),
    ("the paper's law, stiffness 3000 /s^2", "paper", 3000.0),
    ("modern law, stiffness 1000 /s^2", "modern", 1000.0),
)


def sensed(clip: Clip, *, rate: float = SENSED, noise: float = NOISE, seed: int = SEED) -> Clip:
    """A clip as orientation sensors on its segments give it: few samples, and noise.

    Every segment's world orientation is off by a rotation vector whose three parts are normal with
    a standard deviation of `noise` [deg], independent from sample to sample; joint angles are what
    remains between segments (equation 1).
    """
    few = clip.resampled(rate)
    pose = few.forward_kinematics()
    off = np.radians(noise) * np.random.default_rng(seed).standard_normal(
        (*pose.rotations.shape[:2], 3)
    )
    world = rot.multiply(pose.rotations, rot.from_rotvec(off))
    local = np.array(world)
    for i, parent in enumerate(clip.skeleton.parents[1:], 1):
        local[:, i] = rot.multiply(rot.conjugate(world[:, parent]), world[:, i])
    return replace(few, rotations=local)


def speeding(cast: Cast, *, quick: bool = False) -> Finding:
    """The actor's own body, and the alien."""
    actor = Character.from_clip(cast.gesture, plan="upper")
    motion = retargeted(cast.gesture.repaired(), actor)
    given = sensed(motion)
    times = np.arange(int(given.duration * RATE)) / RATE
    paths: dict[str, dict[str, Array]] = {
        "raw": _paths(motion, times),
        "kinematic playback": _paths(given.resampled(RATE), times),
    }
    for name, law, stiffness in WAYS[:1] if quick else WAYS:
        take = simulate(tracked(given, actor, law=law, stiffness=stiffness, interpolation="slerp"))
        paths[name] = _paths(take, times)
    creature = alien(plan="upper")
    theirs = retargeted(given, creature, actor=actor)
    paths["alien, kinematic playback"] = _paths(theirs.resampled(RATE), times)
    _, law, stiffness = WAYS[0]
    take = simulate(tracked(theirs, creature, law=law, stiffness=stiffness, interpolation="slerp"))
    paths["alien, the paper's law, stiffness 1000 /s^2"] = _paths(take, times)
    return _finding(cast, times, paths)


def _paths(thing: Clip | Take, times: Array) -> dict[str, Array]:
    """Both palms from the pelvis's place, at times [s]."""
    clip = thing.clip(rate=thing.rate) if isinstance(thing, Take) else thing
    return {
        side: at_times(hand_path(clip, side) - clip.root_positions, clip.times, times)
        for side in ("left", "right")
    }


def _peaks(paths: dict[str, Array]) -> tuple[float, float, float]:
    """Peak speed of the left and the right hand [m/s], and how sharp the sharpest turns are."""
    left, right = (float(speed_of(paths[side], RATE).max()) for side in ("left", "right"))
    sharp = np.concatenate([acceleration_of(path, RATE) for path in paths.values()])
    return left, right, float(np.percentile(sharp, SPIKE))


def _finding(cast: Cast, times: Array, paths: dict[str, dict[str, Array]]) -> Finding:
    found = {name: _peaks(path) for name, path in paths.items()}
    raw, back, literal = found["raw"], found["kinematic playback"], found[WAYS[0][0]]
    side = 0 if raw[0] > raw[1] else 1
    ratio = literal[side] / raw[side]
    rows = [(name, *values, values[side] / raw[side]) for name, values in found.items()]
    creature = [values for name, values in found.items() if name.startswith("alien")]
    hand = ("left", "right")[side]
    series = [
        Series(name=name, x=times, y=speed_of(paths[key][hand], RATE))
        for name, key in (
            ("simulated, the paper's law", WAYS[0][0]),
            ("kinematic playback", "kinematic playback"),
            ("raw", "raw"),
        )
    ]
    return Finding(
        figure="6",
        title="Speed of the hand in a gesture",
        setting=f"{cast.source}. Playback and simulation get what sensors would give: orientations "
        f"at {SENSED:g} Hz with {NOISE:g} degree of noise (seed {SEED}), by slerp in between; raw "
        "is the clip itself. Hands as seen from the pelvis, compared at 120 Hz.",
        claims=(
            Claim(
                said="The simulated motion has peaks similar to the raw marker's.",
                measured=f"{hand} hand {literal[side]:.2f} m/s simulated, {raw[side]:.2f} raw "
                f"({round(100 * (ratio - 1)):+d} %)",
                holds=abs(ratio - 1.0) <= 0.25,
            ),
            Claim(
                said="Kinematic playback has spikes of unnatural acceleration.",
                measured=f"{SPIKE} % of accelerations are below {back[2]:.0f} m/s^2 played back, "
                f"{raw[2]:.0f} raw and {literal[2]:.0f} simulated",
                holds=back[2] > 2.0 * literal[2] and back[2] > 1.5 * raw[2],
            ),
            Claim(
                said="The simulated motion is smoother than its input; so is the alien's.",
                measured=f"alien: {creature[0][2]:.0f} m/s^2 played back, {creature[1][2]:.0f} "
                "simulated",
                holds=creature[1][2] < 0.5 * creature[0][2],
            ),
        ),
        charts=(
            Chart(
                title=f"Figure 6: speed of the {hand} hand",
                caption="The corners of the played back curve are the sensors' samples.",
                x_label="Time [s]",
                y_label="Speed [m/s]",
                series=tuple(series),
                decimals=2,
            ),
        ),
        sheets=(
            Sheet(
                name="Figure 6",
                caption="Peak speeds of the hands and their sharpest accelerations.",
                head=(
                    "motion",
                    "peak speed, left [m/s]",
                    "peak speed, right [m/s]",
                    f"acceleration, {SPIKE} % [m/s^2]",
                    f"peak, {hand}, over raw",
                ),
                rows=tuple(rows),
                notes=(
                    "The alien's arms are half as long again, so its hands are faster.",
                    "A stiffer servo follows the noise of its input more closely.",
                ),
            ),
        ),
        facts={
            "peak_speed_over_raw": ratio,
            "acceleration_played_back_m_s2": back[2],
            "acceleration_simulated_m_s2": literal[2],
            "acceleration_raw_m_s2": raw[2],
        },
    )
