"""Real clips by name, downloaded once from public mirrors and checked.

Only addresses (at a pinned commit), sizes and checksums are kept here, never a clip. A name stands
for one exact file: anything else that arrives is refused.
"""

from __future__ import annotations

import hashlib
import http.client
import os
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
from dataclasses import dataclass
from pathlib import Path

from understudy.errors import InvalidValue, UnderstudyError, UnknownName, expect
from understudy.motion.files import written

CMU_TERMS = (
    "Carnegie Mellon University Graphics Lab Motion Capture Database: free for all uses; may be "
    "included in products, may not be resold directly, even in converted form. Acknowledge: "
    '"The data used in this project was obtained from mocap.cs.cmu.edu. The database was created '
    'with funding from NSF EIA-0196217."'
)
DRAWINGS_TERMS = "Example motion of the AnimatedDrawings repository, MIT License."

_BASE = "https://raw.githubusercontent.com"
_UTILITIES = (
    "franciscovalentecastro/Mocap-Data-Utilities/25b6ae2cbfe89949b40a3127b74aee6aa0905dfb"
    "/sample-mocap-data"
)
_BVH11 = "yuki-koyama/bvh11/c9072174fe89e0bf9776a092179b464ea39975e5/resources"
_DRAWINGS = (
    "facebookresearch/AnimatedDrawings/74ee7f0039adab0c6c6ebfcb2f9bac9c218e6747/examples/bvh"
)
# Silence of a server, and whole download [s].
_TIMEOUT, _DEADLINE = 20.0, 180.0


@dataclass(frozen=True, kw_only=True)
class Source:
    """Where one clip comes from.

    Attributes:
        paths: Paths below the mirror, tried in this order.
        size: Exact size of the file [bytes].
        sha256: Its checksum, hexadecimal.
        terms: What its owners ask for.
        motion: What it shows.
    """

    paths: tuple[str, ...]
    size: int
    sha256: str
    terms: str
    motion: str


def _cmu(number: str, size: int, sha256: str, motion: str) -> tuple[str, Source]:
    folders = (number.split("_")[0], "Walking")
    paths = tuple(f"{_UTILITIES}/{folder}/{number}.bvh" for folder in folders)
    return f"cmu/{number}", Source(
        paths=paths, size=size, sha256=sha256, terms=CMU_TERMS, motion=motion
    )


def _drawings(path: str, size: int, sha256: str, motion: str) -> tuple[str, Source]:
    name = path.split("/")[-1].removesuffix(".bvh")
    return f"drawings/{name}", Source(
        paths=(f"{_DRAWINGS}/{path}",),
        size=size,
        sha256=sha256,
        terms=f"{DRAWINGS_TERMS} {CMU_TERMS}" if path.startswith("cmu") else DRAWINGS_TERMS,
        motion=motion,
    )


