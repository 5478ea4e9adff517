"""Seals: what a browser gives back of a file of this machine counts only as this server has written it."""

from __future__ import annotations

import hashlib
import hmac
import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

# The key; the server gives the one of the user's state folder, which holds after a restart.
_key = [secrets.token_bytes(32)]
_SEALED = ("file", "trusted", "digest")


@dataclass(frozen=True, slots=True, kw_only=True)
class SealedFile:
    """The file of a state that a browser kept.  digest : of its content when it was read or written."""

    path: Path
    trusted: bool
    digest: str


def set_seal_key(key: bytes) -> None:
    """Seal by this key from now on."""
    _key[0] = key


def seal_of(state: str, file: Mapping[str, object]) -> str:
    """The seal of a state's text with its file: neither counts beside another one."""
    content = json.dumps([state, *(file.get(name) for name in _SEALED)], ensure_ascii=True)
    return hmac.new(_key[0], content.encode(), hashlib.sha256).hexdigest()


def file_of(state: str, snapshot: Mapping[str, object]) -> SealedFile | None:
    """The file of a snapshot with that state; None where its seal is not valid, or there is none."""
    seal, name, trusted, digest = (snapshot.get(key) for key in ("seal", *_SEALED))
    if not (isinstance(seal, str) and isinstance(name, str) and isinstance(trusted, bool) and isinstance(digest, str)):
        return None
    try:
        expected = seal_of(state, snapshot)
    except (UnicodeEncodeError, ValueError):
        return None
    if not hmac.compare_digest(seal.encode("utf-8", "replace"), expected.encode()):
        return None
    return SealedFile(path=Path(name), trusted=trusted, digest=digest)
