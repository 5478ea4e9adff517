"""Undo and redo over states, a drag being one step; a state as a command line, a script, the fragment of a link.

Seals: what a browser gives back of a file of this machine counts only as this server has written it.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import json
import secrets
import shlex
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from pprint import pformat
from typing import NamedTuple

from ...document.document import file_text, ready_drives
from ...document.overrides import parse_setting
from ...document.tables import value_text
from ...errors import ModelError
from .state import PageState, at_speed, from_text, opened, request_of, with_values

# Steps kept: more than anybody takes back, some kB each since the model text is shared.
_MOST = 300


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A state, None of a page without a model; what led to it, and the key under which changes that follow are one."""

    state: PageState | None = None
    label: str = ""
    key: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class StateHistory:
    """Steps behind, the present one, and those taken back, the next one first."""

    now: Step = field(default_factory=Step)
    behind: tuple[Step, ...] = ()
    ahead: tuple[Step, ...] = ()

    @property
    def present(self) -> PageState | None:
        return self.now.state

    @property
    def undo_label(self) -> str:
        """What undo takes back; empty where there is nothing."""
        return self.now.label if self.behind else ""

    @property
    def redo_label(self) -> str:
        """What redo does again; empty where there is nothing."""
        return self.ahead[0].label if self.ahead else ""

    def push(self, state: PageState, label: str, key: str | None = None) -> StateHistory:
        """The history with a new state; one of the same key as the last replaces it, an equal one changes nothing."""
        if state == self.present:
            return self
        step = Step(state=state, label=label, key=key)
        if key is not None and key == self.now.key and self.behind:
            return replace(self, now=step, ahead=())
        return StateHistory(now=step, behind=(*self.behind, self.now)[-_MOST:])

    def closed(self) -> StateHistory:
        """The history whose next change is a step of its own, whatever its key: a drag has ended."""
        return self if self.now.key is None else replace(self, now=replace(self.now, key=None))

    def undo(self) -> StateHistory:
        if not self.behind:
            return self
        return StateHistory(now=self.behind[-1], behind=self.behind[:-1], ahead=(self.now, *self.ahead)).closed()

    def redo(self) -> StateHistory:
        if not self.ahead:
            return self
        return StateHistory(now=self.ahead[0], behind=(*self.behind, self.now), ahead=self.ahead[1:]).closed()

    def with_file(self, before: PageState, saved: PageState) -> StateHistory:
        """The history after a state was written to a file: that is the file of all steps of the same model."""

        def step(past: Step) -> Step:
            if past.state is None or past.state == saved or past.state.origin != before.origin:
                return past
            if past.state == before:
                return replace(past, state=saved)
            file = replace(past.state, path=saved.path, name=saved.name, drive=None, trusted=saved.trusted)
            return replace(past, state=file)

        return StateHistory(
            now=step(self.now), behind=tuple(map(step, self.behind)), ahead=tuple(map(step, self.ahead))
        )


def setting(path: str, value: object) -> str:
    """``PATH=VALUE`` as `--set` takes it: a text that would be read as another value is quoted."""
    if value is None:
        return f"{path}="
    if isinstance(value, str) and value.strip() and parse_setting(f"{path}={value}") == (path, value):
        return f"{path}={value}"
    return f"{path}={value_text(value)}"


def command_line(state: PageState, verb: str = "report") -> str:
    """The command that computes the same from the ready drive, the file, or a download of it."""
    words = ["epicyclic", verb.replace("_", "-"), _source(state)]
    for path, value in state.overrides.items():
        words += ["--set", setting(path, value)]
    return shlex.join(words)


def script(state: PageState) -> str:
    """A Python script that loads the same train and prints what the page answers."""
    overrides = pformat(dict(state.overrides), sort_dicts=False, width=100)
    given = f", overrides={overrides}" if state.overrides else ""
    note = f"# download the model as {file_name_of(state)} beside this script\n" if download_needed(state) else ""
    return (
        f"{note}import epicyclic\n\n"
        f"train = epicyclic.load({_source(state)!r}{given})\n"
        "system = epicyclic.assemble(train)\n\n"
        "for verb in (epicyclic.modes, epicyclic.sharing, epicyclic.sweep):\n"
        "    name = verb.__name__\n"
        "    try:\n"
        "        result = verb(system)\n"
        "    except epicyclic.ModelError as error:  # what the model does not state\n"
        '        print(f"no {name}: {error}")\n'
        "        continue\n"
        '    epicyclic.save_result(result, f"{name}.nc")  # epicyclic show modes.nc draws it\n'
        '    print(f"{name}.nc written")\n'
        '    if name == "modes":\n'
        "        print(result.frequency.to_series().to_string())\n"
    )


def file_name_of(state: PageState, suffix: str = ".toml") -> str:
    """A file name for a download of the state: letters, digits, dot, dash and underscore of its name."""
    stem = state.name.removesuffix(".toml")
    plain = "".join(letter if letter.isalnum() or letter in "-_." else "-" for letter in stem).strip("-.")
    return f"{plain or 'model'}{suffix}"


def download_needed(state: PageState) -> bool:
    """Whether neither a ready drive nor the file of the state holds its text: what replays it needs a download."""
    if state.drive is not None:
        return False
    try:
        return state.path is None or file_text(state.path) != state.base
    except ModelError:
        return True


def _source(state: PageState) -> str:
    if state.drive is not None:
        return state.drive
    return file_name_of(state) if download_needed(state) or state.path is None else str(state.path)


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


# The key; the server gives the one of the user's state folder, which holds after a restart.
_key = [secrets.token_bytes(32)]
_SEALED = ("file", "trusted", "digest")


class SealedFile(NamedTuple):
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
