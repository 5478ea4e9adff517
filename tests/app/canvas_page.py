"""A static page with the three panes, served to a browser from the package's files without a server."""

from __future__ import annotations

import base64
import mimetypes
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import epicyclic

STATIC = Path(epicyclic.__file__).parent / "cockpit" / "page" / "static"
ORIGIN = "http://cockpit.test"
PAGE = """<!doctype html><html><head><meta charset="utf-8"><style>
 body { margin: 8px; display: grid; grid-template-columns: 424px 592px; gap: 8px; font: 13px sans-serif;
   background: #eee }
 .body--dark { background: #000 }
 #train { grid-row: 1 / 3; height: 568px } #sweep { height: 290px } #evidence { height: 270px }
</style></head><body class="body--light"><div id="train"></div><div id="sweep"></div><div id="evidence"></div>
<script type="module">
 import { createPane } from "/static/index.js";
 import * as frames from "/static/frames.js";
 import * as painter from "/static/train_paint.js";
 import * as labels from "/static/labels.js";
 import * as plot from "/static/plot.js";
 import * as look from "/static/look.js";
 window.heard = [];
 const options = { onSpeed: (x) => heard.push(["speed", x]), onMode: (i) => heard.push(["mode", i]) };
 window.panes = Object.fromEntries(["train", "sweep", "evidence"].map(
   (kind) => [kind, createPane(kind, document.getElementById(kind), { label: kind, ...options })]));
 Object.assign(window, { frames, painter, labels, look, plot, ready: true });
</script></body></html>"""


def opened(browser: Any, *, width: int = 1048, height: int = 590, **options: Any) -> Any:
    """The page in a new context of the browser, its panes made; errors of the page are collected in `page.problems`."""
    context = browser.new_context(viewport={"width": width, "height": height}, **options)
    page = context.new_page()
    page.set_default_timeout(8000)
    page.problems = []
    page.on("pageerror", lambda error: page.problems.append(str(error)))
    page.on("console", lambda said: page.problems.append(said.text) if said.type == "error" else None)
    page.route(f"{ORIGIN}/**", _serve)
    loaded(page)
    return page


def loaded(page: Any) -> None:
    """Load the page, over what it has shown."""
    page.mouse.move(0, 0)
    page.goto(f"{ORIGIN}/")
    page.wait_for_function(
        "window.ready === true && getComputedStyle(document.body).getPropertyValue('--ck-ink') !== ''"
    )


def _serve(route: Any) -> None:
    path = urlsplit(route.request.url).path
    if path == "/":
        route.fulfill(body=PAGE, content_type="text/html")
    elif path == "/favicon.ico":
        route.fulfill(status=204)
    else:
        file = STATIC / path.removeprefix("/static/")
        route.fulfill(body=file.read_bytes(), content_type=mimetypes.guess_type(file.name)[0] or "text/plain")


def show(page: Any, *frames: bytes) -> None:
    """Give packed frames to the page, as the server does."""
    for frame in frames:
        page.evaluate("text => cockpit.frame(text)", base64.b64encode(frame).decode())


def painted(page: Any, kind: str, rev: int) -> None:
    """Wait until a pane has painted a revision."""
    page.wait_for_selector(f'.ck-pane[data-kind="{kind}"][data-rev="{rev}"]', timeout=5000)
