"""Figure 9: two children play patty-cake with one adult's motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from understudy.character import retargeted
from understudy.evaluate.chart import Chart, Series
from understudy.evaluate.events import ContactEvent, contact_events
from understudy.evaluate.measure import Measured, measured
from understudy.motion.clip import Clip
from understudy.motion.reaching import Meet, meeting
from understudy.motion.rotations import Array
from understudy.motion.samples import sample
from understudy.motion.samples.partner import CLAPS, PARTNER, boundaries, clap_times
from understudy.papers.filmstrip import Film
from understudy.papers.finding import Claim, Finding, Strip
from understudy.papers.sheets import Sheet
from understudy.papers.zordan1999.cast import CHILD_SCALE, paper_child
from understudy.papers.zordan1999.finding import LAW_NAMES, at_times, hand_path
from understudy.papers.zordan1999.published import FASTER, PATTY_CAKE_SPACING
from understudy.performance import together, tracked
from understudy.simulate import simulate
from understudy.take import Take

# The children stand this far apart [m].
DISTANCE = 0.66
# Offsets come and go over this time at the captured speed [s].
WINDOW = 0.3
# Distance at which the hands' middles are aimed [m]: half of what their thickness leaves, so that
# they press on each other.
APART = 0.012
# A clap is on time within this [s], and one at all within the other.
ON_TIME, NEAR = 0.05, 0.20
SPEEDS = (1.0, FASTER, 1.67, 2.0)
# Which wrists meet, the first child's and the second's, for each kind of clap.
PAIRS = {
    "right": (("right_wrist", "right_wrist"),),
    "left": (("left_wrist", "left_wrist"),),
    "both": (("right_wrist", "left_wrist"), ("left_wrist", "right_wrist")),
}
_IN_SCALE = "played back, as near as the adults in scale"
# Segments in another order than the sample's: the paper's arbitrary clap sequences.
SHUFFLED = (2, 0, 4, 1, 3)


@dataclass(frozen=True, kw_only=True)
class Game:
    """One game: how fast, with which offsets, under which law.

    Attributes:
        law: "modern" or "paper".
        speed: Of the clip.
        offsets: Whether the hands are brought together.
        window: Of the offsets, in performed seconds [s].
        stiffness: Of the servos [1/s^2].
        distance: Between the children [m].
        order: Numbers of the segments in the order played.
    """

    law: str = "modern"
    speed: float = 1.0
    offsets: bool = True
    window: float = WINDOW
    stiffness: float = 3000.0
    distance: float = DISTANCE
    order: tuple[int, ...] = (0, 1, 2, 3, 4)


@dataclass(frozen=True, kw_only=True)
class Clap:
    """One clap and the contacts that made it.

    Attributes:
        time: When it should be [s].
        events: The first contact of every pair of hands, or None where they missed.
        gaps: Distance of the hands' middles at the time, as simulated [m].
    """

    time: float
    events: tuple[ContactEvent | None, ...] = field(repr=False)
    gaps: tuple[float, ...]

    @property
    def late(self) -> float | None:
        """How late the last of its hands touched [s]; None when any missed."""
        starts = [e.start_s - self.time for e in self.events if e is not None]
        return max(starts, key=abs) if len(starts) == len(self.events) else None

    @property
    def on_time(self) -> bool:
        """Whether all its hands touched within 50 ms."""
        return self.late is not None and abs(self.late) <= ON_TIME


def hand_name(joint: str, *, second: bool = False) -> str:
    """Name of the hand at a wrist in the scene."""
    return ("b/" if second else "") + joint.replace("wrist", "hand")


def touching() -> tuple[tuple[str, str], ...]:
    """What collides: the hands of the one with those of the other."""
    hands = ("left_hand", "right_hand")
    return tuple((one, f"b/{two}") for one in hands for two in hands)


def adults_clip(order: Sequence[int]) -> Clip:
    """The adult's motion, its segments in an order of our own."""
    clip = sample("patty_cake")
    if tuple(order) == tuple(range(len(CLAPS))):
        return clip
    from understudy.motion.segments import concatenated

    ends = boundaries()
    parts = [clip.trimmed(ends[k], ends[k + 1]) for k in order]
    first, last = clip.trimmed(0.0, ends[0]), clip.trimmed(ends[-1], clip.duration)
    return concatenated([first, *parts, last], blend=0.15)


@cache
def childs_clip(order: tuple[int, ...]) -> Clip:
    """The same on a child's skeleton."""
    return retargeted(adults_clip(order), paper_child())


