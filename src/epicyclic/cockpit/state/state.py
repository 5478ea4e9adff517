"""The state of a page: a model text, what overrides change in it, and where it came from.

Undo and redo over states, a drag being one step; a state as a command line, a script, the fragment of a link.
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
from functools import lru_cache, partial
from pathlib import Path
from pprint import pformat
from typing import Any, NamedTuple

from ...document.document import MAX_BYTES, at_files, decoded, drive_text, file_text, parse_text, ready_drives
from ...document.overrides import parse_setting
from ...document.schema import collect
from ...document.tables import PlainTable, clean, expand, keyed, nested, split_path, value_at, value_text
from ...errors import ModelError
from ...rexs.file import is_rexs_name

Keys = tuple[str, ...]


class Spelling:
    """The keys of the tables of a model text.

    names : of its stages, members and bodies.  written : value by key, as the text has them.
    places : of each key, where in the document it stands.  key_of : the key that gives a place.
    """

    def __init__(self, tables: PlainTable) -> None:
        self.names, self.written = collect(tables), dict(keyed(tables))
        self.places = {keys: self.places_of(keys, value) for keys, value in self.written.items()}
        self.key_of = {place: keys for keys, several in self.places.items() for place in several}

    def places_of(self, keys: Keys, value: object) -> frozenset[Keys]:
        """Places of the document that a key with that value gives; the key itself where its value is of a wrong form,
        which validation names."""
        try:
            return frozenset(found for found, _ in keyed(expand(nested(keys, value), self.names)))
        except (ModelError, AttributeError, TypeError):
            return frozenset((keys,))

    def same(self, keys: Keys, value: object) -> Keys | None:
        """The key of the text that gives exactly the places of this one; None where there is none."""
        places = self.places_of(keys, value)
        keys_of_places = {self.key_of.get(place) for place in places}
        key = next(iter(keys_of_places)) if len(keys_of_places) == 1 else None
        return key if key is not None and self.places[key] == places else None


_NO_FILES = "numbers: a model of this page may name no file"
# Characters of a name in the header and of a download: longer ones push the controls away.
_MOST_NAME = 80
# Overrides of one state: what a person sets by hand, with room; a hostile link may hold more.
_MOST_OVERRIDES = 2000
# Speeds per operating speed that a page shows: no sweep of the package goes beyond.
_SPEEDS = (1e-3, 100.0)
_REASON = "assumed."


Origin = tuple[Path | None, str | None, str]
"""Model file by what it is of: path, ready drive and name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PageState:
    """What a page shows.

    name : of the header.  base : text of the model file (TOML).
    overrides : values by path, in the order in which they were set, as `load` takes them.
    drive : the ready drive whose text `base` is, if it is one.
    path : file of this machine, opened by the command line or written by save as; never from a link or an upload.
    trusted : whether the model may name files beside `path`.
    relative_speed : speed that is shown, per operating speed [1]; the model stays as it is.
    opening : number of the opening of the model, which edits of it keep: two files of one name are two models.
    """

    name: str
    base: str
    overrides: Mapping[str, object] = field(default_factory=dict)
    drive: str | None = None
    path: Path | None = None
    trusted: bool = False
    relative_speed: float = 1.0
    opening: int = field(default=0, compare=False)

    @property
    def origin(self) -> Origin:
        """Model file that it is of: path, ready drive and name."""
        return self.path, self.drive, self.name


def opened(source: str | Path) -> PageState:
    """The state of a ready drive, a model file or a REXS file of this machine.

    Raises
    ------
    ModelError : it cannot be read; it is no TOML and no REXS file.
    """
    if isinstance(source, str) and source in ready_drives():
        return PageState(name=source, base=drive_text(source), drive=source)
    path = Path(source)
    if is_rexs_name(path):
        return PageState(name=_short(path.stem), base=_rexs_text(path, path.name))
    text = file_text(path)
    parse_text(text, str(path))
    return PageState(name=_short(path.name), base=text, path=path.absolute(), trusted=True)


def _rexs_text(source: Path | bytes, name: str) -> str:
    from ...rexs.export import rexs_model_text
    from ...rexs.import_train import read_rexs

    return rexs_model_text(read_rexs(source), name)


def uploaded(name: str, content: bytes) -> PageState:
    """The state of a file that a browser sent: a model file or a REXS file, which may name no file.

    Raises
    ------
    ModelError : too large, no TOML and no REXS file, or it names a file.
    """
    short = _short(name)
    if len(content) > MAX_BYTES:
        raise ModelError("too large", path=short, given=f"{len(content)} bytes", allowed=f"at most {MAX_BYTES} bytes")
    if is_rexs_name(name):
        return PageState(name=short, base=_rexs_text(content, short))
    return from_text(short, decoded(content, short))


