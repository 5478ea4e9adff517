"""The guard: what another site, another machine or a program without a pass can send, and that it gets nothing.

Every attack is first sent to the same application without the guard, where it succeeds: an attack that is refused for
another reason would prove nothing.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, MutableMapping
from typing import Any
from urllib.parse import unquote

import pytest

httpx = pytest.importorskip("httpx", reason="the extra dev has httpx")

from epicyclic.cockpit.server import MARK, MOST_BODY, SHELL, Guard, Passes  # noqa: E402

PORT = 18701
HOST = f"127.0.0.1:{PORT}"
PASSES = Passes(token="the-token", cookie=(f"epicyclic-{PORT}", "abc"))
COOKIE = {"cookie": f"other=1; epicyclic-{PORT}=abc"}
SECRET = b"what the page holds"
JS = "/_nicegui/3.0/resources/key/panes.js"


async def page(scope: MutableMapping[str, Any], receive: Any, send: Any) -> None:
    """An application that answers everything with what it should keep."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.accept"})
        await send({"type": "websocket.send", "bytes": SECRET})
        return
    while (await receive()).get("more_body"):
        pass
    seen = b",".join(sorted(name for name, _ in scope["headers"]))
    await send({"type": "http.response.start", "status": 200, "headers": [(b"x-seen", seen)]})
    await send({"type": "http.response.body", "body": SECRET})


GUARDED = Guard(page, port=PORT, passes=PASSES)


def asked(app: Any, method: str, path: str, headers: dict[str, str], content: Any = None) -> Any:
    async def inner(scope: Any, receive: Any, send: Any) -> None:
        path = unquote(headers["raw"]) if "raw" in headers else scope["path"]  # httpx tidies a path up
        await app({**scope, "path": path}, receive, send)

    async def ask() -> Any:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(inner)) as client:
            request = client.build_request(method, f"http://{HOST}{path}", headers=headers, content=content)
            return await client.send(request)

    return asyncio.run(ask())


async def without_length() -> AsyncIterator[bytes]:
    yield b"x"


