"""Clips to begin with, made on the spot: no file, no download, nobody's copyright.

`sample("walk")` gives a clip on the standard figure at 120 Hz; each says in its notes that it was
made and from what.
"""

from __future__ import annotations

from collections.abc import Callable

from understudy.errors import UnknownName, expect
from understudy.motion.clip import Clip
from understudy.motion.gait import walk
from understudy.motion.samples.bowing import bow
from understudy.motion.samples.gestures import gesture
from understudy.motion.samples.partner import patty_cake, slap
from understudy.motion.samples.pumping import staff
from understudy.motion.samples.rhythm import clapping, drumming
from understudy.motion.samples.striking import strike


def samples() -> tuple[str, ...]:
    """Names of the clips that come with the package."""
    return tuple(_MAKERS)


def sample(name: str) -> Clip:
    """A clip that comes with the package, on the standard figure (1.75 m), 120 Hz.

    "gesture": stands, waves, points (6 s). "walk": level walking at 1.32 m/s (5 s). "drumming":
    both hands in turn, 5 strokes a second (5 s). "clapping": two claps a second (5 s). "strike":
    four strokes of the right hand on a drum at 3.2 to 3.5 m/s (6 s). "staff": pumps a vertical
    staff in the right hand (6 s). "bow": bows by 60 degrees and holds it (9 s). "patty_cake": claps
    own hands and a partner's in turn (6 s). "slap": from own hands together to a slap (3 s).

    Where and when these touch something is said beside their makers: `striking.DRUM` and `HITS`,
    `pumping.GRIP`, `bowing.HELD`, `partner.clap_times`, `boundaries`, `SLAP` and `CHEEK`.

    Raises:
        UnknownName: Another name; the text lists those there are.
    """
    expect(name, str, "name", f"one of {', '.join(_MAKERS)}")
    if name not in _MAKERS:
        raise UnknownName("sample", name, _MAKERS)
    return _MAKERS[name]()


_MAKERS: dict[str, Callable[[], Clip]] = {
    "gesture": gesture,
    "walk": walk,
    "drumming": drumming,
    "clapping": clapping,
    "strike": strike,
    "staff": staff,
    "bow": bow,
    "patty_cake": patty_cake,
    "slap": slap,
}
