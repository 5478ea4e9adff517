"""The command `epicyclic app`: the cockpit, a page on this machine on which a train answers while it is changed."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Annotated

import typer

from ..errors import ModelError
from .completion import model_names
from .console import complain, reported

__all__ = ["app"]

_NEEDED = ("nicegui", "tomlkit")  # of the extra "app"
_LARGEST_PORT = 65_535


def app(
    model: Annotated[
        str | None,
        typer.Argument(
            metavar="[MODEL]",
            help="A model file (.toml), a REXS file (.rexs), or the name of a ready drive; without it an empty page.",
            show_default=False,
            autocompletion=model_names,
        ),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            metavar="N", min=1, max=_LARGEST_PORT, help="Port to listen on.", show_default="8765, or the next free one"
        ),
    ] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """The cockpit: a page on this machine with sliders, where the train answers while they move."""
    with reported():
        missing = [name for name in _NEEDED if find_spec(name) is None]
        if missing:
            raise ModelError(
                f"needs {' and '.join(missing)}", path="epicyclic app", allowed="pip install 'epicyclic[app]'"
            )
        from ..cockpit.server.run import serve

        serve(model, port=port, browser=browser, tell=_tell)


def _tell(address: str) -> None:
    complain(f"the cockpit is open at {address}")
    complain("for this browser and this machine alone; Ctrl-C ends it")
