"""Video files: every frame drawn and piped to ffmpeg, or gathered into a GIF."""

from __future__ import annotations

import collections
import itertools
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.errors import InvalidValue, UnderstudyError, require
from understudy.motion.clip import Clip
from understudy.motion.files import written
from understudy.output.gl import GLRenderer
from understudy.output.pictures import arranged, checked_size, drawn
from understudy.output.playback import Playback, playback
from understudy.output.renderer import opened

if TYPE_CHECKING:
    from understudy.take import Take

_MAX_THREADS = 8


@dataclass(frozen=True, kw_only=True)
class Video:
    """What was written.

    Attributes:
        frames: Number of frames.
        rate: Frames per second [Hz].
        renderer: "opengl" or "software".
        encoder: The program that compressed the frames: a path of ffmpeg, or "pillow".
    """

    frames: int
    rate: float
    renderer: str
    encoder: str


def video(
    thing: Take | Clip,
    path: str | PathLike[str],
    *,
    fps: float = 30.0,
    view: str = "follow",
    ghost: str = "beside",
    width: int = 960,
    height: int = 540,
    renderer: str = "auto",
) -> Video:
    """Draw a whole motion in real time.

    Args:
        thing: A take, or a clip (drawn as rods).
        path: The file: .mp4 (H.264, by ffmpeg) or .gif (by Pillow).
        fps: Frames per second [Hz].
        view: See `pictures.still`.
        ghost: The reference "over" the simulated body, "beside" it, or "none".
        width: Width [pixels]; made even for .mp4.
        height: Height [pixels]; made even for .mp4.
        renderer: "auto" (OpenGL where it works), "opengl" or "software".

    Raises:
        InvalidValue: Another extension, a rate outside 1 to 240 Hz, or a size that is no picture.
        UnknownName: No such view, ghost or renderer.
        MissingExtra: Neither ffmpeg nor the package that brings it is there; or no Pillow.
        UnderstudyError: The encoder fails; the text has its last words.
    """
    kind = Path(path).suffix.lower()
    if kind not in (".mp4", ".gif"):
        raise InvalidValue(f"{path}: a video is an .mp4 or a .gif file, not {kind or 'this'!r}.")
    if not 1.0 <= fps <= 240.0:
        raise InvalidValue(f"fps is {fps}; it must lie between 1 and 240.")
    checked_size(width, height)
    if kind == ".mp4":
        width, height = width - width % 2, height - height % 2
        encoder = ffmpeg()
    else:
        require("PIL", extra="video")
        encoder = "pillow"
    shown = arranged(at_even_times(thing, fps), ghost, view)
    with ExitStack() as stack:
        name, frames = _frames(shown, view, ghost, (width, height), renderer, stack)
        frames = _with_progress(frames, shown.frames, Path(path).name)
        temporary = stack.enter_context(written(path))
        if kind == ".mp4":
            _encode(encoder, frames, temporary, fps, width, height)
        else:
            _gather(frames, temporary, fps)
    return Video(frames=shown.frames, rate=fps, renderer=name, encoder=encoder)


def at_even_times(thing: Take | Clip, fps: float) -> Playback:
    """A playback whose frames lie 1 / fps [s] apart: of every time, the nearest state there is.

    A take has a state every few milliseconds, so the nearest is near; a clip slower than the video
    shows frames twice rather than poses nobody recorded.
    """
    full = playback(thing, rate=thing.rate)
    count = int(np.floor((full.times[-1] - full.times[0]) * fps + 1e-6)) + 1
    chosen = np.round(np.arange(count) / fps * full.rate).astype(int)
    return full.chosen(np.minimum(chosen, full.frames - 1), rate=fps)


def ffmpeg() -> str:
    """The ffmpeg program: the system's, else the one that imageio-ffmpeg brings.

    Raises:
        MissingExtra: There is neither.
    """
    found = shutil.which("ffmpeg")
    return found or require("imageio_ffmpeg", extra="video").get_ffmpeg_exe()