_SOURCES: dict[str, Source] = dict(
    (
        _cmu(
            "02_01",
            259564,
            "b2558c5701c98f3382ae242860eebcecfce817fa53ca879bfea753a36390d2bc",
            "walk",
        ),
        _cmu(
            "02_03",
            134655,
            "8a67fae01bea08a7a75057ce806eafe3deb1b3d45d82ef7126fb7bea70d08ef0",
            "run",
        ),
        _cmu(
            "02_04",
            365800,
            "49d09ed98ad70fe9ece8aa42ea17437ee73094c86398476707036cd74683a17d",
            "jump and balance",
        ),
        _cmu(
            "02_05",
            1398391,
            "7a54afb840cce9ba4c5d7b339b2a71656d35a506b05be3a619ee5fbfaba10003",
            "punch and strike",
        ),
        _cmu(
            "05_02",
            854937,
            "bd70b2bd823fbe81d7006575e7f9a8d9811935f4042fc2812d01d3344c630694",
            "dance, pirouette",
        ),
        _cmu(
            "05_06",
            682543,
            "6b312a5bf78e09c619cc3af95ac3d9ef60f45f5a4bf6035078242b0c0835c5e5",
            "dance, jete",
        ),
        _cmu(
            "08_01",
            211678,
            "4e6cc1e0aa8b6b112be25b6aab5db8f176094181280b2c8ebcf903ede66e6e98",
            "walk",
        ),
        _cmu(
            "16_31",
            319740,
            "a655ee2e91ee516ccd91523f1537276e39e0b0abaa5cfc7f531c4f2f567d5088",
            "walk",
        ),
        _cmu(
            "29_01",
            988747,
            "3af47293ea5c9e1d57843032d68fc68a304f80d5f8e2673a8254c79fdfe6cbeb",
            "walk out and back",
        ),
        _cmu(
            "35_01",
            270282,
            "91d947f840845d00054dd331cb7e5c6a0195ee56406dc43273dbdc26467bc066",
            "walk",
        ),
        _cmu(
            "35_17",
            129702,
            "50c6469efea1edbba0f7acd46b1fa72e0b74b78e1698aa1b441990bd2a78d730",
            "run",
        ),
        _cmu(
            "49_02",
            1582670,
            "2ff266c9d8d7f9563e0b78fe788c41b91e561b0c41b256597a09e68831ae4431",
            "jumps and hops",
        ),
        _cmu(
            "49_06",
            371342,
            "254eff8b96df8ead7f6c6332c088e193e01c08543b9fb70d0ce16038088f18c3",
            "cartwheel",
        ),
        _cmu(
            "49_19",
            728441,
            "eb1691119212891a4c99e6e49c53e3aa4a425a26fdc13aa3ebac2ec574ad7f65",
            "balance on one leg",
        ),
        (
            "cmu/131_01",
            Source(
                paths=(f"{_BVH11}/131_01.bvh",),
                size=716137,
                sha256="525a261b085d44ea302205f7bbdf824c20ca8256b9e0797aeae43183326fce27",
                terms=CMU_TERMS,
                motion="start walking, stop",
            ),
        ),
        _drawings(
            "fair1/dab.bvh",
            224971,
            "99af1697a63b118fa2443c43e6fb533be7f162fdf78e4e7a2be693219da98fac",
            "dab",
        ),
        _drawings(
            "capture1/wave_hello.bvh",
            553769,
            "653598b83ba9d88b836e2cee3c6f53c933adf068bee664750c4c13d4fee4ffe7",
            "wave",
        ),
        _drawings(
            "cmu1/jumping_jacks.bvh",
            92928,
            "c230f4839660f26481b5b7d015770117d38b6dff018446d421cb842e9303c7c8",
            "jumping jacks",
        ),
        _drawings(
            "rokoko/jesse_dance.bvh",
            1465513,
            "37a18f9e59168b14b1567dc16b75b5092b75fe91ef1417e50b742c37fcef02c9",
            "dance, with fingers",
        ),
    )
)


def fetchable() -> tuple[str, ...]:
    """Names that `fetch` knows."""
    return tuple(_SOURCES)


def source(name: str) -> Source:
    """Where the clip `name` comes from, and its terms.

    Raises:
        UnknownName: No such clip; the text lists those there are.
    """
    expect(name, str, "name", "the name of a clip, as 'cmu/02_01'")
    try:
        return _SOURCES[name]
    except KeyError:
        raise UnknownName("clip to fetch", name, _SOURCES) from None


def terms(name: str) -> str:
    """What the owners of the clip ask for, to be shown to whoever fetches it."""
    return source(name).terms


def cache_folder() -> Path:
    """The user's folder for downloaded clips: XDG_CACHE_HOME or the platform's cache folder."""
    if os.environ.get("XDG_CACHE_HOME"):
        root = Path(os.environ["XDG_CACHE_HOME"])
    elif sys.platform == "win32":
        root = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        root = Path.home() / "Library" / "Caches"
    else:
        root = Path.home() / ".cache"
    return root / "understudy" / "clips"


