"""What published full-body trackers report, with the source of every number."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Checked = Literal["source", "quoted", "memory"]


@dataclass(frozen=True, kw_only=True)
class Tracker:
    """Figures of one tracker on one set of motions.

    Attributes:
        name: What its authors call it.
        by: Authors and year.
        motions: The motions it was measured on.
        success_percent: Share of motions followed to the end by its own rule [%].
        global_mm: Mean distance of joints in the world [mm].
        relative_mm: The same with the roots at one place [mm].
        cost: What making it took.
        differs: What else to know before comparing.
        source: Where the numbers stand.
        checked: "source" when read where the authors or their project state it, "quoted" when read
            in texts that quote the paper's table, "memory" when not looked up.
    """

    name: str
    by: str
    motions: str
    success_percent: float | None = None
    global_mm: float | None = None
    relative_mm: float | None = None
    cost: str = ""
    differs: str = ""
    source: str
    checked: Checked


_TRAIN = "AMASS, 11 313 sequences, those it was trained on"
_TEST = "AMASS test set, not trained on"
_PHC = "Luo et al. 2023, arXiv 2305.06456"
_PULSE = "Luo et al. 2024, arXiv 2310.04582"
_MASKED = "Tessler et al. 2024, arXiv 2409.14393"
_README = "results table of the PHC repository's README"
_ISAAC = "SMPL body in Isaac Gym"

TRACKERS = (
    Tracker(
        name="SAMCON",
        by="Liu et al. 2010, ACM TOG 29(4) 128",
        motions="single captures: walks, runs, rolls, kip-ups",
        cost="sampling for each clip, on a compute cluster; nothing is trained",
        differs="open-loop result; no such figures are reported",
        source="the paper's abstract",
        checked="source",
    ),
    Tracker(
        name="DeepMimic",
        by="Peng et al. 2018, arXiv 1804.02717",
        motions="one policy for each motion",
        cost="about 60 million samples a motion, a day with 16 workers",
        differs="its own humanoid in Bullet; no such figures are reported",
        source="README of the authors' repository",
        checked="source",
    ),
    Tracker(
        name="UHC",
        by="Luo et al. 2021, NeurIPS",
        motions=_TRAIN,
        success_percent=97.0,
        global_mm=36.4,
        relative_mm=25.1,
        differs="an outside force on the root helps it; MuJoCo",
        source=f"table 1 of {_PHC}",
        checked="memory",
    ),
    Tracker(
        name="PHC",
        by=_PHC,
        motions=_TRAIN,
        success_percent=98.9,
        global_mm=37.5,
        cost="about a week of training, 1536 bodies at a time",
        differs=_ISAAC,
        source=f"{_README}; cost as quoted from the paper",
        checked="source",
    ),
    Tracker(
        name="PHC",
        by=_PHC,
        motions=_TEST,
        success_percent=96.4,
        global_mm=47.4,
        cost="the same",
        differs=f"{_ISAAC}; the table of {_PULSE} has 97.1 % and 47.5 mm",
        source=f"table 1 of {_PHC}",
        checked="quoted",
    ),
    Tracker(
        name="PHC+",
        by=_PULSE,
        motions=_TRAIN,
        success_percent=100.0,
        global_mm=26.6,
        differs=_ISAAC,
        source=_README,
        checked="source",
    ),
    Tracker(
        name="PHC+",
        by=_PULSE,
        motions=_TEST,
        success_percent=99.2,
        global_mm=36.1,
        differs=_ISAAC,
        source=f"table 1 of {_PULSE}",
        checked="quoted",
    ),
    Tracker(
        name="PULSE",
        by=_PULSE,
        motions=_TEST,
        success_percent=97.1,
        global_mm=54.1,
        differs=f"{_ISAAC}; distilled from PHC+",
        source=f"table 1 of {_PULSE}",
        checked="quoted",
    ),
    Tracker(
        name="MaskedMimic, its full-body teacher",
        by=_MASKED,
        motions=_TEST,
        success_percent=99.9,
        global_mm=31.3,
        cost="two weeks on 4 A100 with the distilled one, 16 384 bodies at a time",
        differs=_ISAAC,
        source=f"table 1 and training section of {_MASKED}",
        checked="quoted",
    ),
    Tracker(
        name="MaskedMimic",
        by=_MASKED,
        motions=_TEST,
        success_percent=99.2,
        global_mm=35.1,
        cost="the same",
        differs=f"{_ISAAC}; also takes sparse goals",
        source=f"table 1 of {_MASKED}",
        checked="quoted",
    ),
    Tracker(
        name="ProtoMotions tracker",
        by="NVIDIA, documentation of 2025",
        motions="AMASS, over 40 hours, those it was trained on",
        success_percent=99.0,
        cost="about 12 hours on 4 A100",
        differs=_ISAAC,
        source="tutorial 'SMPL Training on AMASS' of its documentation",
        checked="source",
    ),
    Tracker(
        name="SONIC",
        by="Luo et al. 2025, arXiv 2511.07820",
        motions="700 hours of capture",
        cost="9000 GPU hours",
        differs="a robot's body (Unitree G1): its errors are not those of a person's body",
        source="the paper's abstract",
        checked="source",
    ),
)

DIFFERENT = (
    "Motions: AMASS has thousands of clips, many of them easy; a folder of some dozen says less "
    "about what was never tried.",
    "What is asked: a learned tracker gets a motion it has not seen and follows it at once, with "
    "feedback, and its policy does others after it. A search takes each clip by itself, sees all "
    "of it beforehand, and its result is for that clip alone.",
    "Body: theirs is one body of fixed size and mass (SMPL's mean shape), its joints driven by "
    "torques up to several hundred N m. Here the body has the clip's own bones, masses from "
    "tables and the published strength of people.",
    "Error: theirs is against the clip, its height adjusted; here against the clip as it was "
    "cleaned for the body (feet set on the floor, glitches repaired).",
    "Success: theirs means that the mean distance of the joints never exceeds 0.5 m. Here free "
    "means no force on the root and never lost: center of mass within 0.2 m in height and 0.6 m "
    "in all, root within 45 degrees.",
    "Simulator: mostly Isaac Gym on graphics processors there, MuJoCo on one processor core here.",
)