def claps_of(game: Game) -> list[tuple[float, tuple[tuple[str, str], ...]]]:
    """When each clap of a game is due [s], and which wrists meet."""
    times = clap_times()[: len(game.order)]
    kinds = [CLAPS[k] for k in game.order]
    return [(time / game.speed, PAIRS[kind]) for time, kind in zip(times, kinds, strict=True)]


def clips_of(game: Game) -> tuple[Clip, Clip]:
    """What the two children track."""
    clip = childs_clip(game.order)
    if len(game.order) < len(CLAPS):
        clip = clip.trimmed(0.0, boundaries()[len(game.order)])
    one = clip.placed(at=(0.0, 0.0)).retimed(game.speed)
    two = clip.placed(at=(game.distance, 0.0), heading=np.pi).retimed(game.speed)
    if not game.offsets:
        return one, two
    meets = [
        Meet(time=time, hands=pair, apart=APART, window=game.window)
        for time, pairs in claps_of(game)
        for pair in pairs
    ]
    return meeting(one, two, meets)


def played(game: Game) -> Take:
    """A game, simulated."""
    body = paper_child()
    one, two = (
        tracked(clip, body, law=game.law, stiffness=game.stiffness) for clip in clips_of(game)
    )
    return simulate(together(one, two, contacts=touching()))


def claps(take: Take, m: Measured, game: Game) -> list[Clap]:
    """What became of every clap."""
    paths = hands_of(take)
    out = []
    for time, pairs in claps_of(game):
        events, gaps = [], []
        for mine, other in pairs:
            found = contact_events(m, hand_name(mine), hand_name(other, second=True))
            near = [e for e in found if abs(e.start_s - time) <= NEAR]
            events.append(min(near, key=lambda e: abs(e.start_s - time), default=None))
            apart = np.linalg.norm(paths[0][mine] - paths[1][other], axis=1)
            gaps.append(float(np.interp(time, take.times, apart)))
        out.append(Clap(time=time, events=tuple(events), gaps=tuple(gaps)))
    return out


def hands_of(take: Take) -> list[dict[str, Array]]:
    """Path of every palm of both children [m], by the name of its wrist."""
    out = []
    for k in range(2):
        clip = take.clip(k, rate=take.rate)
        out.append({f"{side}_wrist": hand_path(clip, side) for side in ("left", "right")})
    return out


def misses(game: Game) -> tuple[float, float]:
    """How far the clips' hands are from where they are aimed at claps [m]: mean and largest."""
    one, two = clips_of(game)
    aimed = APART if game.offsets else 0.0
    away = []
    for time, pairs in claps_of(game):
        for mine, other in pairs:
            a, b = (
                at_times(hand_path(clip, joint.split("_")[0]), clip.times, np.array([time]))[0]
                for clip, joint in ((one, mine), (two, other))
            )
            away.append(abs(float(np.linalg.norm(a - b)) - aimed))
    return float(np.mean(away)), max(away)


def games(*, quick: bool = False) -> list[tuple[str, Game]]:
    """Every game of the figure, named."""
    order = (0,) if quick else (0, 1, 2, 3, 4)
    out = []
    for law in ("modern", "paper"):
        if law == "modern" or not quick:
            plain = Game(law=law, offsets=False, order=order)
            out.append(("played back on the children", plain))
        for speed in ((1.0,) if law == "modern" else (1.0, 2.0)) if quick else SPEEDS:
            game = Game(law=law, speed=speed, window=WINDOW / speed, order=order)
            out.append(("offsets", game))
        for speed in (2.0,) if quick else (1.67, 2.0):
            out.append(("longer offsets", Game(law=law, speed=speed, order=order)))
    if not quick:
        out.append((_IN_SCALE, Game(offsets=False, distance=CHILD_SCALE * PARTNER)))
        for speed in (1.67, 2.0):
            soft = Game(law="paper", speed=speed, window=WINDOW / speed, stiffness=1000.0)
            out.append(("offsets, softer", soft))
        out.append(("offsets, segments in another order", Game(order=SHUFFLED)))
    return out


def clapping(*, quick: bool = False) -> Finding:
    """All games."""
    played_games = []
    shown: dict[tuple[str, str, float], Take] = {}
    for name, game in games(quick=quick):
        take = played(game)
        shown[name, game.law, game.speed] = take
        m = measured(take)
        played_games.append((name, game, claps(take, m, game), _strange(m, game)))
    rows = [_row(name, game, found, odd) for name, game, found, odd in played_games]
    return _finding(played_games, rows, shown)


