"""An athlete that stands: what its law reads of the body, and how it begins.

The laws are in `standing_law`. `Running` uses them where its course asks for standing.
"""

from __future__ import annotations

import numpy as np

from understudy.athletics import running_law as law
from understudy.athletics import standing_law as stand
from understudy.athletics import support_law as support
from understudy.athletics.standing_gains import BODY_NUMBERS, STANDING_NAMES, StandingGains
from understudy.character import Athlete
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array

# Parts of the sole, from the heel's pad to the ball's, on which a foot stands fast: on the last pad
# alone it would spin. Half its width over stature.
_BACK, _FRONT, _HALF = 0.7, 0.8, 0.014
# Angles of arms that hang, outward and of the elbow [rad].
_OUT, _BENT = 0.15, 0.25


def standing_parameters(
    body: Athlete, bodies: tuple[int, ...], runner: Array, gains: StandingGains
) -> Array:
    """What the law reads besides a runner's parameters.

    Args:
        body: Who stands.
        bodies: Numbers of its links in the engine.
        runner: The head of the runner's parameters.
        gains: Numbers of the law.
    """
    out = np.zeros(BODY_NUMBERS)
    mass = [link.mass for link in body.links]
    first = body.index("left_hip")
    thighs = (bodies[first], bodies[body.index("right_hip")])
    leg = [sum(mass[first + k : first + 4]) for k in range(3)]
    heel, ball = runner[law.P_HEEL_X], runner[law.P_HEEL_X] + runner[law.P_FOOT]
    out[:] = (*thighs, *leg, _BACK * heel, _FRONT * ball, _HALF * body.height, tallest(body))
    return np.concatenate((out, [getattr(gains, name) for name in STANDING_NAMES]))


def standing_memory(parameters: Array, *, runs: bool, heading: float) -> Array:
    """What the law remembers at time zero, of one that runs or of one that stands."""
    out = np.zeros(stand.STANDING_MEMORY)
    first = law.M_COURSE + stand.COURSE_MEMORY
    out[stand.MODE - first] = stand.RUNNING if runs else stand.STANDING
    out[stand.AT_HEIGHT - first] = parameters[support.STRAIGHT] * parameters[support.HEIGHT]
    out[stand.ARMS - first] = float(runs)
    out[stand.FACING - first] = heading
    out[stand.LOAD - first] = 0.5
    return out


def tallest(body: Athlete) -> float:
    """Center of mass over the soles with straight legs and hanging arms [m]."""
    places = np.zeros((len(body.links), 3))
    turns = rot.identity(len(body.links))
    for i, link in enumerate(body.links):
        if i:
            places[i] = places[link.parent] + rot.rotate(turns[link.parent], link.offset)
            turns[i] = rot.multiply(turns[link.parent], body.rests[i])
    heights = [
        place[2] + rot.rotate(turn, link.com)[2]
        for place, turn, link in zip(places, turns, body.links, strict=True)
    ]
    center = np.average(heights, weights=[link.mass for link in body.links])
    return float(center - places[body.index("left_ankle"), 2]) - body.sole_height


def at_rest(body: Athlete, gains: StandingGains) -> tuple[Array, Array]:
    """Positions and velocities of quiet standing at the origin, facing +x."""
    nq, nv = body.widths
    qpos, qvel = np.zeros(nq), np.zeros(nv)
    thigh = -float(body.link("left_knee").offset[2])
    shank = -float(body.link("left_ankle").offset[2])
    # Legs are a part of what hangs below the center of mass: they shorten by more than it sinks.
    sinks = 1.25 * (1.0 - gains.straight) * tallest(body)
    length = thigh + shank - sinks
    knee = np.arccos((length**2 - thigh**2 - shank**2) / (2.0 * thigh * shank))
    hip = np.arctan2(shank * np.sin(knee), thigh + shank * np.cos(knee))
    qpos[2], qpos[3] = float(body.links[0].offset[2]) - sinks - 0.001, 1.0
    for leg in (law.LEFT_LEG, law.RIGHT_LEG):
        qpos[7 + leg + law.HIP_Y], qpos[7 + leg + law.KNEE] = hip, knee
        qpos[7 + leg + law.ANKLE_H] = knee - hip
    for arm, out in ((law.LEFT_ARM, 1.0), (law.RIGHT_ARM, -1.0)):
        qpos[8 + arm], qpos[10 + arm] = _OUT * out, _BENT
    return qpos, qvel
