"""The HIERARCHY section of a BVH file: its grammar, and what is wrong with a broken one."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field

from understudy.errors import ClipError
from understudy.motion.source import MAX_JOINTS, quoted
from understudy.motion.values import LARGEST

_CHANNEL = re.compile(r"([xyz])(position|rotation)", re.IGNORECASE)
_WORD = re.compile(r"[{}]|[^\s{}]+")
_NAME_END = re.compile(r"[{}\r\n]")


@dataclass
class Joint:
    """A joint as the hierarchy declares it."""

    name: str
    parent: int
    offset: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    channels: str | None = None


@dataclass
class Hierarchy:
    """Joints in file order and the end sites (joint, offset)."""

    joints: list[Joint] = field(default_factory=list)
    ends: list[tuple[int, list[float]]] = field(default_factory=list)

    @property
    def channels(self) -> int:
        """Number of values in a frame."""
        return sum(len(joint.channels or "") for joint in self.joints)


class Scanner:
    """Walks through the words of a hierarchy."""

    def __init__(self, text: str, path: str | os.PathLike[str]):
        self.text = text
        self.path = path
        self.at = 0  # where the next word is looked for
        self.start = 0  # where the last word began

    def error(self, problem: str, at: int | None = None) -> ClipError:
        """An error at the line of the last word, or at a place in the text."""
        before = self.text[: self.start if at is None else at]
        line = max(before.count("\n"), before.count("\r")) + 1
        return ClipError(self.path, problem, line)

    def word(self) -> str:
        """The next word or brace; empty at the end."""
        match = _WORD.search(self.text, self.at)
        if match is None:
            self.start = self.at = len(self.text)
            return ""
        self.start, self.at = match.span()
        return match.group()

    def name(self, keyword: str) -> str:
        """The rest of the line up to a brace: names may hold blanks."""
        stop = _NAME_END.search(self.text, self.at)
        end = len(self.text) if stop is None else stop.start()
        name = " ".join(self.text[self.at : end].split())
        self.at = end
        if not name:
            name = self.word()
        if not name or name in "{}":
            raise self.error(f"{keyword} without a name; write {keyword} and a name.")
        return name

    def number(self, what: str) -> float:
        """The next word as a number."""
        word = self.word()
        try:
            value = float(word)
        except ValueError:
            raise self.error(
                f"{what} has {quoted(word) if word else 'nothing'} where a number belongs."
            ) from None
        if not abs(value) <= LARGEST:
            raise self.error(f"{what} has the value {quoted(word)}; it must be below {LARGEST:g}.")
        return value

    def triple(self, what: str) -> list[float]:
        """Three numbers."""
        return [self.number(what) for _ in range(3)]

    def channels(self, joint: str) -> str:
        """A list of channels as one letter each: "xyz" for positions, "XYZ" for rotations."""
        count = self.number(f"CHANNELS of {quoted(joint)}")
        if count not in range(7):
            raise self.error(f"CHANNELS of {quoted(joint)} says {count:g}; a joint has 0 to 6.")
        letters = ""
        for _ in range(int(count)):
            word = self.word()
            match = _CHANNEL.fullmatch(word)
            if match is None:
                raise self.error(
                    f"channel {quoted(word)} of {quoted(joint)} is unknown; channels are Xposition "
                    f"to Zrotation, and CHANNELS says there are {count:g}."
                )
            axis, kind = match.groups()
            letters += axis.lower() if kind[0] in "pP" else axis.upper()
        if len(set(letters)) < len(letters) and any(letters.count(c) > 1 for c in "xyz"):
            raise self.error(f"CHANNELS of {quoted(joint)} lists a position twice.")
        if sum(c.isupper() for c in letters) > 3:
            raise self.error(f"CHANNELS of {quoted(joint)} lists more than three rotations.")
        return letters

    def hierarchy(self) -> Hierarchy:
        """The whole tree, without recursion: nesting may be as deep as the joint limit."""
        out = Hierarchy()
        opened: list[tuple[int, int]] = []  # joint and where it was opened; end sites repeat it
        while word := self.word():
            key = word.upper()
            if key == "HIERARCHY" and not out.joints:
                continue
            if key == "}":
                if not opened:
                    raise self.error("a closing brace too many; every } needs its {.")
                opened.pop()
            elif key in ("ROOT", "JOINT"):
                self._joint(out, opened, key)
            elif key == "END":
                self._end_site(out, opened)
            elif key == "OFFSET" and opened:
                out.joints[opened[-1][0]].offset = self.triple("OFFSET")
            elif key == "CHANNELS" and opened:
                joint = out.joints[opened[-1][0]]
                if joint.channels is not None:
                    raise self.error(f"joint {quoted(joint.name)} has CHANNELS twice.")
                joint.channels = self.channels(joint.name)
            else:
                raise self.error(
                    f"{quoted(word)} is not expected here; a BVH file is HIERARCHY, one ROOT with "
                    "its joints in braces, then MOTION."
                )
        if opened:
            joint, place = opened[-1]
            raise self.error(
                f"the brace of {quoted(out.joints[joint].name)} is never closed; add a }} for each "
                f"of {len(opened)} open joints.",
                place,
            )
        if not out.joints:
            raise self.error("has no ROOT; a BVH file starts with HIERARCHY and ROOT.")
        return out

    def _joint(self, out: Hierarchy, opened: list[tuple[int, int]], key: str) -> None:
        place = self.start
        if key == "ROOT" and out.joints:
            raise self.error(
                "a second ROOT; one file holds one skeleton, so save each in its own file."
            )
        if key == "JOINT" and not opened:
            raise self.error("JOINT outside of a ROOT; braces are out of balance above.")
        if len(out.joints) >= MAX_JOINTS:
            raise self.error(f"has more than {MAX_JOINTS} joints; export only the body's.")
        name = self.name(key)
        if self.word() != "{":
            raise self.error(f"no {{ after {key} {quoted(name)}.")
        out.joints.append(Joint(name, opened[-1][0] if opened else -1))
        opened.append((len(out.joints) - 1, place))

    def _end_site(self, out: Hierarchy, opened: list[tuple[int, int]]) -> None:
        if not opened:
            raise self.error("End Site outside of a joint; braces are out of balance above.")
        if len(out.ends) >= MAX_JOINTS:
            raise self.error(f"has more than {MAX_JOINTS} end sites; export only the body's.")
        place = self.start
        self.name("End Site")
        brace = self.word()
        keyword = self.word().upper() if brace == "{" else brace
        offset = self.triple("OFFSET") if keyword == "OFFSET" else [0.0, 0.0, 0.0]
        if keyword == "OFFSET":
            keyword = self.word()
        if brace != "{" or keyword != "}":
            raise self.error("End Site needs { OFFSET x y z }.", place)
        out.ends.append((opened[-1][0], offset))
