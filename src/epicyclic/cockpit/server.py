"""The server: one process on this machine alone, until Ctrl-C; and its guard, an ASGI application that lets nothing of
another site or machine through.

A token in the address that is printed lets a browser in, a cookie from then on.  A page of another site can make a
browser send requests to this machine, and by a name that it lets point to 127.0.0.1 it can read the answers too.  So
the host, the origin and the kind of fetch are asked, of every request and websocket, before anything reads them, and
then the cookie.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import html
import os
import re
import secrets
import signal
import socket
import stat
import sys
import threading
import webbrowser
from collections.abc import Awaitable, Callable, Iterable, Mapping, MutableMapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any
from urllib.parse import parse_qs

from ..errors import ModelError
from .state.state import PageState, opened, request_of, set_seal_key

_KEY_BYTES = 32  # of SHA-256, which signs the cookie
_TOKEN_BYTES = 24  # 192 bits: not to be guessed, and short enough for a line of a terminal


@dataclass(frozen=True, slots=True, kw_only=True)
class Passes:
    """What lets a browser in.

    Parameters
    ----------
    token : of this run, in the address that is printed.
    cookie : name and value of the cookie; another run on the same port and by the same user gives the same, so that a
        tab which stayed open goes on after a restart.
    seal : key of what a browser keeps of a file, the same in every run.
    """

    token: str
    cookie: tuple[str, str]
    seal: bytes = b""

    def admits_token(self, given: str) -> bool:
        """Whether this is the token of the run."""
        return hmac.compare_digest(given.encode(), self.token.encode())

    def admits_cookies(self, header: str) -> bool:
        """Whether a header ``Cookie`` holds the cookie, whatever other servers of this host have set beside it."""
        name, value = self.cookie
        pairs = (part.strip().partition("=") for part in header.split(";"))
        return any(key == name and hmac.compare_digest(given.encode(), value.encode()) for key, _, given in pairs)

    def set_cookie(self) -> str:
        """The header ``Set-Cookie``: sent back by pages of this site alone, and out of reach of scripts."""
        name, value = self.cookie
        return f"{name}={value}; Path=/; HttpOnly; SameSite=Strict"


def issue(port: int, folder: Path | None) -> Passes:
    """Passes of a server.

    Parameters
    ----------
    port : it listens on; cookies know hosts but no ports, so the name says it.
    folder : of the user, where the key lies; None, or one that cannot be used, gives a key of this run alone.
    """
    key = _kept_key(folder) if folder is not None else secrets.token_bytes(_KEY_BYTES)
    cookie, seal = (hmac.new(key, use.encode(), hashlib.sha256) for use in (f"cockpit on port {port}", "kept state"))
    return Passes(
        token=secrets.token_urlsafe(_TOKEN_BYTES),
        cookie=(f"epicyclic-{port}", cookie.hexdigest()),
        seal=seal.digest(),
    )


def state_folder(environment: Mapping[str, str] = os.environ, platform: str = sys.platform) -> Path | None:
    """Folder of the user for what outlives a run; None where there is no home."""
    if named := environment.get("XDG_STATE_HOME"):
        return Path(named) / "epicyclic"
    if platform == "win32":
        local = environment.get("LOCALAPPDATA")
        return Path(local) / "epicyclic" if local else None
    try:
        home = Path.home()
    except RuntimeError:
        return None
    return home / ("Library/Application Support" if platform == "darwin" else ".local/state") / "epicyclic"


def _kept_key(folder: Path) -> bytes:
    """The key of the user, made at the first run; a fresh one where it cannot be kept in private."""
    file = folder / "cockpit.key"
    fresh = secrets.token_bytes(_KEY_BYTES)
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if (kept := _private_key(file)) is not None:
            return kept
        with suppress(FileNotFoundError):
            file.unlink()  # somebody else could read or has cut it
        with os.fdopen(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as opened:
            opened.write(fresh)
    except FileExistsError:  # another server of the user was quicker
        with suppress(OSError):
            return _private_key(file) or fresh
    except OSError:
        pass
    return fresh


def _private_key(file: Path) -> bytes | None:
    """Key of a regular file that its owner alone can read, whole."""
    try:
        status = file.lstat()
    except FileNotFoundError:
        return None
    open_to_others = os.name == "posix" and (status.st_mode & 0o077 or status.st_uid != os.getuid())
    if not stat.S_ISREG(status.st_mode) or open_to_others or status.st_size != _KEY_BYTES:
        return None
    return file.read_bytes()


# guard ----------------------------------------------------------------------------------------------------------------

# query of a page that the shell has asked for: if it is refused too there is no cookie, and no further reload helps
MARK = "here"
# another address, or the browser would repeat the request of the other site; the fragment never reaches the server
_SCRIPT = f"location.replace('/?{MARK}' + location.hash)"
_STYLE = "body{font:16px system-ui,sans-serif;max-width:40em;margin:4em auto;padding:0 1em;color-scheme:light dark}"
_HEAD = "<!doctype html><html lang=en><meta charset=utf-8><title>epicyclic</title>"

SHELL = f"{_HEAD}<style>{_STYLE}</style><p>Opening the cockpit.</p><script>{_SCRIPT}</script>".encode()


def _hash_of(text: str) -> str:
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"


# of both pages: their own script and style, nothing else
SHELL_POLICY = (
    f"default-src 'none'; script-src {_hash_of(_SCRIPT)}; style-src {_hash_of(_STYLE)}; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)


def refusal(title: str, text: str) -> bytes:
    """A page that says why there is no cockpit and what to do."""
    return f"{_HEAD}<style>{_STYLE}</style><h1>{html.escape(title)}</h1><p>{html.escape(text)}</p>".encode()


Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[Message, Receive, Send], Awaitable[None]]

# a model file of the largest size, 4 MB, and what a form wraps around it
MOST_BODY = 4_000_000 + 10_000
# what a page is made of; nothing else of a folder of the package is given out
_STATIC = re.compile(r"\.(js|mjs|css|map|woff2?|svg|png|ico|txt)\Z|/LICEN[CS]E[\w.-]*\Z", re.IGNORECASE)
_FRAMEWORK = "/_nicegui/"
_NO_FILES = ("/_nicegui/client/", "/_nicegui/auto/")  # uploads of a client, downloads of one file
_FOLDERS = (_FRAMEWORK, "/_nicegui_ws/")
_ICON = "/favicon.ico"
_STRANGE = re.compile(r"(^|/)\.\.?(/|$)|[\\\x00-\x1f\x7f]|//")
_METHODS = {"GET", "HEAD", "POST"}
_PAGE = "/"
_MOST_FIELDS = 20  # of a query; the page has two
_TEXT = (b"content-type", b"text/html; charset=utf-8")


class Guard:
    """The application behind it, for the browser of this user on this machine alone.

    Parameters
    ----------
    app : ASGI application.  port : the server listens on.  passes : what lets a browser in.
    """

    def __init__(self, app: Application, *, port: int, passes: Passes) -> None:
        self._app = app
        self._passes = passes
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        sockets = " ".join(f"ws://{host}" for host in sorted(self._hosts))
        self._headers = [(name.encode(), value.encode()) for name, value in _headers(sockets)]

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer a request or pass it on."""
        if scope["type"] == "websocket":
            await self._websocket(scope, receive, send)
        elif scope["type"] == "http":
            await self._http(scope, receive, self._with_headers(send))
        else:
            await self._app(scope, receive, send)

    async def _websocket(self, scope: Message, receive: Receive, send: Send) -> None:
        if self._foreign(scope) or self._other_site(scope) or not self._has_cookie(scope):
            await receive()
            await send({"type": "websocket.close", "code": 1008})  # before it is accepted: 403
        else:
            await self._app(_direct(scope), receive, send)

    async def _http(self, scope: Message, receive: Receive, send: Send) -> None:
        if (problem := self._foreign(scope)) or (problem := _malformed(scope)):
            await _answer(send, *problem)
        elif self._other_site(scope):
            if _is_visit(scope):
                await _page(send, 200, SHELL)
            else:
                await _answer(send, 403, "asked for by another site")
        elif scope["path"] == _PAGE and (token := _query(scope).get("token")):
            await self._enter(token[0], scope, send)
        elif not self._has_cookie(scope):
            await self._without_cookie(scope, send)
        elif not _is_served(scope["path"]):
            await _answer(send, 404, "not here")
        else:
            await self._app(_direct(scope), receive, send)

    async def _enter(self, token: str, scope: Message, send: Send) -> None:
        """The address that was printed: a cookie, and on to the page without the token in its address."""
        if self._passes.admits_token(token):
            headers = [(b"location", b"/"), (b"set-cookie", self._passes.set_cookie().encode())]
            await _respond(send, 303, headers, b"")
        elif self._has_cookie(scope):  # a bookmark of an earlier run, in a browser that is known
            await _respond(send, 303, [(b"location", b"/")], b"")
        else:
            await self._without_cookie(scope, send)

    async def _without_cookie(self, scope: Message, send: Send) -> None:
        if scope["path"] == _PAGE and scope["method"] == "GET":
            if MARK in _query(scope) or any(_all(scope, b"sec-fetch-site")[:1]):
                words = "Open the address that `epicyclic app` has printed: it lets this browser in."
                await _page(send, 403, refusal("This browser is not known here", words))
            else:  # a browser that does not say who asked may have held its cookie back
                await _page(send, 200, SHELL)
        else:
            await _answer(send, 403, "no cookie of this server")

    def _foreign(self, scope: Message) -> tuple[int, str] | None:
        """A request for another name than this machine's, which points here, or of another origin."""
        hosts = _all(scope, b"host")
        if len(hosts) != 1 or hosts[0].lower() not in self._hosts:
            return 421, "no such host here"
        origins = _all(scope, b"origin")
        if not origins or origins == [f"http://{hosts[0].lower()}"]:
            return None
        return 403, "of another origin"

    def _other_site(self, scope: Message) -> bool:
        """Whether a page of another site has asked; another port of this machine is another site too."""
        return any(value not in ("same-origin", "none") for value in _all(scope, b"sec-fetch-site"))

    def _has_cookie(self, scope: Message) -> bool:
        return self._passes.admits_cookies("; ".join(_all(scope, b"cookie")))

    def _with_headers(self, send: Send) -> Send:
        """Send with the headers that each answer has; one that an answer has already stays."""

        async def sender(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = list(message.get("headers", []))
                named = {name.lower() for name, _ in headers}
                message = {**message, "headers": headers + [pair for pair in self._headers if pair[0] not in named]}
            await send(message)

        return sender


def _headers(sockets: str) -> Iterable[tuple[str, str]]:
    """Headers of each answer.  Scripts come from here alone; the framework needs those in the page and `eval`."""
    policy = (
        "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; font-src 'self' data:; worker-src 'self' blob:; frame-src 'none'; "
        f"connect-src 'self' {sockets} data: blob:; object-src 'none'; base-uri 'none'; form-action 'self'; "
        "frame-ancestors 'none'"
    )
    yield "content-security-policy", policy
    yield "x-content-type-options", "nosniff"
    yield "x-frame-options", "DENY"
    yield "referrer-policy", "no-referrer"
    yield "cross-origin-opener-policy", "same-origin"
    yield "cross-origin-resource-policy", "same-origin"


def _malformed(scope: Message) -> tuple[int, str] | None:
    """A method, a path or a body that no page of the cockpit sends."""
    method = scope["method"]
    if method not in _METHODS:
        return 405, "GET, HEAD or POST"
    if _STRANGE.search(scope["path"]):
        return 400, "no such path"
    lengths = _all(scope, b"content-length")
    if _all(scope, b"transfer-encoding") or (method == "POST" and not lengths):
        return 411, "say how long it is"  # an upload without end would fill the memory before it is refused
    if any(not length.isascii() or not length.isdigit() or int(length[:20]) > MOST_BODY for length in lengths):
        return 413, f"at most {MOST_BODY} bytes"
    return None


def _is_visit(scope: Message) -> bool:
    """Whether a person has followed a link to the page: shown in a tab of its own, not in a part of another page."""
    kind = _all(scope, b"sec-fetch-mode"), _all(scope, b"sec-fetch-dest")
    return scope["method"] == "GET" and scope["path"] == _PAGE and kind == (["navigate"], ["document"])


def _is_served(path: str) -> bool:
    """Whether the page or a part of it lies there."""
    if path in (_PAGE, _ICON):
        return True
    if not path.startswith(_FOLDERS):
        return False
    file = path.startswith(_FRAMEWORK) and not path.startswith(_NO_FILES) and "/dynamic_resources/" not in path
    return not file or _STATIC.search(path) is not None


def _direct(scope: Message) -> Message:
    """Without headers of a proxy, of which there is none: the page would be built for the address that they say."""
    kept = [(name, value) for name, value in scope["headers"] if not name.startswith((b"x-forwarded", b"forwarded"))]
    return {**scope, "headers": kept}


def _query(scope: Message) -> dict[str, list[str]]:
    text = scope.get("query_string", b"").decode("latin-1")
    try:
        return parse_qs(text, keep_blank_values=True, max_num_fields=_MOST_FIELDS)
    except ValueError:
        return {}


def _all(scope: Message, name: bytes) -> list[str]:
    """Values of a header, in latin-1 as HTTP has them."""
    return [value.decode("latin-1").strip() for key, value in scope["headers"] if key.lower() == name]


async def _page(send: Send, status: int, body: bytes) -> None:
    policy = (b"content-security-policy", SHELL_POLICY.encode())
    await _respond(send, status, [_TEXT, policy, (b"cache-control", b"no-store")], body)


async def _answer(send: Send, status: int, text: str) -> None:
    await _respond(send, status, [(b"content-type", b"text/plain; charset=utf-8")], f"{text}\n".encode())


async def _respond(send: Send, status: int, headers: list[tuple[bytes, bytes]], body: bytes) -> None:
    length = (b"content-length", str(len(body)).encode())
    # a refused body is not read: the connection cannot be used again
    closing = [(b"connection", b"close")] if status in (411, 413) else []
    await send({"type": "http.response.start", "status": status, "headers": [*headers, length, *closing]})
    await send({"type": "http.response.body", "body": body})


# server ---------------------------------------------------------------------------------------------------------------

PORT = 8765  # 8080 and 8000 are what other development servers take first
_MORE_PORTS = 20  # tried where the port is taken: as many cockpits at once
_HOST = "127.0.0.1"
_WAITING = 64  # connections that wait to be accepted: a page asks for some twenty files at once
# [byte] of a message of the page: a model file of 4 MB as text in an editor, a figure drawn for printing
_LARGEST_MESSAGE = 8_000_000
_LAST_WORDS = 2  # [s] that answers which are being sent have when the server ends
# [s] a tab may be away before it counts as gone: a network that hiccups; what it shows is not computed any more then
_AWAY = 4.0
_KEPT_MESSAGES = 200  # of a tab, sent again after a hiccup: what a drag says while it is away, not 25 MB of frames


def serve(source: str | Path | None, *, port: int | None, browser: bool, tell: Callable[[str], None]) -> None:
    """Serve the cockpit until it is interrupted.

    Parameters
    ----------
    source : ready drive, model file or REXS file to begin with; None begins with an empty page.
    port : to listen on; None takes `PORT`, or the next one that is free.
    browser : open the page in the browser of this machine.
    tell : called with the address, token included, as soon as it answers.

    Raises
    ------
    ModelError : the model is wrong, or the port cannot be had.
    KeyboardInterrupt : it was stopped.
    """
    state = None
    if source is not None:  # read through once, so that a wrong model is told before there is a page
        from ..train.resolution import load

        state = opened(source)
        load(*request_of(state))
    with _bound(port) as listening:
        number = int(listening.getsockname()[1])
        folder = state_folder()
        # read when the framework is imported: else it looks for its storage in the folder one happens to be in
        os.environ["NICEGUI_STORAGE_PATH"] = str((folder or Path.home()) / "framework")
        passes = issue(number, folder)
        set_seal_key(passes.seal)
        address = f"http://{_HOST}:{number}/?token={passes.token}"

        def ready() -> None:
            tell(address)
            if browser:
                # some browsers keep the call until they are closed
                threading.Thread(target=webbrowser.open, args=[address], daemon=True).start()

        _serve_application(state, listening, passes, ready)


def _bound(port: int | None) -> socket.socket:
    """A socket of this machine alone that listens already: no other program takes the port in between."""
    wanted = range(PORT, PORT + _MORE_PORTS) if port is None else (port,)
    problem = ""
    for number in wanted:
        listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        if os.name == "posix":  # elsewhere it would share the port of another program
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((_HOST, number))
            listening.listen(_WAITING)
        except (OSError, OverflowError) as error:
            listening.close()
            problem = getattr(error, "strerror", None) or str(error)
        else:
            return listening
    given = f"{wanted[0]}" if len(wanted) == 1 else f"{wanted[0]} .. {wanted[-1]}"
    raise ModelError(f"cannot be listened on: {problem}", path="--port", given=given, allowed="a port that is free")


def _serve_application(
    state: PageState | None, listening: socket.socket, passes: Passes, ready: Callable[[], None]
) -> None:
    from fastapi import FastAPI
    from nicegui import core, ui
    from uvicorn import Config, Server

    from .page.tabs import mount

    class Announcing(Server):
        interrupted = False

        def handle_exit(self, sig: int, frame: FrameType | None) -> None:
            self.interrupted |= sig == signal.SIGINT
            super().handle_exit(sig, frame)

        async def startup(self, sockets: list[socket.socket] | None = None) -> None:
            await super().startup(sockets=sockets)
            if self.started:
                ready()

    outer = FastAPI(docs_url=None, redoc_url=None, openapi_url=None, lifespan=mount(state))
    ui.run_with(
        outer,
        title="epicyclic",
        favicon=_PLANETS,
        dark=None,
        language="en-US",
        reconnect_timeout=_AWAY,
        message_history_length=_KEPT_MESSAGES,
        show_welcome_message=False,
        binding_refresh_interval=None,  # nothing of the page is bound: an idle page costs nothing
    )
    core.sio.eio.max_http_buffer_size = _LARGEST_MESSAGE  # of websockets too, whatever its name
    config = Config(
        Guard(outer, port=int(listening.getsockname()[1]), passes=passes),
        ws="wsproto",
        ws_max_size=_LARGEST_MESSAGE,
        ws_per_message_deflate=False,  # nothing leaves this machine, and to compress a frame takes 10 ms
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        timeout_graceful_shutdown=_LAST_WORDS,
    )
    sys.stdout.flush()
    server = Announcing(config)
    server.run(sockets=[listening])
    # it raises the signal again at its end, where a finalizer may swallow what that raises
    if server.interrupted:
        raise KeyboardInterrupt


# three planets about a sun
_PLANETS = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><g fill="none" stroke="#1f6fb2" stroke-width="2.5">'
    '<circle cx="16" cy="16" r="14"/><circle cx="16" cy="16" r="5"/></g><g fill="#1f6fb2">'
    '<circle cx="16" cy="6.5" r="3.6"/><circle cx="24.2" cy="20.7" r="3.6"/><circle cx="7.8" cy="20.7" r="3.6"/>'
    "</g></svg>"
)
