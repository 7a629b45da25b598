"""What was measured of one figure of a paper, and how it is shown on a page."""

from __future__ import annotations

import html as markup
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Protocol

from understudy.papers.filmstrip import Film, films_html
from understudy.papers.sheets import Sheet, as_html


class Drawn(Protocol):
    """A chart or another figure that becomes HTML."""

    def html(self) -> str:
        """The figure."""
        ...


@dataclass(frozen=True, kw_only=True)
class Claim:
    """Something the paper says, and what was found.

    Attributes:
        said: By the paper, in words of ours.
        measured: In one line, with numbers.
        holds: Whether the numbers bear it out.
    """

    said: str
    measured: str
    holds: bool


@dataclass(frozen=True, kw_only=True)
class Strip:
    """Rows of pictures that belong together.

    Attributes:
        alt: What is seen, in words.
        films: The rows.
        scale: See `films_html`.
    """

    alt: str
    films: tuple[Film, ...] = field(repr=False)
    scale: str = "own"


@dataclass(frozen=True, kw_only=True, eq=False)
class Finding:
    """One figure, or a part of one, run again.

    Attributes:
        figure: "4", "8, staff", or of statements without a figure what they are about: "speeds".
        title: Short.
        setting: How it was made: clip, body, gains; a sentence or two.
        claims: What the paper says, each with what was found.
        charts: The figure's curves.
        strips: Pictures.
        sheets: All numbers.
        facts: Plain numbers worth keeping.
    """

    figure: str
    title: str
    setting: str
    claims: tuple[Claim, ...]
    charts: tuple[Drawn, ...] = ()
    strips: tuple[Strip, ...] = field(default=(), repr=False)
    sheets: tuple[Sheet, ...] = ()
    facts: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """With its word: "Figure 4", "Figures 1 and 7"; "Text" for statements without a figure."""
        if not any(letter.isdigit() for letter in self.figure):
            return f"Text, {self.figure}"
        return f"{'Figures' if ' and ' in self.figure else 'Figure'} {self.figure}"


def finding_dict(finding: Finding) -> dict[str, Any]:
    """Its numbers as plain values."""
    return {
        "figure": finding.figure,
        "title": finding.title,
        "setting": finding.setting,
        "claims": [asdict(claim) for claim in finding.claims],
        "facts": finding.facts,
        "tables": [asdict(sheet) for sheet in finding.sheets],
    }


def held_of(findings: Sequence[Finding]) -> tuple[int, int]:
    """How many of the claims hold, and how many there are."""
    claims = [claim for finding in findings for claim in finding.claims]
    return sum(claim.holds for claim in claims), len(claims)


def told_of(findings: Sequence[Finding]) -> list[str]:
    """Every finding's claims as text for a terminal."""
    parts = []
    for finding in findings:
        if finding.claims:
            lines = [f"{finding.name}. {finding.title}"]
            for claim in finding.claims:
                lines.append(f"  {'yes' if claim.holds else 'NO '}  {claim.said}")
                lines.append(f"       {claim.measured}")
            parts.append("\n".join(lines))
    held, count = held_of(findings)
    return [*parts, f"{held} of {count} statements hold."]


def _text(value: object) -> str:
    return markup.escape(str(value))


def _anchor(finding: Finding) -> str:
    return "figure-" + finding.figure.replace(", ", "-").replace(" ", "-")


def summary_html(finding: Finding) -> str:
    """A finding as an item of the list at the head of a page; its link leads to the section."""
    good = all(claim.holds for claim in finding.claims)
    kept = sum(claim.holds for claim in finding.claims)
    return (
        f'<li class="{"yes" if good else "no"}"><a href="#{_anchor(finding)}">'
        f"{_text(finding.name)}: {_text(finding.title)}</a> "
        f"<span>{kept} of {len(finding.claims)} hold</span></li>"
    )


def _claims(claims: tuple[Claim, ...]) -> str:
    items = "".join(
        f'<li class="{"yes" if claim.holds else "no"}"><b>{_text(claim.said)}</b> '
        f"<span>{_text(claim.measured)}</span></li>"
        for claim in claims
    )
    return f'<ul class="claims">{items}</ul>' if items else ""


def section_html(finding: Finding, *, shows: str = "", sharp: bool = True) -> str:
    """A finding as a section of a page.

    Args:
        finding: What was found.
        shows: What the paper's figure shows, in words of ours; nothing where it is said elsewhere.
        sharp: Large pictures of every moment; otherwise small ones of every third.
    """
    width, height = (240, 300) if sharp else (80, 100)
    parts = [
        f'<section id="{_anchor(finding)}"><h2>{_text(finding.name)}: {_text(finding.title)}</h2>',
        f"<p>{_text(shows)}</p>" if shows else "",
        _claims(finding.claims),
        *(
            films_html(_films(s, sharp), alt=s.alt, scale=s.scale, width=width, height=height)
            for s in finding.strips
        ),
        *(chart.html() for chart in finding.charts),
        _numbers(finding),
        f'<p class="note">{_text(finding.setting)}</p></section>',
    ]
    return "\n".join(filter(None, parts))


def _films(strip: Strip, sharp: bool) -> list[Film]:
    """The rows; of a quick run every third moment."""
    return [replace(f, times=f.times[:: 1 if sharp else 3]) for f in strip.films]


def _numbers(finding: Finding) -> str:
    """All tables, folded away."""
    if not finding.sheets:
        return ""
    tables = "".join(as_html(sheet) for sheet in finding.sheets)
    return f"<details><summary>All numbers</summary>{tables}</details>"


STYLE = """
.claims{list-style:none;padding:0;margin:.5rem 0 1.25rem}
.claims li{position:relative;padding:.15rem 0 .15rem 1.6rem;max-width:80ch}
.claims li::before{position:absolute;left:.1rem;font-weight:700}
.claims .yes::before{content:"\\2713";color:var(--good)}
.claims .no::before{content:"\\2717";color:var(--held)}
.claims b{font-weight:600}.claims span{display:block;color:var(--dim);font-size:.9375rem}
.claims a{color:var(--c0)}ol.claims span{display:inline}
details{margin:0 0 1rem}summary{cursor:pointer;font-weight:600;font-size:.875rem}
details .wide .words{white-space:nowrap}
"""