def from_text(name: str, text: str) -> PageState:
    """The state of a model text of anybody: it may name no file.

    Raises
    ------
    ModelError : no TOML, too large, or it names a file.
    """
    short = _short(name)
    if len(text.encode("utf-8", "replace")) > MAX_BYTES:
        raise ModelError("too large", path=short, allowed=f"at most {MAX_BYTES} bytes")
    state = PageState(name=short, base=text)
    request_of(state)
    return state


def with_value(state: PageState, path: str, value: object) -> PageState:
    """The state with one value set; None removes the key, the value of the file removes the override."""
    return with_values(state, {path: value})


def with_values(state: PageState, values: Mapping[str, object]) -> PageState:
    """The state with values set by path, the newest last; an override of the same places in another spelling goes.

    Raises
    ------
    ModelError : too many overrides; a value that no model file holds.
    """
    overrides, spelling = dict(state.overrides), text_spelling(state.base, state.name)
    for path, value in values.items():
        keys = split_path(path, path=path)
        for other in [other for other in overrides if other.startswith(_REASON) and other not in values]:
            of = split_path(other, path=other)[1:]  # what is set now is not assumed any more
            if spelling.places_of(tuple(".".join(of).split(".")), value) == spelling.places_of(keys, value):
                del overrides[other]
        _set(overrides, path, keys, value if value is None else clean(value, path), spelling)
    if len(overrides) > _MOST_OVERRIDES:
        raise ModelError("too many", path="overrides", given=len(overrides), allowed=f"at most {_MOST_OVERRIDES}")
    return replace(state, overrides=overrides)


def _set(overrides: dict[str, object], path: str, keys: Keys, value: object, spelling: Spelling) -> None:
    """Lay one value over others: it takes the place of what stood there, above it and below it."""
    places, removed_above = spelling.places_of(keys, value), False
    for other, given in list(overrides.items()):
        others = split_path(other, path=other)
        above = others == keys[: len(others)] and others != keys
        if above and value is not None and isinstance(given, Mapping):
            overrides[other] = _with(given, keys[len(others) :], value)
            return
        removed_above |= above and given is None
        below = others[: len(keys)] == keys and not (
            isinstance(value, Mapping) and value_at(value, others[len(keys) :]) is None
        )
        if others == keys or below or spelling.places_of(others, given) == places:
            del overrides[other]
    key = spelling.same(keys, value)
    in_file = key is not None or any(stated[: len(keys)] == keys for stated in spelling.written)
    if removed_above:
        if value is not None:
            overrides[path] = value
    elif in_file if value is None else key is None or spelling.written[key] != value:
        overrides[path] = value


def _with(table: Mapping[str, object], keys: Keys, value: object) -> dict[str, object]:
    """A table with a value set in it."""
    first, *rest = keys
    below = table.get(first)
    inner = _with(below if isinstance(below, Mapping) else {}, tuple(rest), value) if rest else value
    return {**table, first: inner}


@lru_cache(maxsize=16)
def text_spelling(text: str, name: str) -> Spelling:
    return Spelling(tables_of(text, name))


def with_text(state: PageState, text: str) -> PageState:
    """The state with another model text and no overrides; it stays beside its file.

    Raises
    ------
    ModelError : no TOML, or it names a file that it may not.
    """
    changed = replace(state, base=text, overrides={}, drive=None)
    request_of(changed)
    return changed


def at_speed(state: PageState, relative_speed: float) -> PageState:
    """The state shown at another speed, per operating speed, kept within what any analysis goes to."""
    least, most = _SPEEDS
    return replace(state, relative_speed=min(max(float(relative_speed), least), most))


def request_of(state: PageState) -> tuple[PlainTable, dict[str, object]]:
    """What `load` takes: nested tables and overrides, plain and picklable.  Names of files become whole paths.

    Raises
    ------
    ModelError : the text is no TOML; it names a file and may not.
    """
    folder = state.path.parent if state.trusted and state.path is not None else None
    tables = _placed(tables_of(state.base, state.name), folder)
    overrides = {}
    for path, value in state.overrides.items():
        keys = split_path(path, path=path)
        # refused here where it names a file and may not
        overrides[path] = value_at(_placed(nested(keys, value), folder), keys)
    return tables, overrides


@lru_cache(maxsize=64)
def tables_of(text: str, name: str = "model") -> PlainTable:
    """The tables of a model text; they are shared, so nobody changes them.

    Raises
    ------
    ModelError : no TOML.
    """
    return parse_text(text, name)


