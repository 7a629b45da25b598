"""Full-body trackers side by side: published figures, and this package's own on a folder of clips.

In: takes of clips tracked without a hand from above. Out: one `Run` each, summaries by group, and a
page with the table, the published figures beside it and players of the worst.
"""

from understudy.papers.trackers.page import page_html
from understudy.papers.trackers.published import DIFFERENT, TRACKERS, Tracker
from understudy.papers.trackers.replays import replays
from understudy.papers.trackers.runs import Run, run_of, summaries, table

__all__ = [
    "DIFFERENT",
    "TRACKERS",
    "Run",
    "Tracker",
    "page_html",
    "replays",
    "run_of",
    "summaries",
    "table",
]
