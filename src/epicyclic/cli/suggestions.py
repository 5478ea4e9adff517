"""Nearest command, option or word for one that is not there: the last line of an error says what was likely meant."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from typer.core import TyperGroup

from .console import help_on_stdout
from .panels import Panels

__all__ = ["Commands"]

_TYPED = "epicyclic.typed"
_NO_COMMAND = re.compile(r"No such command '(.*?)'\.?", re.DOTALL)
_NO_WORD = re.compile(r"'?([^']*)'? is not one of (.*?)\.?$", re.DOTALL)


class Commands(Panels):
    """The commands of the program; an error of one that is not there, or of its options, names the nearest."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options before the command."""
        ctx.meta[_TYPED] = list(args)
        return list(_told(lambda: super(Commands, self).parse_args(ctx, args), self, ctx))

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        return _told(lambda: super(Commands, self).invoke(ctx), self, ctx)


def _told(run: Any, group: TyperGroup, ctx: Any) -> Any:
    """Run a function; errors of names that are not there get the nearest ones.

    The classes of the errors are of click or of typer's own copy of it: they are known by what they hold.
    """
    try:
        with help_on_stdout():
            return run()
    except Exception as error:
        if hasattr(error, "message") and hasattr(error, "ctx"):
            typed = ctx.meta.get(_TYPED, [])
            if hasattr(error, "option_name") and hasattr(error, "possibilities"):
                error.message, error.possibilities = _option(error, group, ctx, typed), None
            elif found := _NO_COMMAND.match(str(error.message)):
                error.message = _command(found[1], group)
            elif found := _NO_WORD.search(str(error.message)):
                words = re.findall(r"'([^']*)'", found[2])
                text = str(error.message).removeprefix("Value error, ").rstrip(".")
                error.message = f"{text}{_nearest(found[1], words)}"
        raise


def _option(error: Any, group: TyperGroup, ctx: Any, typed: list[str]) -> str:
    """Message of an option that is not there: the nearest of its command, or of which commands it is."""
    words = [word.split("=")[0] for word in typed]
    # of -damped the parser reads -d alone
    name = next((word for word in words if word.startswith(error.option_name)), error.option_name)
    command = (error.ctx or ctx).command
    if command is not group:
        return f"no such option {name}{_nearest(name, _options(command))}"
    others = [own for own, one in group.commands.items() if name in _options(one)]
    if others:
        own = next((word for word in words if word in others), others[0])
        return f"{name} stands behind the command: epicyclic {own} ... {name}"
    return f"no such option {name}{_nearest(name, _options(group))}"


def _command(name: str, group: TyperGroup) -> str:
    """Message of a command that is not there."""
    from ..document.document import ready_drives

    known = [own for own, one in group.commands.items() if not getattr(one, "hidden", False)]
    if name in ready_drives() or name.endswith((".toml", ".rexs", ".rexsj", ".rexsz")):
        return f"no such command '{name}'; a model stands behind the command: epicyclic check {name}"
    return f"no such command '{name}'{_nearest(name, known)}"


def _options(command: Any) -> list[str]:
    """Names of the options of a command, those that its help shows."""
    shown = [one for one in command.params if getattr(one, "param_type_name", "") == "option" and not one.hidden]
    return [name for one in shown for name in (*one.opts, *one.secondary_opts)]


def _nearest(word: str, known: Iterable[str]) -> str:
    """``; did you mean '--damped'?``, or nothing; dashes and underscores count as the same."""
    from ..document.schema import nearest

    plain = {_plain(name): name for name in known}
    found = re.search(r"'(.*)'", nearest(_plain(word), plain))
    return f"; did you mean '{plain[found[1]]}'?" if found else ""


def _plain(name: str) -> str:
    return name.lstrip("-").replace("_", "-").lower()
