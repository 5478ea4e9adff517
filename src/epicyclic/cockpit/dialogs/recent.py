"""Files that were opened or saved last, kept in the browser: they are paths as a person types them, nothing more."""

from __future__ import annotations

import json
from pathlib import Path

from nicegui import ui

__all__ = ["recent_files", "remember"]

_KEY = "epicyclic-recent"
# Files that are listed: those of a week.
_MOST = 8
# [s] a browser may take to answer
_ANSWER = 3.0


def remember(path: Path) -> None:
    """Put a file ahead of the list."""
    ui.run_javascript(
        f"""try {{
            const old = JSON.parse(localStorage.getItem("{_KEY}") || "[]").filter((one) => one !== {_text(path)});
            localStorage.setItem("{_KEY}", JSON.stringify([{_text(path)}, ...old].slice(0, {_MOST})));
        }} catch {{}}"""
    )


async def recent_files() -> list[str]:
    """Paths of the list, the newest first; what is no text is left out."""
    try:
        found = await ui.run_javascript(
            f"try {{ return JSON.parse(localStorage.getItem('{_KEY}') || '[]') }} catch {{ return [] }}",
            timeout=_ANSWER,
        )
    except TimeoutError:
        return []
    return [one for one in found if isinstance(one, str)][:_MOST] if isinstance(found, list) else []


def _text(path: Path) -> str:
    return json.dumps(str(path)).replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