def _placed(tables: PlainTable, folder: Path | None) -> PlainTable:
    """Tables whose names of files are whole paths.

    Raises
    ------
    ModelError : a file is named and there is no folder, or it lies outside of it.
    """

    def whole(table: PlainTable, path: str) -> PlainTable:
        return {**table, "file": _file(table["file"], f"{path}.file", folder)}

    named = partial(_file, folder=folder)
    return at_files(tables, forces=whole, torques=whole, pitches=named, bodies=named)


def _file(name: str, path: str, folder: Path | None) -> str:
    if folder is None:
        raise ModelError("names a file", path=path, given=name[:_MOST_NAME], allowed=_NO_FILES)
    return str(folder / name)


def _short(name: str) -> str:
    """A name without folders and control characters, short enough for a header."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    plain = "".join(letter for letter in last if letter.isprintable()).strip(" .")
    return plain[:_MOST_NAME] or "model"


# history --------------------------------------------------------------------------------------------------------------

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

        behind, ahead = tuple(map(step, self.behind)), tuple(map(step, self.ahead))
        return StateHistory(now=step(self.now), behind=behind, ahead=ahead)


# links ----------------------------------------------------------------------------------------------------------------


def setting(path: str, value: object) -> str:
    """``PATH=VALUE`` as `--set` takes it."""
    return f"{path}={'' if value is None else typed_text(path, value)}"


def typed_text(path: str, value: object) -> str:
    """A value as a person types it, so that `--set` gives it back: a text without quotes where that is clear."""
    if isinstance(value, str) and parse_setting(f"{path}={value}")[1] == value:
        return value
    return value_text(value)


def command_line(state: PageState, verb: str = "report", keywords: Mapping[str, Any] | None = None) -> str:
    """The command that computes the same from the ready drive, the file, or a download of it.

    keywords : of the verb, those that are chosen.
    """
    words = ["epicyclic", verb.replace("_", "-"), _source(state)]
    if keywords:
        from ...verbs.record import command_words, verbs
        from ...verbs.record import keywords as known

        words += command_words(known(verbs()[verb].run), keywords)
    for path, value in state.overrides.items():
        words += ["--case", str(value)] if path == "case" and value else ["--set", setting(path, value)]
    return shlex.join(words)


def script(state: PageState) -> str:
    """A Python script that loads the same train and prints what the page answers."""
    return _loading(state) + (
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


def verb_script(state: PageState, verb: str, keywords: Mapping[str, Any]) -> str:
    """A Python script that runs one verb of the same train, keeps its result, and prints what that means."""
    chosen = "".join(f"    {name}={value!r},\n" for name, value in keywords.items())
    file = file_name_of(state, f"-{verb}.nc")
    return _loading(state, "from epicyclic.show.views import findings_of\n", f"result = epicyclic.{verb}", chosen) + (
        f"epicyclic.save_result(result, {file!r})  # epicyclic show {file} prints its tables\n"
        'for finding in findings_of({"": result}):\n'
        "    print(finding.text, finding.change)\n"
    )


def _loading(state: PageState, imports: str = "", call: str = "train = epicyclic.load", keywords: str = "") -> str:
    """Lines of a script that call a function with the model of a state, and keywords, a line each."""
    overrides = pformat(dict(state.overrides), sort_dicts=False, width=100)
    given = f", overrides={overrides}" if state.overrides else ""
    further = f",\n{keywords}" if keywords else ""
    note = f"# download the model as {file_name_of(state)} beside this script\n" if download_needed(state) else ""
    return f"{note}import epicyclic\n{imports}\n{call}({_source(state)!r}{given}{further})\n"


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
    overrides = [[path, value] for path, value in state.overrides.items()]
    content: dict[str, object] = {"name": state.name, "overrides": overrides}
    if state.relative_speed != 1.0:
        content["speed"] = state.relative_speed
    content |= {"drive": state.drive} if state.drive is not None else {"base": state.base}
    packed = zlib.compress(json.dumps(content, ensure_ascii=False, separators=(",", ":")).encode(), 9)
    return _PREFIX + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def from_fragment(text: str, *, most: int | None = MOST_LINK, file: SealedFile | None = None) -> PageState:
    """The state of a fragment of anybody; it names no file of this machine.

    most : characters that it may have; None: as many as unpack to `_MOST_UNPACKED`.
    file : of the state, where the server itself has sealed it.

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
        sealed = None if file is None else PageState(name=name, base=base, path=file.path, trusted=file.trusted)
        state = from_text(name, base) if sealed is None else sealed
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
