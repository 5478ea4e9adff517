"""Help of the program by question, completion in the shell, and the nearest word for one that is not there."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from .console import help_on_stdout

PANELS: Mapping[str, Mapping[str, str]] = {
    "Where do I begin?": {
        "new": "Write a model file from teeth or ratio, power and speed.",
        "app": "A page on this machine: sliders, and a train that answers.",
        "import": "Write a model file from a REXS file.",
        "systems": "The ready drives: names that stand for a model file.",
        "explain": "What a key, a variable or a warning means.",
        "schema": "The JSON Schema of the model file, for editors.",
    },
    "What does the drawing say?": {
        "check": "Ratio, speeds, torques, mesh frequencies, assembly; all values by --all.",
        "compare": "What differs between trains, and what it does.",
        "audit": "Published numbers of the ready drives beside ours.",
    },
    "How does it vibrate?": {
        "modes": "Natural frequencies, kinds of modes, resonances near operation.",
        "campbell": "Natural frequencies over speed.",
        "steady": "Steady vibration at one speed: mesh and bearing forces, K_v.",
        "sweep": "Steady vibration over speed; --contact-loss lets teeth part.",
        "stability": "Parametric stability over speed, or a map over two numbers.",
        "transient": "Motion in time: start-up, torque steps, ramps.",
        "modulation": "What an accelerometer on the ring sees as planets pass.",
    },
    "How do planets share the load?": {
        "static": "Equilibrium under load, with teeth in contact or apart.",
        "sharing": "Load-sharing coefficients by definition.",
        "tolerance": "K_gamma as a distribution, from the tolerances of the drawing.",
    },
    "How do the teeth carry it?": {
        "stiffness": "Mesh stiffness over the mesh cycle.",
        "contact": "Load over the flanks, transmission error, stress of one pair.",
        "train-contact": "The same of all meshes at once, with float and tilt.",
        "efficiency": "Power lost in the meshes, efficiency, self-locking.",
    },
    "Which number do I change?": {
        "sensitivity": "Which number moves frequencies or forces most.",
        "track": "Modes along a number: crossings and veerings.",
        "allocate": "The cheapest grades that keep K_gamma below a target.",
        "relief": "Tip relief and lead modification that are best.",
    },
    "How do I take it away?": {
        "report": "Everything in one HTML file that opens offline.",
        "study": "A verb over many points, from a job file.",
        "show": "Tables and figures of a saved result again.",
        "matrices": "The linear system M, C, G, K as .mat or .npz.",
        "export": "A REXS file of a train.",
    },
}
"""Question -> command -> what it does in a line; commands that are not there are left out."""


def panel_of(name: str) -> str:
    """The question that a command answers; "" of one that stands below none."""
    return next((question for question, names in PANELS.items() if name in names), "")


class Panels(TyperGroup):
    """The commands of the program; its help is one screen."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write usage, commands by question, options."""
        shown = {name: one for name, one in self.commands.items() if not getattr(one, "hidden", False)}
        width = max(map(len, shown), default=0) + 2
        lines = [self.help or "", "Usage: epicyclic COMMAND [MODEL] [OPTIONS]; epicyclic COMMAND --help tells more."]
        for question, names in PANELS.items():
            own = {name: words for name, words in names.items() if name in shown}
            lines += [typer.style(question, bold=True)] if own else []
            lines += [_line(name, words, width) for name, words in own.items()]
        rest = [name for name in shown if not panel_of(name)]
        lines += [typer.style("Further", bold=True)] if rest else []
        lines += [_line(name, shown[name].get_short_help_str(60), width) for name in rest]
        lines.append(typer.style("Options", bold=True))
        for parameter in self.get_params(ctx):
            words = getattr(parameter, "help", None)
            if words:
                lines.append(_line(", ".join(parameter.opts), words.split(",")[0].rstrip("."), max(width, 20)))
        formatter.write("\n".join(lines) + "\n")


def _line(name: str, words: str, width: int) -> str:
    return f"  {typer.style(name, fg=typer.colors.CYAN)}{' ' * (width - len(name))}{words}"


_MODELS = (".toml", ".rexs", ".rexsj", ".rexsz")
_RESULTS = (".nc", ".json")
# folder of the ready drives: reading its names must not import the model, which takes longer than a key stroke
_DRIVES = Path(__file__).parents[1] / "systems"


def model_names(incomplete: str) -> list[str]:
    """Ready drives, model files and folders that begin with what is typed; none where a folder cannot be read."""
    return _names(incomplete, _MODELS)


def source_names(incomplete: str) -> list[str]:
    """The same and saved results."""
    return _names(incomplete, (*_MODELS, *_RESULTS))


def explained_names(incomplete: str) -> list[str]:
    """Codes of warnings and variables of results that begin with what is typed."""
    from ..results.variables import VARIABLES
    from ..warning_codes import WARNING_CODES

    return [name for name in (*WARNING_CODES, *VARIABLES) if name.startswith(incomplete)]


def _names(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    try:
        drives = sorted(path.stem for path in _DRIVES.glob("*.toml") if "." not in path.stem)
        return [*(name for name in drives if name.startswith(incomplete)), *_files(incomplete, suffixes)]
    except (OSError, ValueError, RuntimeError):  # a folder that cannot be read, a name with a zero byte, no such home
        return []


def _files(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    """Files and folders below the folder that is typed; hidden ones where a point is typed."""
    head, begin = os.path.split(incomplete)
    folder = Path(head).expanduser() if head else Path()
    found = []
    for entry in sorted(os.scandir(folder), key=lambda entry: entry.name):
        hidden = entry.name.startswith(".") and not begin.startswith(".")
        if hidden or not entry.name.startswith(begin):
            continue
        name = os.path.join(head, entry.name)  # as it is typed: ~ and ./ stay
        if entry.is_dir():
            found.append(f"{name}/")
        elif entry.name.lower().endswith(suffixes):
            found.append(name)
    return found


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