SITE = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate", "sec-fetch-dest": "document"}
FRAME = {**SITE, "sec-fetch-dest": "iframe"}
ATTACKS: dict[str, tuple[int, str, str, dict[str, str], Any]] = {
    "a name that points here": (421, "GET", "/", {**COOKIE, "host": f"evil.example:{PORT}"}, None),
    "a name that begins like ours": (421, "GET", "/", {**COOKIE, "host": f"{HOST}.evil.example"}, None),
    "our name, another port": (421, "GET", "/", {**COOKIE, "host": "127.0.0.1:80"}, None),
    "no port": (421, "GET", "/", {**COOKIE, "host": "localhost"}, None),
    "another origin": (403, "GET", "/", {**COOKIE, "origin": "http://evil.example"}, None),
    "the origin of another port": (403, "GET", "/", {**COOKIE, "origin": "http://127.0.0.1:80"}, None),
    "the other of our names": (403, "GET", "/", {**COOKIE, "origin": f"http://localhost:{PORT}"}, None),
    "a page without an origin": (403, "GET", "/", {**COOKIE, "origin": "null"}, None),
    "a picture of another site": (403, "GET", JS, {**COOKIE, "sec-fetch-site": "cross-site"}, None),
    "a script of another port": (403, "GET", JS, {**COOKIE, "sec-fetch-site": "same-site"}, None),
    "a frame of another site": (403, "GET", "/", {**COOKIE, **FRAME}, None),
    "a form of another site": (403, "POST", "/", {**COOKIE, **SITE, "content-length": "0"}, None),
    "polling of another site": (403, "GET", "/_nicegui_ws/socket.io/?EIO=4", {**COOKIE, **SITE}, None),
    "no cookie": (403, "GET", JS, {}, None),
    "no cookie, from here": (403, "GET", "/", {"sec-fetch-site": "same-origin"}, None),
    "another cookie": (403, "GET", JS, {"cookie": f"epicyclic-{PORT}=xyz"}, None),
    "the cookie of another port": (403, "GET", JS, {"cookie": "epicyclic-80=abc"}, None),
    "broken cookies": (403, "GET", JS, {"cookie": "a[]=1;;=; \x7f"}, None),
    "the token of another run": (403, "GET", "/?token=the-tokex", {"sec-fetch-site": "none"}, None),
    "the token elsewhere": (403, "GET", f"{JS}?token=the-token", {}, None),
    "a body that is too long": (413, "POST", "/", COOKIE, b"x" * (MOST_BODY + 1)),
    "a page with a long body": (413, "GET", "/", COOKIE, b"x" * (MOST_BODY + 1)),
    "a length that is none": (413, "POST", "/", {**COOKIE, "content-length": "-1"}, b"x"),
    "a body without a length": (411, "POST", "/", COOKIE, without_length),
    "a form without a body": (411, "POST", "/", {**COOKIE, "no-length": ""}, None),
    "another method": (405, "PUT", "/", COOKIE, b"x"),
    "what a browser asks before": (405, "OPTIONS", "/", COOKIE, None),
    "a folder up": (400, "GET", "/", {**COOKIE, "raw": "/_nicegui/3.0/static/../../passes.js"}, None),
    "a folder up, escaped": (400, "GET", "/", {**COOKIE, "raw": "/_nicegui/3.0/static/%2e%2e/passes.js"}, None),
    "a folder up, backslash": (400, "GET", "/", {**COOKIE, "raw": "/_nicegui/3.0/static/..%5Cpasses.js"}, None),
    "the end of a name": (400, "GET", "/", {**COOKIE, "raw": "/_nicegui/3.0/static/a.js%00.png"}, None),
    "the source of a module": (404, "GET", "/_nicegui/3.0/resources/key/element.py", COOKIE, None),
    "no part of the page": (404, "GET", "/etc/passwd", COOKIE, None),
    "what the framework might offer": (404, "GET", "/openapi.json", COOKIE, None),
    "a hidden file": (404, "GET", "/_nicegui/3.0/resources/key/.env", COOKIE, None),
}


@pytest.mark.parametrize("name", list(ATTACKS))
def test_an_attack_gets_nothing(name: str) -> None:
    status, method, path, headers, content = ATTACKS[name]
    make = content() if callable(content) else content
    assert SECRET in asked(page, method, path, headers, make).content  # the attack as such works
    make = content() if callable(content) else content
    if "no-length" in headers:
        answer = posted_without_length()
    else:
        answer = asked(GUARDED, method, path, headers, make)
    assert answer.status_code == status
    assert SECRET not in answer.content
    assert "set-cookie" not in answer.headers


def posted_without_length() -> Any:
    """A POST that says nothing of its length: httpx always says it."""

    async def ask(scope: Any, receive: Any, send: Any) -> None:
        kept = [pair for pair in scope["headers"] if pair[0] != b"content-length"]
        await GUARDED({**scope, "headers": kept}, receive, send)

    return asked(ask, "POST", "/", COOKIE)


def socket_of(app: Any, headers: dict[str, str]) -> list[MutableMapping[str, Any]]:
    """What a websocket is told."""
    sent: list[MutableMapping[str, Any]] = []

    async def receive() -> MutableMapping[str, Any]:
        return {"type": "websocket.connect"}

    async def send(message: MutableMapping[str, Any]) -> None:
        sent.append(message)

    scope = {
        "type": "websocket",
        "path": "/_nicegui_ws/socket.io/",
        "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
    }
    asyncio.run(app(scope, receive, send))
    return sent


@pytest.mark.parametrize(
    "headers",
    [
        {**COOKIE, "host": f"evil.example:{PORT}"},
        {**COOKIE, "host": HOST, "origin": "http://evil.example"},
        {**COOKIE, "host": HOST, "origin": f"http://localhost:{PORT}"},
        {**COOKIE, "host": HOST, "sec-fetch-site": "same-site"},
        {"host": HOST, "origin": f"http://{HOST}"},
        COOKIE,
    ],
    ids=["host", "origin", "our other name", "fetch", "no cookie", "no host"],
)
def test_a_websocket_of_another_site_is_refused(headers: dict[str, str]) -> None:
    assert socket_of(page, headers)[-1].get("bytes") == SECRET
    assert socket_of(GUARDED, headers) == [{"type": "websocket.close", "code": 1008}]


