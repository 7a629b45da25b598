"""Hodgins et al. 1995: what the figures show and what the text says of running."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A figure of the paper.

    Attributes:
        number: As printed.
        shows: What can be seen in it, in words of ours.
    """

    number: int
    shows: str


FIGURES = (
    Figure(number=1, shows="A runner in a stadium, and a gymnast on her hands."),
    Figure(
        number=2, shows="Segments and controlled degrees of freedom of the runner and the others."
    ),
    Figure(
        number=3,
        shows="The runner's states in a circle, and what leads from each to the next.",
    ),
    Figure(
        number=5,
        shows="Rows of pictures, among them a runner every 0.066 s, a group of runners every 0.5 "
        "s, "
        "and the simulated runner beside a person on a treadmill every 0.066 s.",
    ),
    Figure(
        number=6,
        shows="Knee over hip angle through a stride, simulated on the left and measured in people "
        "on the right.",
    ),
)

# Figure 2 and its caption.
SEGMENTS, DEGREES_OF_FREEDOM = 17, 30
# Speeds the runner can be asked for [m/s].
SPEEDS = (2.5, 5.0)
# Part of the expected stance after which the ankle thrusts.
THRUST = (0.30, 0.50)
# Captions of figure 5: time between pictures [s].
RUNNER_SPACING, GROUP_SPACING = 0.066, 0.5
# The bicyclist's simulation took ten times as long as its motion.
SLOWER = 10.0

NOT_COMPARABLE = (
    "The paper prints no numbers for its runner beyond those above: no gains, no speeds, no "
    "times of "
    "stance or flight. Its statements are held against measurements, each with a bound of ours.",
    "Figure 6 has no numbers on its curves beyond its axes, and does not name speed or source of "
    "its "
    "human data; people of the same speed stand in (Fukuchi, Fukuchi & Duarte 2017), and captured "
    "runs where there are any.",
    "The bodies are not the paper's polygons: segments are those of de Leva 1996.",
    "Contacts of the feet are the engine's soft ones, not constraints held by Baumgarte's method.",
    "Pictures are drawn by this package from its own camera.",
)
