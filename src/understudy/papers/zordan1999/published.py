"""Zordan & Hodgins 1999: what each figure shows, and the few numbers the paper gives."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A figure of the paper.

    Attributes:
        number: As printed.
        title: Short.
        shows: What can be seen in it, in words of ours.
        claims: What the text says about it; each can be held against a measurement.
    """

    number: int
    title: str
    shows: str
    claims: tuple[str, ...]


FIGURES = (
    Figure(
        number=1,
        title="Dynamic tracking beside live motion",
        shows="An actor and two animated characters that track his gesture.",
        claims=(
            "Tracking keeps the overall characteristics of the motion.",
            "It imposes the dynamics of the animated character.",
        ),
    ),
    Figure(
        number=4,
        title="Height of a drumming hand",
        shows="Four curves over one impact: simulated with and without contact, kinematic "
        "playback, and the hand marker of the capture.",
        claims=(
            "With contact the hand stops at the drum.",
            "Without contact, simulated or played back, it goes through the drum noticeably.",
            "Timing, duration and reaction of the impact come from the simulation.",
        ),
    ),
    Figure(
        number=5,
        title="Hand position through a transition to a slap",
        shows="Patty-cake, a transition and a slap: kinematic and simulated hand positions.",
        claims=(
            "Blended joint angles are continuous (sinusoid ease, slerp).",
            "The simulation smooths the transition and changes motion after its end, too.",
        ),
    ),
    Figure(
        number=6,
        title="Speed of the hand in a gesture",
        shows="Three curves: raw marker, kinematic playback, simulated.",
        claims=(
            "The simulated motion has peaks similar to the raw marker's.",
            "Kinematic playback has spikes of unnatural acceleration.",
            "The simulated motion lags a little and is smoother than its input.",
        ),
    ),
    Figure(
        number=7,
        title="Gestures on different bodies",
        shows="Characters with different masses and proportions that track one actor.",
        claims=("One capture drives bodies with different dynamics.",),
    ),
    Figure(
        number=8,
        title="Drum, staff and bow",
        shows="Film strips of an impact on a drum, of a staff kept upright, and of a bow with a "
        "simulated lower body.",
        claims=(
            "The hand meets the drum in a dynamic impact.",
            "A servo in the wrist keeps the staff upright, and it sways under its own mass; the "
            "raw data lets it tilt.",
            "A balance controller at hips, knees and ankles holds the center of mass over the "
            "feet through a bow; legs were not captured.",
        ),
    ),
    Figure(
        number=9,
        title="Patty-cake",
        shows="Two children of one adult's motion, their hands meeting at each clap.",
        claims=(
            "Played back on the children, the hands miss; offsets by inverse kinematics fix it.",
            "Hands collide at each clap.",
            "At 133 % of the speed the same offsets still bring every clap.",
            "At greater speed lags prevent contact; longer offsets help to some extent.",
            "Segments that begin and end with own hands together can be put in any order.",
        ),
    ),
)

# Section 3: sizes of the two models.
UPPER_BODY_LINKS = (8, 9)
UPPER_BODY_DOF = (24, 27)
FULL_BODY_LINKS = 16
FULL_BODY_DOF = 48
# Section 3: the capture's rate [Hz]; damping gain as a part of the stiffness.
CAPTURE_RATE = (15.0, 25.0)
DAMPING = 0.1
# Section 5.1: the speed at which the offsets need no change.
FASTER = 1.33
# Captions of figures 8 and 9: time between pictures [s].
DRUM_SPACING = 0.13
PATTY_CAKE_SPACING = 0.5

NOT_COMPARABLE = (
    "The paper prints no numbers for its figures: curves and pictures are compared by what the "
    "text says of them.",
    "Its captures are not published. Bundled motions, made and not captured, stand in for the "
    "drum, the staff, the bow and patty-cake; a capture can be used for the gesture.",
    "A made motion has no raw markers. Where the paper plots them, the clip itself at its full "
    "rate stands in, and kinematic playback is the clip sampled at 20 Hz and interpolated.",
    "Stiffness values are not given; those used here are printed beside each figure.",
    "Pictures are drawn by this package from its own camera.",
)
