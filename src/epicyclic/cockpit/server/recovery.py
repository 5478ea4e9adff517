"""What a tab keeps of its state in the browser: it comes back after a reload and after a restart of the server."""

from __future__ import annotations

from pathlib import Path

__all__ = ["KEEP_SECONDS", "MOST_KEPT", "recovery_script"]

# [s] between two writings: a drag has one, not one for each move
KEEP_SECONDS = 0.4
# [byte] of an entry: browsers give a site about 5 MB, of UTF-16
MOST_KEPT = 1_000_000


def recovery_script() -> str:
    """``window.cockpitRecovery`` as an element of the page: begin, keep, take, drop."""
    return f"<script>{Path(__file__).with_name('recovery.js').read_text(encoding='utf-8')}</script>"
