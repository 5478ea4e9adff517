"""A state as the fragment of a link, which no server sees, and back."""

from __future__ import annotations

import base64
import binascii
import json
import zlib
from collections.abc import Mapping
from pathlib import Path

from ...document.document import ready_drives
from ...errors import ModelError
from .state import PageState, at_speed, from_text, opened, request_of, with_values

__all__ = ["MOST_LINK", "fragment_of", "from_fragment", "snapshot_text"]

MOST_LINK = 64_000
"""Characters of a fragment: browsers and mail programs take as many."""
# Bytes of what a fragment holds, unpacked: a long model file has 30 kB.
_MOST_UNPACKED = 1_000_000
_PREFIX = "state="


def fragment_of(state: PageState) -> str:
    """The fragment ``state=...`` of a link that opens the state anew: ready drives by name, else the whole text.

    Raises
    ------
    ModelError : it is too long for a link.
    """
    text = snapshot_text(state)
    if len(text) > MOST_LINK:
        allowed = f"at most {MOST_LINK}: download the model file instead"
        raise ModelError("too long for a link", path="link", given=f"{len(text)} characters", allowed=allowed)
    return text


def snapshot_text(state: PageState) -> str:
    """The same of any length, for the browser to keep."""
    content: dict[str, object] = {
        "name": state.name,
        "overrides": [[path, one] for path, one in state.overrides.items()],
    }
    if state.relative_speed != 1.0:
        content["speed"] = state.relative_speed
    content |= {"drive": state.drive} if state.drive is not None else {"base": state.base}
    packed = zlib.compress(json.dumps(content, ensure_ascii=False, separators=(",", ":")).encode(), 9)
    return _PREFIX + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def from_fragment(text: str, *, most: int | None = MOST_LINK, file: tuple[Path, bool] | None = None) -> PageState:
    """The state of a fragment of anybody; it names no file of this machine.

    most : characters that it may have; None: as many as unpack to `_MOST_UNPACKED`.
    file : of the state and whether it may name others beside it, where the server itself has sealed both.

    Raises
    ------
    ModelError : no link of this program, too long, or its model cannot be one.
    """
    content = _unpacked(text, _MOST_UNPACKED if most is None else most)
    pairs, drive, base = content.get("overrides", []), content.get("drive"), content.get("base")
    overrides: dict[str, object] = {}
    for pair in pairs if isinstance(pairs, list) else [None]:
        if not (isinstance(pair, list) and len(pair) == 2 and isinstance(pair[0], str)):
            raise _damaged("overrides that are no pairs")
        overrides[pair[0]] = pair[1]
    if isinstance(drive, str) and drive in ready_drives():
        state = opened(drive)
    elif isinstance(base, str):
        name = str(content.get("name", ""))
        state = (
            from_text(name, base) if file is None else PageState(name=name, base=base, path=file[0], trusted=file[1])
        )
    else:
        raise _damaged("neither a ready drive nor a model")
    speed = content.get("speed", 1.0)
    if isinstance(speed, bool) or not isinstance(speed, int | float):
        raise _damaged("a speed that is no number")
    state = at_speed(with_values(state, overrides), speed)
    request_of(state)  # overrides may name no file either
    return state


def _unpacked(text: str, most: int) -> Mapping[str, object]:
    body = text.removeprefix("#").removeprefix(_PREFIX)
    if len(body) > most:
        raise ModelError("too long", path="link", given=f"{len(body)} characters", allowed=f"at most {most}")
    try:
        packed = base64.b64decode(body + "=" * (-len(body) % 4), altchars=b"-_", validate=True)
        unpack = zlib.decompressobj()
        raw = unpack.decompress(packed, _MOST_UNPACKED)
        if unpack.unconsumed_tail or not unpack.eof:
            raise _damaged("cut off, or too large when unpacked")
        content = json.loads(raw)
    except (binascii.Error, zlib.error, ValueError, RecursionError) as error:
        if isinstance(error, ModelError):
            raise
        raise _damaged(type(error).__name__) from None
    if not isinstance(content, dict):
        raise _damaged("no table")
    return content


def _damaged(how: str) -> ModelError:
    return ModelError(f"no link of this page ({how})", path="link", allowed="a link copied from this page, whole")
