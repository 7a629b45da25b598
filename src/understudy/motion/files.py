"""Writing files so that a half-written one never carries the final name."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from understudy.errors import UnderstudyError

_SYSTEM = ("/dev", "/proc", "/sys")


@contextmanager
def written(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path beside `path`; rename it to `path` when the block succeeds.

    The temporary file keeps the suffix, so libraries that look at it still work. Missing parent
    folders are made. A symbolic link stays one: the file it leads to is written.

    Raises:
        UnderstudyError: The folder or file cannot be written; the text says why.
    """
    final = Path(path)
    temporary: Path | None = None
    try:
        target = writable(final)
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            prefix=f".{target.stem[:40]}-", suffix=final.suffix, dir=target.parent
        )
        os.close(handle)
        temporary = Path(name)
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(target)
    except (OSError, ValueError) as error:
        if isinstance(error, UnderstudyError):  # an InvalidValue is a ValueError too
            raise
        if isinstance(error, ValueError) and temporary is not None:
            raise  # not about the path
        reason = getattr(error, "strerror", None) or error
        raise UnderstudyError(f"{final}: cannot be written: {reason}.") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def writable(path: str | os.PathLike[str]) -> Path:
    """Where a file called `path` would be written: itself, or what a symbolic link leads to.

    Raises:
        UnderstudyError: There is a folder, a device or a pipe of that name, or it lies among the
            system's own files (/dev, /proc, /sys).
        OSError: A loop of links, or a folder on the way that may not be entered.
    """
    final = Path(path)
    target = Path(os.path.realpath(final)) if final.is_symlink() else final
    try:
        mode = target.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        mode = stat.S_IFREG
    if stat.S_ISDIR(mode):
        raise UnderstudyError(f"{final}: is a folder; give the name of a file.")
    if not stat.S_ISREG(mode):
        raise UnderstudyError(f"{final}: is a device or a pipe; give the name of a file.")
    place = Path(os.path.realpath(target.parent))
    memory = place.is_relative_to("/dev/shm")  # a disk in memory, for anybody's files
    if any(place.is_relative_to(system) for system in _SYSTEM) and not memory:
        raise UnderstudyError(f"{final}: lies among the system's own files; choose another.")
    return target


def same_file(one: str | os.PathLike[str], other: str | os.PathLike[str]) -> bool:
    """Whether two paths lead to the same file, also by links; of files that are not there yet,
    whether they would."""
    try:
        return Path(one).samefile(other)
    except (OSError, ValueError):
        pass
    try:
        return os.path.realpath(one) == os.path.realpath(other)
    except (OSError, ValueError):
        return False
