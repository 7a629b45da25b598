"""What stance leg, idle leg and arms do: the text's statements about them."""

from __future__ import annotations

import math

import numpy as np

from understudy.athletics import running_law as law
from understudy.evaluate.gait import gait_of
from understudy.evaluate.gait_forces import foot_forces
from understudy.evaluate.measure import Measured, measured
from understudy.motion.rotations import Array
from understudy.papers.finding import Claim, Finding
from understudy.papers.hodgins1995.runs import armless, changed, seen, steady
from understudy.papers.sheets import Sheet
from understudy.simulate import simulate
from understudy.take import Take

SPEED = 3.5
# A foot bears more than this [body weights].
_DOWN = 0.03
# A foot that comes down with less than this part of the running speed has been matched to the
# ground's; ours.
MATCHED = 0.5


def limbs(*, quick: bool = False) -> Finding:
    """Stance leg, idle leg and arms at 3.5 m/s."""
    seconds = 4.0 if quick else 10.0
    take = simulate(steady(SPEED, seconds))
    m, first = measured(take), min(3.0, seconds / 2.0)
    work = _work(m, first)
    ankle = work["ankle"] / sum(work.values())
    figures = gait_of(m, start=first).figures()
    forward, pitch = figures["landing_forward_m_s"].mean, figures["foot_touchdown_deg"].mean
    net, alone = _hip_torques(take, m, first)
    turning = {
        name: math.degrees(math.sqrt(seen(whole, begin=first)["heading"]))
        for name, whole in (("swinging", steady(SPEED, seconds)), ("still", armless(seconds)))
    }
    still = seen(armless(seconds), begin=first)
    idle = seen(changed(steady(SPEED, seconds), mirror=0.0, mirror_ahead=0.0), begin=first)
    return Finding(
        figure="3, limbs",
        title="What the limbs do",
        setting=f"A man at {SPEED:g} m/s for {seconds:g} s. Work is that of the motors while a "
        "foot "
        "bears weight; torques are those of both hips about the sideways axis in flight. Arms at "
        "the "
        "sides: hinges of waist and arms held at zero by the servos of a layered upper body.",
        claims=(
            _landing(forward, pitch),
            Claim(
                said="The angle of the ankle keeps the toe off the ground as the heel touches.",
                measured=f"the foot lands {pitch:.0f} degrees toe up",
                holds=pitch > 2.0,
            ),
            Claim(
                said="The ankle provides the majority of the vertical thrust.",
                measured=f"{100 * ankle:.0f} % of the stance leg's positive work is the ankle's",
                holds=ankle > 0.5,
            ),
            Claim(
                said="The idle leg mirrors the active one to reduce the net torque on the body.",
                measured=f"in flight {net:.0f} N m rms from both hips, {alone:.0f} from the active "
                "one alone",
                holds=net < alone,
            ),
            Claim(
                said="The idle leg plays an important role in locomotion.",
                measured="with an idle hip that is held at its angle of the last liftoff "
                + (f"he falls after {idle['time']:.1f} s" if idle["fell"] else "he runs on"),
                holds=bool(idle["fell"]),
            ),
            Claim(
                said="The runner can run with his arms fixed at his sides.",
                measured=_ran(still, seconds),
                holds=not still["fell"],
            ),
            Claim(
                said="The counter oscillation of the arms reduces the yaw of the body.",
                measured=f"pelvis {turning['swinging']:.1f} degrees rms with swinging arms, "
                f"{turning['still']:.1f} with arms at the sides",
                holds=turning["swinging"] < turning["still"],
            ),
        ),
        sheets=(
            Sheet(
                name="Work in stance",
                caption="Positive work of the joints of the stance leg, share [%].",
                head=tuple(work),
                rows=(tuple(100.0 * value / sum(work.values()) for value in work.values()),),
            ),
        ),
        facts={
            "ankle_share_of_work": ankle,
            "landing_forward_m_s": forward,
            "hip_torque_net_n_m": net,
            "hip_torque_active_n_m": alone,
            "yaw_rms_deg_arms_swinging": turning["swinging"],
            "yaw_rms_deg_arms_still": turning["still"],
        },
    )


def _landing(forward: float, pitch: float) -> Claim:
    return Claim(
        said="Moving the leg back just before touchdown reduces the relative speed of foot and "
        "ground.",
        measured=f"the ankle comes down at {forward:.1f} m/s forward, the body runs at {SPEED:g} "
        f"(bound of ours: {100 * MATCHED:.0f} % of it)",
        holds=forward < MATCHED * SPEED,
    )


def _ran(found: dict[str, float], seconds: float) -> str:
    if found["fell"]:
        return f"he falls after {found['time']:.1f} s"
    return f"{seconds:g} s without a fall, at {found['mean_speed']:.2f} m/s"


def _work(m: Measured, first: float) -> dict[str, float]:
    """Positive work of hip, knee, ankle and ball while their foot bears weight [J]."""
    body = m.performer(0).character
    powers, names = m.joint_powers(0), [link.role or "" for link in body.links[1:]]
    force, late = foot_forces(m), m.times >= first
    out: dict[str, float] = dict.fromkeys(("hip", "knee", "ankle", "ball"), 0.0)
    for side in ("left", "right"):
        down = late & (force[side][:, 2] > _DOWN)
        for kind in out:
            own = powers[down, names.index(f"{side}_{kind}")]
            out[kind] += float(np.maximum(own, 0.0).sum() / m.rate)
    return out


def _hip_torques(take: Take, m: Measured, first: float) -> tuple[float, float]:
    """Torque of both hips and of the active one in flight about the sideways axis, rms [N m]."""
    force = foot_forces(m)
    air = (m.times >= first) & (force["left"][:, 2] < 1e-9) & (force["right"][:, 2] < 1e-9)
    columns = [take.scene.parts[0].joint_controls[leg + law.HIP_Y] for leg in _LEGS]
    both = take.ctrl[:, columns][m.steps][air]
    ahead = take.qpos[:, [7 + leg + law.HIP_Y for leg in _LEGS]][m.steps][air]
    # The active leg is the one that swings forward to land.
    active = both[np.arange(len(both)), np.argmax(ahead, axis=1)]
    return _rms(both.sum(axis=1)), _rms(active)


_LEGS = (law.LEFT_LEG, law.RIGHT_LEG)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