def _strange(m: Measured, game: Game) -> int:
    """Contacts of hands that should not have met then."""
    wanted = [
        (time, {hand_name(mine), hand_name(other, second=True)})
        for time, pairs in claps_of(game)
        for mine, other in pairs
    ]
    return sum(
        not any(
            set(event.between) == names and event.start_s - NEAR <= time <= event.end_s + NEAR
            for time, names in wanted
        )
        for event in contact_events(m)
        if "ground" not in event.between
    )


def _row(name: str, game: Game, found: list[Clap], odd: int) -> tuple[object, ...]:
    lates = [1e3 * clap.late for clap in found if clap.late is not None]
    events = [e for clap in found for e in clap.events if e is not None]
    return (
        name,
        game.law,
        game.speed,
        game.stiffness,
        1e3 * game.window if game.offsets else None,
        game.distance,
        len(lates),
        sum(clap.on_time for clap in found),
        len(found),
        float(np.mean(lates)) if lates else None,
        max(lates, key=abs) if lates else None,
        float(np.mean([e.impulse_ns for e in events])) if events else None,
        float(np.mean([e.approach_m_s for e in events])) if events else None,
        max(e.penetration_mm for e in events) if events else None,
        odd,
    )


_HEAD = (
    "hands",
    "law",
    "speed",
    "stiffness [1/s^2]",
    "window [ms]",
    "distance [m]",
    "claps made",
    "within 50 ms",
    "of",
    "late, mean [ms]",
    "late, worst [ms]",
    "impulse, mean [N s]",
    "closing speed, mean [m/s]",
    "overlap, deepest [mm]",
    "other contacts",
)


