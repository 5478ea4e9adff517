"""The server: one process on this machine alone, until Ctrl-C."""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path
from types import FrameType

from ...errors import ModelError
from ..state.history import set_seal_key
from ..state.state import PageState, opened, request_of
from .guard import Passes, issue, state_folder

PORT = 8765  # 8080 and 8000 are what other development servers take first
_MORE_PORTS = 20  # tried where the port is taken: as many cockpits at once
_HOST = "127.0.0.1"
_WAITING = 64  # connections that wait to be accepted: a page asks for some twenty files at once
# [byte] of a message of the page: a model file of 4 MB as text in an editor, a figure drawn for printing
_LARGEST_MESSAGE = 8_000_000
_LAST_WORDS = 2  # [s] that answers which are being sent have when the server ends
# [s] a tab may be away before its session ends: a reload, a network that hiccups; a closed tab stops computing then
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
        from ...train.resolution import load

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

    from .guard import Guard
    from .sessions import mount

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
        favicon=_ICON,
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
_ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><g fill="none" stroke="#1f6fb2" stroke-width="2.5">'
    '<circle cx="16" cy="16" r="14"/><circle cx="16" cy="16" r="5"/></g><g fill="#1f6fb2">'
    '<circle cx="16" cy="6.5" r="3.6"/><circle cx="24.2" cy="20.7" r="3.6"/><circle cx="7.8" cy="20.7" r="3.6"/>'
    "</g></svg>"
)
