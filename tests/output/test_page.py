"""The frame of pages."""

from __future__ import annotations

from html.parser import HTMLParser

from understudy.output.page import page


def test_a_page_is_closed_and_escapes_its_title():
    text = page("Bodies & <minds>", "<p>Body.</p>", style=".own{}", script="run()")
    assert "<title>Bodies &amp; &lt;minds&gt;</title>" in text
    assert ".own{}" in text and "<script>run()</script>" in text
    opened: list[str] = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, attrs):
            if tag not in ("meta", "link"):
                opened.append(tag)

        def handle_endtag(self, tag):
            assert opened.pop() == tag

    Reader().feed(text)
    assert not opened


def test_braces_in_a_body_stay():
    assert '{"a": {"b": 1}}' in page("t", '<script>{"a": {"b": 1}}</script>')


def test_a_page_forbids_the_network():
    text = page("t", "")
    assert "default-src 'none'" in text
    assert "http" not in text.replace("http-equiv", "")
