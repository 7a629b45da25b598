"""A family as a table: one row per member, CSV for spreadsheets and JSON for programs."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from understudy.family.member import FLAGS, Member
from understudy.motion.files import written

if TYPE_CHECKING:
    from understudy.family.family import Family

UNITS = {
    "away_mm": "mean distance of joints from the unvaried performance [mm]",
    "torque_ratio": "root mean square of all joint torques over unvaried",
    "force_change_n2": "mean squared change of the force through the joint [N^2]",
    "torque_change_nm2": "mean squared change of the joint's torque [(N m)^2]",
    "help_percent": "mean outside force on the pelvis [% of body weight]",
    "joint_error_deg": "root mean square from its own (varied) part [deg]",
}


def row(member: Member) -> dict[str, Any]:
    """The figures of one member that a table shows."""
    one = member.certificate["characters"][0]
    return {
        "index": member.index,
        "name": member.name,
        "preset": member.kind,
        "flags": list(member.flags),
        "notes": list(member.notes),
        "duration_s": member.duration,
        "away_mm": member.away_mm,
        "joint_error_deg": one["joint_error_deg"],
        "help_percent": one["root_force_mean_percent"],
        "torque_ratio": member.total["torque_ratio"],
        "torque_change_nm2": member.total["torque_change_nm2"],
        "force_change_n2": member.total["force_change_n2"],
        "most_changed": member.total["most_changed"],
        "says": list(member.says),
    }


def write_json(made: Family, path: Path) -> None:
    """The family as one JSON object."""
    content = {
        "kind": "understudy family",
        "clip": made.name,
        "count": len(made.members),
        "flags": {flag: {"members": n, "means": FLAGS[flag]} for flag, n in made.flagged().items()},
        "units": UNITS,
        "casting": made.cast.as_dict(),
        "unvaried": row(made.unvaried),
        "members": [{**row(m), "cost": m.cost} for m in made.members],
    }
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    with written(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def write_csv(made: Family, path: Path) -> None:
    """One row per member, and two columns per joint: mean squared change of force and torque."""
    joints = list(made.unvaried.cost)
    head = list(row(made.unvaried))
    with written(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        columns = [f"{j} {kind}" for j in joints for kind in ("force N^2", "torque (N m)^2")]
        table.writerow([*head, *columns])
        for member in (made.unvaried, *made.members):
            cells = [_cell(v) for v in row(member).values()]
            for joint in joints:
                own = member.cost[joint]
                cells += [_cell(own["force_change_n2"]), _cell(own["torque_change_nm2"])]
            table.writerow(cells)


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return "; ".join(map(str, value))
    return "" if value is None else str(value)
