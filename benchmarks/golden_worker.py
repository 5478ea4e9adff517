"""What people see of one drive, as text files: one process of `golden.py`, with PYTHONPATH at a checkout.

    python golden_worker.py DRIVE FOLDER [--only check,modes]

Written below FOLDER: what each command prints (``modes.txt``), its tables (as CSV, and the cells of XLSX), the
data of each figure (``modes.frequencies.figure.txt``: names, units, numbers of every trace and axis), the text of the
report and the frames of the page.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

FIRST = "(first mesh)"
# verb -> arguments behind the model; each is as short as shows every table and figure
COMMANDS: dict[str, tuple[str, ...]] = {
    "check": ("check", "--all"),
    "modes": ("modes",),
    "modes-damped": ("modes", "--damped", "--relative-speed", "0.7"),
    "campbell": ("campbell",),
    "static": ("static", "--cycles", "2", "--samples", "8"),
    "steady": ("steady",),
    "steady-contact-loss": ("steady", "--contact-loss"),
    "sweep": ("sweep", "--points", "15"),
    "sharing": ("sharing", "--cycles", "3"),
    "sharing-static": ("sharing", "--method", "static", "--cycles", "2"),
    "stability": ("stability", "--points", "3"),
    "transient": ("transient", "--cycles", "3"),
    "modulation": ("modulation",),
    "tolerance": ("tolerance", "--samples", "64", "--seed", "1"),
    "track": ("track", "--over", "stages.main.planet.bearing.radial", "--points", "5"),
    "allocate": ("allocate", "--target", "1.3", "--samples", "1024", "--fresh-samples", "1024"),
    "relief": (
        *("relief", "--vary", "tip_relief.amount=0..20um", "--vary", "tip_relief.length=0.2..0.8mm"),
        *("--population", "4", "--generations", "1"),
    ),
    "stiffness": ("stiffness",),
    "contact": ("contact", "--samples", "3", "--slices", "3"),
    "contact-mesh": ("contact", "--mesh", FIRST, "--samples", "8", "--slices", "5"),
    "efficiency": ("efficiency",),
    "sensitivity": ("sensitivity",),
    "matrices": ("matrices",),
    "audit": ("audit",),
}
# speed and torque of drives that state none
OPERATION = {
    "yue2014-i": ("operation.speed.sun=1000 rpm", "operation.torque.sun=43 N m"),
    "yue2014-ii": ("operation.speed.sun=1000 rpm", "operation.torque.sun=43 N m"),
    "yue2014-iii": ("operation.speed.ring=1000 rpm", "operation.torque.ring=43 N m"),
}
# not of one drive
DESK: dict[str, tuple[str, ...]] = {
    **{
        f"help-{verb}": (verb, "--help")
        for verb in (
            *("new", "app", "import", "systems", "explain", "schema", "check", "compare", "audit", "modes", "campbell"),
            *("steady", "sweep", "stability", "transient", "modulation", "static", "sharing", "tolerance", "stiffness"),
            *("contact", "efficiency", "sensitivity", "track", "allocate", "relief", "report"),
            *("study", "show", "matrices", "export"),
        )
    },
    "help": ("--help",),
    "systems": ("systems",),
    "schema": ("schema",),
    **{
        f"explain-{word}": ("explain", word)
        for word in ("K_v", "K_gamma", "mode_kind", "mesh_force_peak", "contact-loss", "tip_relief", "phase", "sweep")
    },
    "new-planetary": ("new", "a.toml", "--teeth", "21/39/99", "--power", "750 kW", "--speed", "1000 rpm"),
    "new-star": ("new", "b.toml", "--kind", "star", "--ratio", "4", "--torque", "2 N m", "--speed", "3000 rpm"),
    "check-new": ("check", "a.toml", "--all"),
    "report-new": ("report", "a.toml", "-o", "a.html"),
    "compare": ("compare", "ren2021", "wind-stage", "-o", "compare.nc"),
    "compare-with": ("compare", "ren2021", "--with", "stages.main.sun.support.radial=0", "-o", "compare-with.nc"),
    "export": ("export", "wind-stage", "-o", "w.rexs"),
    "import": ("import", "w.rexs", "-o", "w.toml"),
    "check-imported": ("check", "w.toml"),
    "no-such-command": ("mods",),
    "no-such-model": ("modes", "nothing.toml"),
    "no-such-path": ("modes", "ren2021", "--set", "stages.main.sun.massy=1 kg"),
    "wrong-unit": ("modes", "ren2021", "--set", "stages.main.sun.mass=1 mm"),
    "not-in-balance": ("static", "ren2021", "--set", "torque.sun=5 N m"),
}
# what differs between two runs of one program: dates, times, durations, versions, folders
MASKS = (
    (re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d+)?)?(Z|[+-]\d\d:\d\d)?"), "(time)"),
    (re.compile(r"\d{4}-\d\d-\d\d"), "(date)"),
    (re.compile(r"\b\d+\.\d+\.\d+(\.?(dev|rc|a|b|post)\d*)?(\+\w+)?\b"), "(version)"),
    (re.compile(r"\bin \d+(\.\d+)? (ms|s|min)\b"), "in (duration)"),
    (re.compile(r"(?<![\w)])(/[\w.+-]+){2,}/"), "(folder)/"),
    (re.compile(r"\b(?=\d*[a-f])[0-9a-f]{16,64}\b"), "(hash)"),
    (re.compile(r"((?:computed|live)_ms) [\d.e+-]+"), r"\1 (duration)"),
)


def main() -> None:
    """Write everything that is seen of one drive."""
    parser = argparse.ArgumentParser()
    parser.add_argument("drive")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="")
    given = parser.parse_args()
    os.chdir(given.folder)
    of_drive = list(DESK) if given.drive == "desk" else [*COMMANDS, "report", "page"]
    wanted = [name for name in of_drive if not given.only or name in given.only.split(",")]
    for name in wanted:
        if given.drive == "desk":
            show(name, DESK[name])
        elif name == "page":
            write("page.frames.txt", "\n".join(page_frames(given.drive)))
        elif name == "report":
            show("report", ("report", given.drive, "-o", "report.html"))
        else:
            verb, *rest = COMMANDS[name]
            rest = [first_mesh(given.drive) if word == FIRST else word for word in rest]
            sets = [word for text in OPERATION.get(given.drive, ()) for word in ("--set", text)]
            arguments = (given.drive,) if verb == "audit" else (given.drive, *rest, *sets)
            show(
                name, (verb, *arguments, *(("-o", f"{name}.nc") if verb not in ("check", "matrices", "audit") else ()))
            )
        for file in Path().glob("*.html"):
            write(f"{name}.text.txt", page_text(file.read_text(encoding="utf-8")))
            file.unlink()
        if Path(f"{name}.nc").exists():
            result_files(name)
            Path(f"{name}.nc").unlink()
        print(given.drive, name, file=sys.stderr, flush=True)


def first_mesh(drive: str) -> str:
    """Name of the first mesh of a drive, without the side."""
    import epicyclic

    return "/".join(epicyclic.load(drive).meshes[0].name.split("/")[:3])


def show(name: str, arguments: tuple[str, ...]) -> None:
    """What a command prints, and its exit status."""
    from epicyclic.__main__ import main as run

    out, err = io.StringIO(), io.StringIO()
    sys.argv = ["epicyclic", *arguments]
    status: object = 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            run()
        except SystemExit as end:
            status = end.code or 0
    write(f"{name}.txt", f"$ epicyclic {' '.join(arguments)}\n{out.getvalue()}\n-- {err.getvalue()}\nstatus {status}\n")


def result_files(name: str) -> None:
    """Tables of a saved result as CSV and XLSX, and the data of its figures."""
    import epicyclic

    result = epicyclic.load_result(f"{name}.nc")
    epicyclic.save_result(result, f"{name}.csv")
    write(f"{name}.csv.txt", Path(f"{name}.csv").read_text(encoding="utf-8"))
    Path(f"{name}.csv").unlink()
    epicyclic.save_result(result, f"{name}.xlsx")
    write(f"{name}.xlsx.txt", "\n".join(sheet_rows(Path(f"{name}.xlsx"))))
    Path(f"{name}.xlsx").unlink()
    for figure in epicyclic.figure_names(str(result.attrs["verb"]).replace("-", "_")):
        try:
            drawn = json.loads(epicyclic.plot(figure, result).to_json())
        except epicyclic.ModelError as error:
            lines = [str(error)]
        else:
            drawn.get("layout", {}).pop("template", None)
            lines = list(leaves(drawn))
        write(f"{name}.{figure}.figure.txt", "\n".join(lines))


def sheet_rows(file: Path) -> Iterator[str]:
    """Cells of a workbook, a row a line."""
    import openpyxl

    for sheet in openpyxl.load_workbook(file, read_only=True):
        yield f"sheet {sheet.title}"
        for row in sheet.iter_rows(values_only=True):
            yield " | ".join("" if cell is None else str(cell) for cell in row)


def leaves(value: object, path: str = "") -> Iterator[str]:
    """Texts and numbers of a JSON tree by their places; numbers of a list, or coded in base64, in one line."""
    if isinstance(value, Mapping) and {"dtype", "bdata"} <= set(value):
        import base64

        coded = np.frombuffer(base64.b64decode(value["bdata"]), dtype=np.dtype(str(value["dtype"])))
        yield f"{path} {' '.join(map(repr, coded.tolist()))}"
    elif isinstance(value, Mapping):
        for key in sorted(value):
            yield from leaves(value[key], f"{path}.{key}".lstrip("."))
    elif isinstance(value, list) and any(isinstance(entry, (Mapping, list)) for entry in value):
        for place, entry in enumerate(value):
            yield from leaves(entry, f"{path}[{place}]")
    elif isinstance(value, list):
        yield f"{path} {' '.join(str(entry) for entry in value)}"
    else:
        yield f"{path} {value}"


class _Text(HTMLParser):
    """Text of a page without its scripts and styles."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []
        self.within: list[str] = []

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        if tag in ("script", "style"):
            self.within.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if self.within and self.within[-1] == tag:
            self.within.pop()

    def handle_data(self, data: str) -> None:
        if not self.within and data.strip():
            self.lines.append(" ".join(data.split()))


def page_text(html: str) -> str:
    """Words of a page that are seen, a node a line."""
    reader = _Text()
    reader.feed(html)
    return "\n".join(reader.lines)


def page_frames(drive: str) -> Iterator[str]:
    """Frames of the page of a ready drive: all of its full set, heads and arrays."""
    import epicyclic

    compute, request = page_entry()
    document = epicyclic.load(drive).document
    for frame in compute(request(rev=1, kind="full", source=document)):
        yield f"frame {frame.kind}"
        yield from leaves(json.loads(json.dumps(frame.head, default=str)), "head")
        for name, array in frame.arrays.items():
            yield f"{name} {array.shape} {' '.join(map(repr, array.ravel().tolist()))}"


def page_entry() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """`compute` and `Request` of the page, wherever the checkout keeps them."""
    module = import_module("epicyclic.cockpit.computing.compute")
    return module.compute, module.Request


def write(name: str, text: str) -> None:
    """A file of the folder, with what differs between two runs masked."""
    for pattern, word in MASKS:
        text = pattern.sub(word, text)
    Path(name).write_text(text.rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
