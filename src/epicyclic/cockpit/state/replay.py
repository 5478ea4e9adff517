"""A state as a command line and as a Python script that give the same numbers."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pprint import pformat

from ...document.document import file_text
from ...document.overrides import parse_setting
from ...document.tables import value_text
from ...errors import ModelError
from .state import PageState

__all__ = ["command_line", "download_needed", "file_name_of", "script", "setting"]


def setting(path: str, value: object) -> str:
    """``PATH=VALUE`` as `--set` takes it: a text that would be read as another value is quoted."""
    if value is None:
        return f"{path}="
    if isinstance(value, str) and value.strip() and parse_setting(f"{path}={value}") == (path, value):
        return f"{path}={value}"
    return f"{path}={value_text(value)}"


def command_line(state: PageState, verb: str = "report", options: Mapping[str, object] | None = None) -> str:
    """The command that computes the same from the ready drive, the file, or a download of it.

    verb : a command.  options : further ones by their names without dashes; None is left out.
    """
    words = ["epicyclic", verb.replace("_", "-"), _source(state)]
    for name, value in (options or {}).items():
        if value is not None and value is not False:
            words += [f"--{name}"] if value is True else [f"--{name}", str(value)]
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