def _frames(
    shown: Playback,
    view: str,
    ghost: str,
    size: tuple[int, int],
    renderer: str,
    stack: ExitStack,
) -> tuple[str, Iterator[np.ndarray[Any, np.dtype[np.uint8]]]]:
    """The renderer's name and the pictures in order, drawn on every core without OpenGL."""
    width, height = size
    shot = shown.shot(view, width / height)

    def another() -> Any:
        drawing = opened(
            shown.model,
            width,
            height,
            renderer=renderer,
            spec=shown.spec,
            samples=0,
            ghost_bodies=shown.ghost_bodies,
        )
        stack.callback(drawing.close)
        return drawing

    first = another()
    if isinstance(first, GLRenderer):  # a context belongs to the thread that made it
        return first.name, (drawn(first, shown, shot, k, ghost) for k in range(shown.frames))
    threads = max(1, min(os.cpu_count() or 1, _MAX_THREADS, shown.frames))
    free = collections.deque([first, *(another() for _ in range(threads - 1))])
    pool = stack.enter_context(ThreadPoolExecutor(threads))

    def one(frame: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
        drawing = free.pop()
        try:
            return drawn(drawing, shown, shot, frame, ghost)
        finally:
            free.append(drawing)

    return first.name, _in_order(pool, one, shown.frames, 2 * threads)


def _in_order(
    pool: ThreadPoolExecutor, one: Callable[[int], Any], count: int, ahead: int
) -> Iterator[Any]:
    """Results of `one(0)`, `one(1)`, ... in order, with a few being computed ahead."""
    waiting: collections.deque[Future[Any]] = collections.deque()
    numbers = iter(range(count))
    for k in itertools.islice(numbers, ahead):
        waiting.append(pool.submit(one, k))
    try:
        while waiting:
            result = waiting.popleft().result()
            for k in itertools.islice(numbers, 1):
                waiting.append(pool.submit(one, k))
            yield result
    finally:
        for future in waiting:
            future.cancel()


def _with_progress(frames: Iterator[Any], count: int, name: str) -> Iterator[Any]:
    """The same frames, with a progress bar on a terminal once it takes more than two seconds."""
    from tqdm import tqdm

    return iter(
        tqdm(
            frames,
            total=count,
            desc=name,
            unit="frame",
            delay=2.0,
            mininterval=0.5,
            leave=False,
            disable=None,
        )
    )


def _encode(
    program: str, frames: Iterator[np.ndarray], path: Path, fps: float, width: int, height: int
) -> None:
    """Pipe frames into ffmpeg; H.264 that every player reads."""
    command = [program, "-hide_banner", "-loglevel", "error", "-nostdin", "-y"]
    command += ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps:g}"]
    command += ["-i", "pipe:0", "-an", "-c:v", "libx264", "-preset", "veryfast", "-crf", "19"]
    command += ["-pix_fmt", "yuv420p", "-movflags", "+faststart", str(path)]
    with tempfile.TemporaryFile() as words:
        try:
            process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=words
            )
        except OSError as error:
            raise UnderstudyError(f"{program} cannot be started: {error.strerror}.") from error
        assert process.stdin is not None
        try:
            for frame in frames:
                process.stdin.write(np.ascontiguousarray(frame).tobytes())
        except BrokenPipeError:
            pass  # ffmpeg gave up; what it said is read below
        except BaseException:
            process.kill()
            process.wait()
            raise
        finally:
            with suppress(BrokenPipeError):
                process.stdin.close()
        if process.wait() != 0:
            words.seek(0)
            said = words.read()[-400:].decode("utf-8", "replace").strip().replace("\n", " ")
            raise UnderstudyError(f"ffmpeg failed: {said or 'it gave no reason'}.")


def _gather(frames: Iterator[np.ndarray], path: Path, fps: float) -> None:
    """Write a GIF; frame times are rounded to its hundredths so that the sum stays right."""
    from PIL import Image

    images, palette = [], None
    for frame in frames:
        image = Image.fromarray(np.ascontiguousarray(frame))
        if palette is None:  # one palette for all, so that the ground does not flicker
            palette = image.quantize(255, method=Image.Quantize.MEDIANCUT)
        images.append(image.quantize(palette=palette, dither=Image.Dither.NONE))
    ends = np.round(np.arange(len(images) + 1) * 100.0 / fps)
    durations = [int(10 * d) for d in np.maximum(np.diff(ends), 2)]
    images[0].save(
        path,
        save_all=True,
        append_images=images[1:],
        duration=durations,
        loop=0,
        optimize=False,
        disposal=1,
    )
