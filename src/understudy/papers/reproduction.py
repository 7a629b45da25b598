"""A paper run again: its findings one after another, a page of them, and the files."""

from __future__ import annotations

import html as markup
import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Protocol

from tqdm import tqdm

from understudy import __version__
from understudy.motion.files import written
from understudy.papers.finding import Finding, finding_dict, held_of, section_html, summary_html
from understudy.papers.sheets import Sheet, as_csv, plain

Makers = Sequence[tuple[int, Callable[[], Iterable[Finding]]]]
"""What makes findings, each with about how long it takes."""


class Printed(Protocol):
    """A figure of a paper."""

    @property
    def number(self) -> int:
        """As printed."""
        ...

    @property
    def shows(self) -> str:
        """What can be seen in it, in words of ours."""
        ...


def findings_of(makers: Makers, *, progress: bool = False) -> list[Finding]:
    """The findings, made in turn; with a progress bar on standard error if asked."""
    findings: list[Finding] = []
    with tqdm(
        total=sum(cost for cost, _ in makers),
        desc="figures",
        bar_format="{desc} {percentage:3.0f} %|{bar}| {elapsed}",
        delay=1.0,
        disable=None if progress else True,
        leave=False,
    ) as bar:
        for cost, make in makers:
            findings += make()
            bar.update(cost)
    return findings


def body_html(
    findings: Sequence[Finding],
    *,
    title: str,
    about: Sequence[str],
    not_comparable: Sequence[str],
    printed: Sequence[Printed],
    sharp: bool = True,
) -> str:
    """A page's body.

    Args:
        findings: In their order.
        title: Of the page.
        about: Lines of HTML below it: the paper, what was run, with what.
        not_comparable: Reasons, one for each statement that could not be held against anything.
        printed: The paper's figures.
        sharp: Large pictures; see `section_html`.
    """
    held, count = held_of(findings)
    lines = [
        f"<h1>{markup.escape(title)}</h1>",
        *about,
        f"<p><b>{held} of {count}</b> statements hold.</p>",
        '<ol class="claims">',
        *(summary_html(finding) for finding in findings if finding.claims),
        "</ol>",
        "<h2>What cannot be compared, and why</h2><ul>",
        *(f"<li>{markup.escape(reason)}</li>" for reason in not_comparable),
        "</ul>",
        *(
            section_html(finding, shows=_shows(finding, printed), sharp=sharp)
            for finding in findings
        ),
        f'<p class="kicker">Made by understudy {__version__}.</p>',
    ]
    return "\n".join(lines)


def _shows(finding: Finding, printed: Sequence[Printed]) -> str:
    """What the paper's figures show; nothing of a part of one, where it is said with the whole."""
    if "," in finding.figure:
        return ""
    numbers = {int(word) for word in finding.figure.split() if word.isdigit()}
    texts = [f"Figure {f.number}: {f.shows}" for f in printed if f.number in numbers]
    return f"The paper's {' '.join(texts)}" if texts else ""


def numbers_of(findings: Sequence[Finding], not_comparable: Sequence[str]) -> dict[str, Any]:
    """The findings as plain values, with how many statements hold."""
    held, count = held_of(findings)
    return {
        "not_comparable": list(not_comparable),
        "statements": count,
        "statements_that_hold": held,
        "figures": [finding_dict(finding) for finding in findings],
        "version": __version__,
    }


def write_files(
    folder: Path, name: str, *, page: str, numbers: dict[str, Any], sheets: Iterable[Sheet]
) -> None:
    """Write NAME.html, NAME.json and one NAME_SHEET.csv per table.

    Raises:
        UnderstudyError: A file cannot be written.
    """
    told = json.dumps(plain(numbers), indent=2, allow_nan=False, ensure_ascii=False)
    texts = {f"{name}.html": page, f"{name}.json": told + "\n"}
    for sheet in sheets:
        texts[f"{name}_{sheet.name.lower().replace(' ', '_')}.csv"] = as_csv(sheet)
    for file, text in texts.items():
        with written(folder / file) as temporary:
            temporary.write_text(text, encoding="utf-8")