def test_the_own_page_is_served() -> None:
    own = {**COOKIE, "sec-fetch-site": "same-origin", "origin": f"http://{HOST}", "host": HOST}
    assert asked(GUARDED, "GET", "/", own).content == SECRET
    assert asked(GUARDED, "POST", "/_nicegui/client/1/upload/2", own, b"x" * 4_000_000).content == SECRET
    assert asked(GUARDED, "GET", JS, own).content == SECRET
    assert socket_of(GUARDED, own)[-1].get("bytes") == SECRET
    localhost = {**COOKIE, "host": f"localhost:{PORT}", "origin": f"http://localhost:{PORT}"}
    assert asked(GUARDED, "GET", "/", localhost).content == SECRET


def test_the_token_gives_a_cookie_and_leaves_the_address() -> None:
    answer = asked(GUARDED, "GET", "/?token=the-token", {"sec-fetch-site": "none"})
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    assert answer.headers["set-cookie"] == f"epicyclic-{PORT}=abc; Path=/; HttpOnly; SameSite=Strict"
    known = asked(GUARDED, "GET", "/?token=of-an-earlier-run", COOKIE)
    assert (known.status_code, known.headers["location"]) == (303, "/")
    assert "set-cookie" not in known.headers


def test_a_link_followed_elsewhere_meets_a_page_without_a_state() -> None:
    for cookie in ({}, COOKIE):  # a browser holds the cookie back; one that does not gives nothing more
        answer = asked(GUARDED, "GET", "/?token=the-token", {**SITE, **cookie})
        assert (answer.status_code, answer.content) == (200, SHELL)
        assert "set-cookie" not in answer.headers
        assert "script-src 'sha256-" in answer.headers["content-security-policy"]
    assert asked(GUARDED, "GET", f"/?{MARK}", {}).status_code == 403  # the shell has asked already: no further round


def test_every_answer_says_what_a_browser_must_not_do() -> None:
    for answer in (asked(GUARDED, "GET", "/", COOKIE), asked(GUARDED, "GET", JS, {}), asked(GUARDED, "GET", "/", {})):
        assert "frame-ancestors 'none'" in answer.headers["content-security-policy"]
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["referrer-policy"] == "no-referrer"


def test_headers_of_a_proxy_do_not_reach_the_page() -> None:
    forged = {**COOKIE, "x-forwarded-prefix": "/evil", "x-forwarded-host": "evil.example", "forwarded": "host=evil"}
    assert b"forwarded" in asked(page, "GET", "/", forged).headers["x-seen"].encode()
    assert b"forwarded" not in asked(GUARDED, "GET", "/", forged).headers["x-seen"].encode()


def status_of(method: str, *headers: tuple[bytes, bytes]) -> int:
    """Status of a request that is let in, with further headers; a client library sends none of them twice."""
    sent: list[MutableMapping[str, Any]] = []

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": b"x", "more_body": False}

    async def send(message: MutableMapping[str, Any]) -> None:
        sent.append(message)

    own = [(b"host", HOST.encode()), (b"cookie", COOKIE["cookie"].encode()), *headers]
    scope = {"type": "http", "method": method, "path": "/", "query_string": b"", "headers": own}
    asyncio.run(GUARDED(scope, receive, send))
    return int(sent[0]["status"])


def test_two_names_and_a_body_in_pieces_are_refused() -> None:
    length = (b"content-length", b"1")
    assert status_of("POST", length) == 200
    assert status_of("POST", length, (b"host", HOST.encode())) == 421
    assert status_of("POST", length, (b"transfer-encoding", b"chunked")) == 411
