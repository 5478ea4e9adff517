"""Help of the program: every command in one line, below the question that it answers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import typer
from typer.core import TyperGroup

__all__ = ["PANELS", "Panels", "panel_of"]

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
