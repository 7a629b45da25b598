"""Fetching against a server on this machine; nothing leaves it."""

from __future__ import annotations

import contextlib
import hashlib
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from understudy.errors import InvalidValue, UnderstudyError, UnknownName
from understudy.motion import fetch as module
from understudy.motion.fetch import CMU_TERMS, Source, fetch, fetchable, terms

BODY = b"HIERARCHY\n" + b"MOTION 1 2 3\n" * 5000


class Mirror(BaseHTTPRequestHandler):
    """Answers by path; counts what it was asked."""

    asked: list[str]

    def do_GET(self) -> None:
        self.asked.append(self.path)
        kind = self.path.split("/")[1]
        if kind == "moved":
            self.send_response(302)
            self.send_header("Location", self.path.replace("/moved/", "/good/"))
            self.end_headers()
            return
        if kind == "away":
            self.send_response(302)
            self.send_header("Location", "http://example.invalid/clip.bvh")
            self.end_headers()
            return
        if kind in ("missing", "broken"):
            self.send_error(404 if kind == "missing" else 503)
            return
        body = {"good": BODY, "other": BODY[::-1], "short": BODY[:-9], "huge": BODY * 50}.get(kind)
        self.send_response(200)
        if kind == "cut":  # promises more than it sends
            self.send_header("Content-Length", str(len(BODY)))
            body = BODY[:100]
        self.end_headers()
        with contextlib.suppress(OSError):  # the client may have had enough
            self.wfile.write(body or b"")
        if kind == "cut":
            self.close_connection = True

    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.fixture
def mirror(monkeypatch) -> Iterator[str]:
    """A server, and clips named after how it answers."""
    Mirror.asked = []
    server = ThreadingHTTPServer(("127.0.0.1", 0), Mirror)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    digest = hashlib.sha256(BODY).hexdigest()
    kinds = ("good", "other", "short", "cut", "huge", "missing", "broken", "moved", "away")
    made = {
        f"test/{kind}": Source(
            paths=(f"{kind}/clip.bvh",), size=len(BODY), sha256=digest, terms="any", motion="none"
        )
        for kind in kinds
    }
    made["test/second"] = Source(
        paths=("missing/clip.bvh", "good/clip.bvh"),
        size=len(BODY), sha256=digest, terms="any", motion="none",
    )  # fmt: skip
    monkeypatch.setattr(module, "_SOURCES", made)
    yield f"http://127.0.0.1:{server.server_address[1]}"
    server.shutdown()
    thread.join()
    server.server_close()


def test_a_clip_is_fetched_once_and_then_found(mirror, tmp_path):
    file = fetch("test/good", base=mirror, cache=tmp_path)
    assert file == tmp_path / "test" / "good.bvh"
    assert file.read_bytes() == BODY
    assert fetch("test/good", base=mirror, cache=tmp_path) == file
    assert Mirror.asked == ["/good/clip.bvh"]


def test_a_damaged_copy_is_fetched_again(mirror, tmp_path):
    file = fetch("test/good", base=mirror, cache=tmp_path)
    file.write_bytes(BODY[:-1] + b"X")
    assert fetch("test/good", base=mirror, cache=tmp_path).read_bytes() == BODY


def test_the_second_path_is_tried_where_the_first_is_missing(mirror, tmp_path):
    assert fetch("test/second", base=mirror, cache=tmp_path).read_bytes() == BODY


def test_redirects_within_the_machine_are_followed(mirror, tmp_path):
    assert fetch("test/moved", base=mirror, cache=tmp_path).read_bytes() == BODY


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("other", "not the file meant"),
        ("short", f"cut short at {len(BODY) - 9} of {len(BODY)}"),
        ("cut", "cut short|cannot be downloaded"),
        ("huge", "larger than"),
        ("missing", "answers 404.*put the file yourself"),
        ("broken", "answers 503"),
        ("away", "redirected to 'http://example.invalid"),
    ],
)
def test_anything_but_the_file_is_refused_and_leaves_nothing(mirror, tmp_path, kind, message):
    with pytest.raises(UnderstudyError, match=message):
        fetch(f"test/{kind}", base=mirror, cache=tmp_path)
    assert [p for p in tmp_path.rglob("*") if p.is_file()] == []


def test_no_connection_says_where_to_put_the_file(mirror, tmp_path):
    with pytest.raises(UnderstudyError, match=r"cannot be downloaded.*Check the connection.*good"):
        fetch("test/good", base="http://127.0.0.1:9", cache=tmp_path)


@pytest.mark.parametrize(
    "name", ["../../etc/passwd", "cmu/../../x", "/etc/passwd", "cmu\\..\\x", "cmu/02_99", ""]
)
def test_names_outside_the_table_are_refused(name, tmp_path):
    with pytest.raises(UnknownName, match="clip to fetch"):
        fetch(name, cache=tmp_path)


@pytest.mark.parametrize("base", ["http://example.com", "ftp://127.0.0.1", "file:///etc", "x", ""])
def test_bases_that_are_not_safe_are_refused(base, tmp_path):
    with pytest.raises(InvalidValue, match="https"):
        fetch("cmu/02_01", base=base, cache=tmp_path)


def test_every_source_has_a_full_checksum_and_terms():
    assert "cmu/02_01" in fetchable()
    for name in fetchable():
        where = module.source(name)
        assert len(where.sha256) == 64
        assert int(where.sha256, 16)
        assert 1000 < where.size < 10_000_000
        assert all(".." not in path and "//" not in path for path in where.paths)
        assert terms(name)
    assert terms("cmu/49_06") == CMU_TERMS


def test_the_cache_follows_the_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert module.cache_folder() == tmp_path / "understudy" / "clips"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(module.sys, "platform", "linux")
    assert module.cache_folder().parts[-3:] == (".cache", "understudy", "clips")
    monkeypatch.setattr(module.sys, "platform", "darwin")
    assert "Caches" in module.cache_folder().parts
    monkeypatch.setattr(module.sys, "platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path))
    assert module.cache_folder() == tmp_path / "understudy" / "clips"


@pytest.mark.clips
def test_checksums_are_those_of_the_real_clips(clips):
    folders = {"cmu": ("cmu_bvh", "cmu_3dsmax_bvh"), "drawings": ("other_bvh",)}
    for name in fetchable():
        kind, stem = name.split("/")
        files = [clips / f / f"{stem}.bvh" for f in folders[kind]]
        body = next(f for f in files if f.is_file()).read_bytes()
        assert hashlib.sha256(body).hexdigest() == module.source(name).sha256
        assert len(body) == module.source(name).size
