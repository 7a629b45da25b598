"""What a variation is: a value that makes a performance of a performance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np

from understudy.character import Character, Linkage
from understudy.control import Tracking
from understudy.control.feedforward import Rehearsal
from understudy.errors import InvalidValue
from understudy.performance import Performance
from understudy.scene import Scene

# An amount, or the range it is drawn from.
Amount = float | tuple[float, float]
Own = TypeVar("Own", bound="Variation")


@dataclass(frozen=True, kw_only=True)
class Variation:
    """A change of a performance; the base of all.

    Attributes:
        character: Which of the scene's characters it changes.
    """

    character: int = 0

    def __call__(self, performance: Performance) -> Performance:
        """The changed performance; the same one where nothing changes.

        Raises:
            UnknownName: It names a joint the character does not have.
            InvalidValue: The amount is still a range, or the performance cannot be so changed.
        """
        return self._varied(performance)

    def _varied(self, performance: Performance) -> Performance:
        raise NotImplementedError

    def drawn(self: Own, rng: np.random.Generator) -> Own:
        """The same with every range replaced by one value of it; evenly in ratio where positive."""
        picked = {
            name: _picked(value, rng) for name, value in self._amounts() if isinstance(value, tuple)
        }
        return replace(self, **picked) if picked else self

    @property
    def ranged(self) -> bool:
        """Whether an amount is still a range."""
        return any(isinstance(value, tuple) for _, value in self._amounts())

    def as_dict(self) -> dict[str, Any]:
        """Its kind and what differs from the defaults, as plain values."""
        given = {
            field.name: getattr(self, field.name)
            for field in fields(self)
            if getattr(self, field.name) != field.default
        }
        plain = {k: list(v) if isinstance(v, tuple) else v for k, v in given.items()}
        return {"kind": type(self).__name__.lower(), **plain}

    def _amounts(self) -> Iterator[tuple[str, Amount]]:
        for name in ("by", "to", "share"):
            value = getattr(self, name, None)
            if value is not None:
                yield name, value

    def _check_amounts(self, low: float, high: float, unit: str = "") -> None:
        """Refuse amounts outside `low` to `high` and ranges that are none."""
        what = type(self).__name__
        for name, value in self._amounts():
            pair = value if isinstance(value, tuple) else (value, value)
            if len(pair) != 2 or not all(np.isfinite(pair)):
                raise InvalidValue(f"{what}: {name} is {value}; give a number, or a pair of them.")
            if pair[0] > pair[1]:
                raise InvalidValue(f"{what}: the range {name}={value} is empty; give (low, high).")
            if not (low <= pair[0] and pair[1] <= high):
                raise InvalidValue(
                    f"{what}: {name} is {value}{unit}; it must lie in {low:g} to {high:g}{unit}."
                )

    def _number(self, name: str) -> float:
        """An amount that must have been drawn."""
        value = getattr(self, name)
        if isinstance(value, tuple):
            raise InvalidValue(
                f"{type(self).__name__}: {name} is the range {value}; draw from it first."
            )
        return float(value)


@dataclass(frozen=True, kw_only=True, init=False)
class Together(Variation):
    """Several variations, applied in order.

    Attributes:
        parts: The variations.
        name: What to call them together.
    """

    parts: tuple[Variation, ...] = ()
    name: str = ""

    def __init__(self, *parts: Variation, name: str = "") -> None:
        object.__setattr__(self, "parts", tuple(parts))
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "character", 0)

    def _varied(self, performance: Performance) -> Performance:
        for part in self.parts:
            performance = part(performance)
        return performance

    def __str__(self) -> str:
        return "; ".join(str(part) for part in self.parts) or "unvaried"

    def drawn(self, rng: np.random.Generator) -> Together:
        """Every part drawn, in order."""
        return Together(*(part.drawn(rng) for part in self.parts), name=self.name)

    @property
    def ranged(self) -> bool:
        """Whether a part is still a range."""
        return any(part.ranged for part in self.parts)

    def as_dict(self) -> dict[str, Any]:
        """The parts as plain values."""
        return {"kind": "together", "name": self.name, "parts": [p.as_dict() for p in self.parts]}


def _picked(pair: tuple[float, float], rng: np.random.Generator) -> float:
    low, high = pair
    if low > 0:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))
    return float(rng.uniform(low, high))


def tracking_of(performance: Performance, character: int) -> Tracking:
    """The controller that makes a character follow a clip.

    Raises:
        InvalidValue: No such character, or none that tracks.
    """
    body_of(performance, character)
    for controller in performance.controllers:
        if isinstance(controller, Tracking) and controller.character == character:
            return controller
    raise InvalidValue("Only a performance that tracks a clip can be varied so; see `tracked`.")


def body_of(performance: Performance, character: int) -> Character:
    """One of the scene's characters; raises `InvalidValue`."""
    characters = performance.scene.characters
    if not 0 <= character < len(characters):
        raise InvalidValue(
            f"No character {character}; the scene has {len(characters)}, counted from 0."
        )
    body = characters[character]
    if isinstance(body, Linkage):
        raise InvalidValue(f"{body.name!r} is a linkage without a drive; see `driven`.")
    return body


def rehearsed(performance: Performance, tracking: Tracking) -> Tracking:
    """The same tracking with its gains and feedforward bound to the body and clip as they are."""
    if tracking.rehearsal is not None:
        return tracking
    rehearsal = Rehearsal(scene=performance.scene, reference=tracking.reference)
    return replace(tracking, rehearsal=rehearsal)


def exchanged(
    performance: Performance,
    old: Tracking,
    new: Tracking,
    *,
    scene: Scene | None = None,
) -> Performance:
    """The performance with one controller, and perhaps its scene, replaced."""
    controllers = tuple(new if c is old else c for c in performance.controllers)
    same_length = new.reference.duration == old.reference.duration
    return replace(
        performance,
        scene=scene or performance.scene,
        controllers=controllers,
        duration=performance.duration if same_length else new.reference.duration,
    )
