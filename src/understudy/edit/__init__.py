"""A performance described in one readable file: clips, bodies, props, tasks, pushes.

In: an edit file (TOML; docs/edit_file.md). Out: the `Performance` it describes. Every mistake in
the file is an `EditError` that names the line.
"""

from understudy.edit.edit import Edit, read_edit
from understudy.edit.source import EditError

__all__ = ["Edit", "EditError", "read_edit"]
