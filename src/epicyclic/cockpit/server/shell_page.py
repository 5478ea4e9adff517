"""Two pages without a state: the one that a link from elsewhere meets, and the one without a pass."""

from __future__ import annotations

import base64
import hashlib
import html

__all__ = ["MARK", "SHELL", "SHELL_POLICY", "refusal"]

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
