"""Writing files so that a half-written one never carries the final name."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from understudy.errors import UnderstudyError


@contextmanager
def written(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path beside `path`; rename it to `path` when the block succeeds.

    The temporary file keeps the suffix, so libraries that look at it still work. Missing parent
    folders are made.

    Raises:
        UnderstudyError: The folder or file cannot be written; the text says why.
    """
    final = Path(path)
    temporary: Path | None = None
    try:
        final.parent.mkdir(parents=True, exist_ok=True)
        if final.is_dir():
            raise UnderstudyError(f"{final}: is a folder; give the name of a file.")
        handle, name = tempfile.mkstemp(
            prefix=f".{final.stem[:40]}-", suffix=final.suffix, dir=final.parent
        )
        os.close(handle)
        temporary = Path(name)
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(final)
    except OSError as error:
        raise UnderstudyError(f"{final}: cannot be written: {error.strerror or error}.") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
