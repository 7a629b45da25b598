"""Wilke & Semwal 2017: their tables, number for number."""

from __future__ import annotations

from dataclasses import dataclass

KINDS = ("independent", "skeleton", "constrained")
KIND_NAMES = {
    "independent": "Independent rigid bodies",
    "skeleton": "Physical skeleton",
    "constrained": "Constrained physical skeleton",
}


@dataclass(frozen=True)
class Tuned:
    """A row of table 1: order n, K_f, K_vc, squared error, variance, points a run, runs."""

    order: int
    gain: float
    speed: float
    error: float
    variance: float
    points: int
    runs: int


TABLE_1 = {
    "independent": Tuned(5, 98.5331, 85.46, 0.511, 0.561, 100, 5),
    "skeleton": Tuned(5, 32.5875, 86.419, 0.874, 0.660, 100, 9),
    "constrained": Tuned(3, 24.1933, 120.798, 1.472, 0.999, 100, 10),
}

# Squared error and variance by file and linkage.
TABLE_2 = {
    "141_02": {
        "independent": (3.431, 0.194),
        "skeleton": (3.262, 0.174),
        "constrained": (0.669, 0.022),
    },
    "141_08": {
        "independent": (2.992, 0.023),
        "skeleton": (2.389, 0.020),
        "constrained": (0.237, 0.007),
    },
    "141_14": {
        "independent": (0.121, 0.0005),
        "skeleton": (0.234, 0.012),
        "constrained": (0.395, 0.042),
    },
    "141_30": {
        "independent": (4.612, 0.029),
        "skeleton": (3.220, 0.071),
        "constrained": (0.893, 0.164),
    },
}

# Mean squared change of force and of torque by joint when RightFoot is scaled.
TABLE_3 = {
    "RightFoot": (15.196, 23.643),
    "RightLeg": (4.458, 1.640),
    "RightUpLeg": (1.618, 2.548),
    "Spine": (0.148, 0.554),
    "LeftFoot": (0.0987, 0.0949),
    "LeftLeg": (0.084, 0.143),
    "LeftUpLeg": (0.307, 1.043),
    "LeftHand": (0.009, 0.145),
    "LeftForeArm": (0.002, 0.002),
    "LeftArm": (0.008, 0.002),
    "Head": (0.010, 0.008),
}
# Section 2.1: the factor, and how many frames it lasts here (theirs: 200 <= f <= 600).
KICK_SCALE, KICK_FRAMES = 1.2, 200

TABLE_4 = {"LeftFoot": 1.1, "RightFoot": 0.9, "LeftHand": 1.5, "RightHand": 0.5}

# Section 2.2: joints locked in all axes, masses where others have 1, and who is not controlled.
ZOMBIE_LOCKS = ("LeftLeg", "LeftHand")
ZOMBIE_MASSES = {
    "LeftFoot": 5.0,
    "LeftLeg": 10.0,
    "LHipJoint": 20.0,
    "LeftHand": 0.25,
    "LeftForeArm": 2.0,
    "LeftArm": 5.0,
}
UNCONTROLLED = ("LeftHand", "LeftFoot")

NOT_COMPARABLE = (
    "The paper states neither the time step nor the scale of the simulated model nor how it "
    "applies gravity. Here a step is one frame of 60 Hz, gravity is 9.81 units per second "
    "squared, and the scale is 1.4286, which K_vc = scale x frame rate implies for the "
    "published 85 to 86. Real gravity would be 173.8 units per second squared.",
    "Without feedforward bodies sink with speed g / K_f, so the mean squared error cannot be "
    "less than about (g T / (scale K_f))^2 / 3 whatever is tuned; the column 'sag law' gives "
    "it. It explains the published row of independent bodies. The two skeleton rows are "
    "several times lower than their own published gains allow, so something there is unstated "
    "(weaker gravity, a floor, a compensation); they are compared but not expected to agree.",
    "K_vc = 120.8 of the constrained row is a scale of 2, or a poor local optimum: one clip "
    "in place cannot tell. Its gains are run at both scales.",
    "The published variance of 0.56 of independent bodies is not explained by any setting tried.",
    "The paper gives a force law and no torque law. Here the torque is K_f I (w* - w) with "
    "the full inertia tensor; without it light bodies are unstable above K_f of a few, which "
    "may be why the paper's skeleton gains are low.",
    "Table 3 does not say in which units, over which frames and per which mass its squares "
    "are averaged, so its order and ratios can be compared, its values cannot.",
    "Which bodies the zombie leaves uncontrolled is not listed; here the left hand and the "
    "left foot are, as in figure 8.",
    "Errors grow with the square of a clip's length, so those of clips of other lengths "
    "differ for that reason alone.",
    "Stills are drawn by this package from its own camera; they show the same moment of the "
    "same experiment, not the same picture.",
)
