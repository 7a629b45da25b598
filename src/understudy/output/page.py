"""The frame of every page this package writes: one HTML file that asks nothing of a network.

In: a title and the page's body. Out: the page, light and dark, for screens and paper. Tables stand
in a `<div class="wide">`, warnings in a `<p class="held">`.
"""

from __future__ import annotations

import html as markup


def page(title: str, body: str, *, style: str = "", script: str = "") -> str:
    """A whole HTML page.

    Args:
        title: Plain text.
        body: HTML.
        style: CSS that the body needs besides the frame's.
        script: JavaScript.
    """
    return _PAGE.format(title=markup.escape(title), style=_STYLE + style, body=body, script=script)


_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; img-src data:; script-src 'unsafe-inline'; style-src 'unsafe-inline'">
<meta name="color-scheme" content="light dark">
<meta name="generator" content="Understudy">
<link rel="icon" href="data:,">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<main>
{body}
</main>
<script>{script}</script>
</body>
</html>
"""

_STYLE = """
:root{--page:#fff;--ink:#1c1f24;--dim:#5c6470;--rule:#dfe3e8;--panel:#f5f7f9;
 --good:#12724b;--held:#9a4a06;--c0:#1f5fc4;--c1:#c4501a;--c2:#0f8a63;--c3:#8453bd;
 --c4:#7a7f18;--c5:#b03a72}
@media screen and (prefers-color-scheme:dark){:root{--page:#15181c;--ink:#e8eaed;--dim:#9aa3ae;
 --rule:#30363d;--panel:#1d2126;--good:#5fd3a2;--held:#f0a35c;--c0:#7fb0ff;--c1:#ff9a66;
 --c2:#54d1a4;--c3:#c7a4ff;--c4:#d3d86a;--c5:#ff8fc0}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);
 font:16px/1.5 system-ui,-apple-system,"Segoe UI",sans-serif}
main{max-width:64rem;margin:0 auto;padding:1.5rem clamp(1rem,4vw,2rem) 3rem}
h1{margin:0 0 1rem;font-size:clamp(1.6rem,5vw,2.3rem);line-height:1.15;overflow-wrap:anywhere}
h2{margin:2.5rem 0 .75rem;font-size:1.3rem;border-top:1px solid var(--rule);padding-top:1rem}
h3{margin:1.25rem 0 .5rem;font-size:1rem}
p,li{max-width:75ch}
ul{padding-left:1.2rem}li{overflow-wrap:anywhere}
.kicker{margin:0;color:var(--dim);font-size:.875rem}
.held{padding:.6rem .9rem;background:var(--panel);border-left:4px solid var(--held)}
.wide{overflow-x:auto}
.wide table{border-collapse:collapse;width:100%;font-size:.875rem}
.wide caption{text-align:left;color:var(--dim);padding-bottom:.4rem}
.wide th,.wide td{padding:.3rem .6rem .3rem 0;border-bottom:1px solid var(--rule);text-align:right;
 font-variant-numeric:tabular-nums}
.wide th:first-child{text-align:left;padding-right:1rem}
.wide tbody th{font-weight:400}
@media print{:root{--page:#fff;--ink:#000;--dim:#444;--rule:#bbb;--panel:#f3f3f3}
 body{font-size:11pt}main{max-width:none;padding:0}.wide tr{break-inside:avoid}
 h2,h3{break-after:avoid}}
"""
