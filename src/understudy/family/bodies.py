"""Members that are driven linkages: the paper's own case, judged by its own numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from understudy.character import Linkage
from understudy.evaluate.score import versions
from understudy.family.cost import RATE, Effort
from understudy.fidelity import DriveError, drive_error, drive_forces
from understudy.motion import rotations as rot
from understudy.take import Take

# A linkage fell apart when the parts of a joint are this far from each other [mm].
APART_MM = 50.0


def linkage_of(take: Take) -> Linkage | None:
    """The first performer, where it is a linkage."""
    first = take.scene.characters[0]
    return first if isinstance(first, Linkage) else None


def drive_effort(take: Take, planned: float) -> Effort:
    """Force and torque of the drive on every body: what the paper's Table 3 compares."""
    forces = drive_forces(take)
    every = take.stride(RATE)
    return Effort(
        joints=forces.joints,
        times=forces.times[::every] / max(planned, 1e-9),
        force=forces.force[::every],
        torque=forces.torque[::every],
    )


def drive_certificate(take: Take, error: DriveError) -> dict[str, Any]:
    """Errors and gaps in SI and in the clip's unit, with all they depend on."""
    facts = {k: v for k, v in take.facts.items() if k != "cpu_seconds"}
    statement = (
        "Forces on every body move this linkage along the clip; balance is not simulated. "
        + str(error)
    )
    return {
        "kind": "understudy drive certificate",
        "statement": statement,
        "duration_s": take.duration,
        "step_s": 1.0 / take.rate,
        "diverged_s": take.diverged,
        "seed": take.seed,
        "versions": versions(),
        "facts": facts,
        "mean_squared_error_units2": error.mean,
        "error_rms_mm": error.rms_mm,
        "gap_mean_units": error.gap_mean,
        "gap_max_mm": error.gap_max_mm,
        "characters": [{"joint_error_deg": None, "root_force_mean_percent": None}],
    }


def drive_flags(take: Take, error: DriveError) -> tuple[str, ...]:
    """Which flags apply to a linkage; independent bodies have no joints to fall apart."""
    apart = error.gap_max_mm > APART_MM
    return ("diverged",) * (take.diverged is not None) + ("fell apart",) * apart


def error_of(take: Take) -> DriveError:
    """The paper's equation 4 and the gaps."""
    return drive_error(take)


def joint_places(take: Take, rate: float) -> Any:
    """Where the bodies' joints are at about `rate` [Hz], (frames, joints, 3), gaps and all."""
    linkage = take.scene.characters[0]
    assert isinstance(linkage, Linkage)
    state = take.qpos[:: take.stride(rate), take.scene.parts[0].qpos]
    placed, turned = linkage.poses(state)
    return (placed + rot.rotate(turned, linkage.ends)).astype(np.float32)