def _finding(
    played_games: list[tuple[str, Game, list[Clap], int]],
    rows: list[tuple[object, ...]],
    shown: dict[tuple[str, str, float], Take],
) -> Finding:
    made = {
        (name, game.law, game.speed): (
            sum(clap.late is not None for clap in found),
            sum(clap.on_time for clap in found),
            len(found),
        )
        for name, game, found, _ in played_games
    }
    plain = next(game for name, game, *_ in played_games if not game.offsets)
    with_offsets = next(game for name, game, *_ in played_games if game.offsets)
    raw, aimed = misses(plain), misses(with_offsets)
    fast = [speed for name, law, speed in made if (name, law) == ("longer offsets", "paper")]
    slow = made["offsets", "modern", 1.0]
    quicker = made.get(("offsets", "modern", FASTER), slow)
    literal = [made["offsets", "paper", s] for s in fast]
    longer = [made["longer offsets", "paper", s] for s in fast]
    modern = [made["longer offsets", "modern", s] for s in fast]
    others = [(name, game) for name, game, _, odd in played_games if odd]

    def told(values: list[tuple[int, int, int]]) -> str:
        pairs = zip(values, fast, strict=True)
        return ", ".join(f"{made_} of {all_} at {s:g}x" for (made_, _, all_), s in pairs)

    near = made.get((_IN_SCALE, "modern", 1.0))
    in_scale = (
        f"; at {CHILD_SCALE * PARTNER:.2f} m, the adults' distance in scale, {near[0]} of "
        f"{near[2]} without any offsets"
        if near
        else ""
    )
    soft = [v for (name, _, _), v in made.items() if name == "offsets, softer"]
    softer = f"; with a third of the stiffness {told(soft)}" if soft else ""
    claims = [
        Claim(
            said="Played back on the children, the hands miss.",
            measured=f"the hands' middles are {1e3 * raw[0]:.0f} mm apart on average, and "
            f"{made['played back on the children', 'modern', 1.0][0]} of {slow[2]} claps are made "
            f"at {DISTANCE:g} m{in_scale}",
            holds=made["played back on the children", "modern", 1.0][0] == 0,
        ),
        Claim(
            said="Offsets by inverse kinematics fix it.",
            measured=f"misses of the clips at the claps: {1e3 * aimed[1]:.2f} mm at most "
            "(goal: 2 mm)",
            holds=aimed[1] <= 0.002,
        ),
        Claim(
            said="Hands collide at each clap.",
            measured=f"{slow[1]} of {slow[2]} claps within 50 ms (modern law), "
            f"{made['offsets', 'paper', 1.0][0]} made under the paper's law, late by its lag",
            holds=slow[1] == slow[2] and made["offsets", "paper", 1.0][0] == slow[2],
        ),
    ]
    if ("offsets", "paper", FASTER) in made:
        claims.append(
            Claim(
                said="At 133 % the same offsets still bring every clap.",
                measured=f"{quicker[1]} of {quicker[2]} within 50 ms (modern law), "
                f"{made['offsets', 'paper', FASTER][0]} made under the paper's law",
                holds=quicker[1] == quicker[2]
                and made["offsets", "paper", FASTER][0] == quicker[2],
            )
        )
    claims += [
        Claim(
            said="At greater speed lags prevent contact; longer offsets help.",
            measured=f"paper's law: {told(literal)}; with longer windows {told(longer)}{softer}",
            holds=sum(v[0] for v in literal) < sum(v[2] for v in literal)
            and sum(v[0] for v in longer) > sum(v[0] for v in literal),
        ),
        Claim(
            said="(Goal of our own: 4 of 5 claps on time at 1.67x and 2x with longer windows.)",
            measured="modern law: "
            + ", ".join(f"{v[1]} of {v[2]} at {s:g}x" for v, s in zip(modern, fast, strict=True)),
            holds=all(v[1] >= 0.8 * v[2] for v in modern),
        ),
    ]
    shuffled = made.get(("offsets, segments in another order", "modern", 1.0))
    if shuffled:
        claims.append(
            Claim(
                said="Segments between own claps can be put in any order.",
                measured=f"order {', '.join(CLAPS[k] for k in SHUFFLED)}: {shuffled[1]} of "
                f"{shuffled[2]} claps within 50 ms",
                holds=shuffled[1] == shuffled[2],
            )
        )
    claims.append(
        Claim(
            said="(Goal of our own: no other hands touch.)",
            measured="none in any game"
            if not others
            else "in " + "; ".join(f"{n}, {LAW_NAMES[g.law]}, {g.speed:g}x" for n, g in others),
            holds=not others,
        )
    )
    best, missed = (
        shown["offsets", "modern", 1.0],
        shown["played back on the children", "modern", 1.0],
    )
    lasting = min(best.duration, 3.5)
    times = tuple(0.5 + PATTY_CAKE_SPACING * k for k in range(int(lasting / PATTY_CAKE_SPACING)))
    return Finding(
        figure="9",
        title="Patty-cake",
        setting=f"sample:patty_cake, an adult of 1.75 m, on two children of "
        f"{paper_child().height:.2f} m (scale {CHILD_SCALE}) with a child's proportions, "
        f"{DISTANCE} m apart: the paper does not say how far. Stiffness 3000 /s^2 under both laws. "
        f"The hands' middles are aimed {1e3 * APART:.0f} mm apart, so that they press.",
        claims=tuple(claims),
        charts=(_chart(shown, with_offsets),),
        strips=(
            Strip(
                alt="Two children play patty-cake; without offsets their hands do not meet.",
                films=(
                    Film(title="with offsets", thing=best, times=times, view="side", heading=0.0),
                    Film(title="played back", thing=missed, times=times, view="side", heading=0.0),
                ),
            ),
        ),
        sheets=(
            Sheet(
                name="Figure 9",
                caption="Claps of every game. A clap is made when all its hands touch within "
                f"{NEAR} s of its time.",
                head=_HEAD,
                rows=tuple(rows),
                notes=(
                    "Windows of longer offsets last as long as at the captured speed.",
                    "Damped by a tenth of its stiffness, a softer servo is less overdamped: at "
                    "1000 /s^2 the hands are as late, but go farther.",
                    "Children of nearly an adult's proportions who stand as near in scale as the "
                    "adults do need no offsets: the motion is similar.",
                ),
            ),
        ),
        facts={
            "miss_played_back_mean_mm": 1e3 * raw[0],
            "miss_with_offsets_mm": 1e3 * aimed[1],
            "claps": {
                f"{name}, {law}, {speed:g}x": {"made": v[0], "within_50_ms": v[1], "of": v[2]}
                for (name, law, speed), v in made.items()
            },
        },
    )


def _chart(shown: dict[tuple[str, str, float], Take], game: Game) -> Chart:
    """Distance of the two hands of every clap, or of the right hands, over time."""
    series = []
    for label, key in (
        ("offsets, modern law", ("offsets", "modern", 1.0)),
        ("offsets, paper's law", ("offsets", "paper", 1.0)),
        ("played back, modern law", ("played back on the children", "modern", 1.0)),
    ):
        take = shown[key]
        series.append(Series(name=label, x=take.times, y=_nearest(take)))
    due = ", ".join(f"{time:g}" for time, _ in claps_of(game))
    return Chart(
        title="Figure 9: distance of the children's hands",
        caption=f"Middles of the nearest two hands; claps are due at {due} s.",
        x_label="Time [s]",
        y_label="Distance [cm]",
        series=tuple(series),
    )


def _nearest(take: Take) -> Array:
    first, second = (tuple(paths.values()) for paths in hands_of(take))
    apart = [np.linalg.norm(one - two, axis=1) for one in first for two in second]
    return 100.0 * np.min(apart, axis=0)
