"""Who may talk to the server: a token in the address that is printed, a cookie from then on."""

from __future__ import annotations

import hashlib
import hmac
import os
import secrets
import stat
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

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
        found = file.lstat()
    except FileNotFoundError:
        return None
    open_to_others = os.name == "posix" and (found.st_mode & 0o077 or found.st_uid != os.getuid())
    if not stat.S_ISREG(found.st_mode) or open_to_others or found.st_size != _KEY_BYTES:
        return None
    return file.read_bytes()
