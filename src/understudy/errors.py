"""What can go wrong, said in one line: what was wrong, the value, what would be right."""

from __future__ import annotations

import difflib
import importlib
from collections.abc import Iterable
from os import PathLike
from typing import Any

_LISTED = 40  # names in a message
_PART = 3  # letters at least that are part of a name


class UnderstudyError(Exception):
    """Base of every error this package raises on purpose; its text is one line for a person."""


class ClipError(UnderstudyError):
    """A motion file that cannot be read: names the file, the line where known, and the remedy."""

    def __init__(self, path: str | PathLike[str], problem: str, line: int | None = None):
        self.path = str(path)
        self.line = line
        self.problem = problem
        where = self.path if line is None else f"{self.path}:{line}"
        super().__init__(f"{where}: {problem}")


class InvalidValue(UnderstudyError, ValueError):
    """An argument outside what is allowed; the text gives the value and the allowed range."""


class UnknownName(UnderstudyError, LookupError):
    """A name that does not exist, with the nearest one that does."""

    def __init__(self, kind: str, name: str, valid: Iterable[str]):
        self.name = name
        self.valid = tuple(valid)
        # A part of a name, such as "man" of "adult_man", says more than likeness does.
        whole = [one for one in self.valid if len(name) >= _PART and name in one]
        near = difflib.get_close_matches(name, whole or self.valid, n=1, cutoff=0 if whole else 0.5)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        listed = ", ".join(self.valid[:_LISTED]) or "none"
        if len(self.valid) > _LISTED:
            listed += f", ... and {len(self.valid) - _LISTED} more"
        super().__init__(f"No {kind} named {name!r}.{hint} Valid: {listed}.")


def expect(value: object, kind: type | tuple[type, ...], name: str, what: str) -> None:
    """Refuse an argument of another type, in one sentence, at the doors people come in by.

    Raises:
        InvalidValue: Names the argument, its value and what it must be.
    """
    if not isinstance(value, kind):
        raise InvalidValue(f"{name} is {shown(value)}; it must be {what}.")


def shown(value: object) -> str:
    """A value in at most 60 characters on one line."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:50]} ... (a {type(value).__name__})"


class MissingExtra(UnderstudyError, ImportError):
    """An optional package is not installed; the text names the extra that brings it."""

    def __init__(self, module: str, extra: str):
        super().__init__(
            f"This needs the package {module!r}, which is not installed. "
            f"Install it with: pip install 'understudy[{extra}]'"
        )


class Diverged(UnderstudyError):
    """A simulation that blew up.

    Attributes:
        time: Simulated time of the first warning [s].
        where: The link or joint whose state went bad.
        take: The take up to that moment, or None when not a single frame was good.
    """

    def __init__(self, time: float, where: str, take: Any = None):
        self.time = time
        self.where = where
        self.take = take
        super().__init__(
            f"The simulation diverged at {time:.3f} s in {where!r}"
            f"{'' if take is None else '; the take up to then is kept'}. "
            "Lower the stiffness or the time step, or repair the clip there."
        )


class NotFound(UnderstudyError):
    """A search that was done as asked and found nothing worth keeping."""


class ControllerFailed(UnderstudyError):
    """A controller written in Python raised an exception, which is the cause of this one.

    Attributes:
        time: Simulated time [s].
        take: The take up to that moment.
    """

    def __init__(self, time: float, error: BaseException | None, take: Any = None):
        self.time = time
        self.take = take
        super().__init__(
            f"A controller raised {type(error).__name__} at {time:.3f} s ({error}); "
            "the take up to then is kept."
        )


def require(module: str, *, extra: str) -> Any:
    """Import an optional module, or raise `MissingExtra` naming the extra that installs it."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.split(".")[0] != module.split(".")[0]:
            raise
        raise MissingExtra(module, extra) from error