def fetch(
    name: str, *, base: str | None = None, cache: str | os.PathLike[str] | None = None
) -> Path:
    """The path of a real clip's file, downloaded if it is not there yet.

    Args:
        name: For example "cmu/02_01"; `fetchable()` lists them, `terms(name)` says on what terms.
        base: Another mirror with the same paths, https (or http on this machine).
        cache: Folder for the file; `cache_folder()` by default.

    Raises:
        UnknownName: No such clip.
        InvalidValue: `base` is not https.
        UnderstudyError: No connection, not found, too large, cut short, or not the file meant; the
            text says which, and where to put the file by hand.
    """
    wanted = source(name)
    root = _checked_base(_BASE if base is None else base)
    folder = cache_folder() if cache is None else Path(cache)
    file = folder.joinpath(*f"{name}.bvh".split("/"))
    if file.is_file() and file.stat().st_size == wanted.size and _is(file.read_bytes(), wanted):
        return file
    body = _downloaded(name, wanted, root, file)
    with written(file) as temporary:
        temporary.write_bytes(body)
    return file


def _checked_base(base: str) -> str:
    parts = urllib.parse.urlsplit(base)
    local = parts.hostname in ("localhost", "127.0.0.1", "::1")
    if not parts.hostname or parts.scheme not in (("https", "http") if local else ("https",)):
        raise InvalidValue(f"base is {base!r}; it must begin with https:// and name a host.")
    return base.rstrip("/")


def _is(body: bytes, wanted: Source) -> bool:
    return hashlib.sha256(body).hexdigest() == wanted.sha256


def _downloaded(name: str, wanted: Source, root: str, file: Path) -> bytes:
    """The file's bytes, from the first of its paths that the mirror has."""
    by_hand = f"Or put the file yourself at {file}."
    problem = ""
    for path in wanted.paths:
        url = f"{root}/{path}"
        try:
            body = _body(url, wanted.size)
        except urllib.error.HTTPError as error:
            problem = f"{url} answers {error.code} {error.reason}"
            error.close()
            if error.code == 404:
                continue
            break
        except (urllib.error.URLError, http.client.HTTPException, OSError) as error:
            reason = getattr(error, "reason", None) or error
            raise UnderstudyError(
                f"{name}: cannot be downloaded: {reason}. Check the connection. {by_hand}"
            ) from None
        if len(body) > wanted.size:
            raise UnderstudyError(
                f"{name}: {url} is larger than the {wanted.size} bytes it should have; refused."
            )
        if len(body) < wanted.size:
            raise UnderstudyError(
                f"{name}: the download was cut short at {len(body)} of {wanted.size} bytes; "
                "try again."
            )
        if not _is(body, wanted):
            raise UnderstudyError(
                f"{name}: {url} is not the file meant (its SHA-256 differs); refused."
            )
        return body
    raise UnderstudyError(f"{name}: {problem}; the mirror may have moved. {by_hand}")


class _SameScheme(urllib.request.HTTPRedirectHandler):
    """Follows redirects only to https, or within this machine."""

    def redirect_request(self, req, fp, code, msg, headers, newurl):  # type: ignore[no-untyped-def]
        try:
            _checked_base(newurl)
        except InvalidValue:
            raise urllib.error.URLError(f"redirected to {newurl!r}") from None
        return super().redirect_request(req, fp, code, msg, headers, newurl)


def _body(url: str, size: int) -> bytes:
    """At most `size` + 1 bytes of what is at `url`."""
    request = urllib.request.Request(url, headers={"User-Agent": "understudy"})
    deadline = time.monotonic() + _DEADLINE
    chunks: list[bytes] = []
    left = size + 1
    with urllib.request.build_opener(_SameScheme).open(request, timeout=_TIMEOUT) as answer:
        while left > 0 and (chunk := answer.read(min(left, 65536))):
            chunks.append(chunk)
            left -= len(chunk)
            if time.monotonic() > deadline:
                raise urllib.error.URLError(f"no end after {_DEADLINE:g} s")
    return b"".join(chunks)
