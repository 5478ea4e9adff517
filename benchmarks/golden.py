"""What people see, in two checkouts: words exactly, numbers by tolerance.

    python benchmarks/golden.py collect CHECKOUT FOLDER [--drives ren2021,desk] [--only modes,page] [--jobs 2]
    python benchmarks/golden.py compare OLD NEW [--renames FILE]
    python benchmarks/golden.py keep FOLDER
    python benchmarks/golden.py check FOLDER

`collect` writes for every ready drive what commands print, the data of figures, tables as CSV and XLSX, the text of
the report and the frames of the page (`golden_worker.py`); ``desk`` is what belongs to no drive: help, messages.
`compare` reads two such folders.  Integers and words are equal; a number with a fraction agrees to a unit of its last
printed digit, to 1e-6 of itself, or to 1e-9 of the largest number of its line.  Lines of FILE are ``old -> new``: words
that were renamed, as regular expressions of the old text.  `keep` puts the part that the repository holds into
``tests/golden``, words and numbers apart; `check` compares a folder with it.

Exit status 1 where anything differs.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).parent
KEPT = HERE.parent / "tests/golden"
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w]*[a-zA-Z_]\d)")
PLACE = "\N{CURRENCY SIGN}"  # stands for a number among the words
# files that the repository holds: of the drives named, what commands print and axes of figures
KEPT_FILES = ("ren2021/*.txt", "desk/*.txt")
KEPT_WHOLE = 1_000_000  # bytes of all that the repository holds
KEPT_LARGEST = 30_000  # bytes of one file: no tables of many thousand numbers


def split(text: str) -> tuple[str, list[str]]:
    """Words of a text with a mark for each number, and the numbers as printed."""
    return NUMBER.sub(PLACE, text), NUMBER.findall(text)


def agree(old: str, new: str, largest: float) -> bool:
    """Whether two printed numbers agree; `largest` magnitude of the line they stand in."""
    if old == new:
        return True
    if not any(mark in number for number in (old, new) for mark in ".eE"):
        return False
    a, b = float(old), float(new)
    return abs(a - b) <= max(unit(old), unit(new), 1e-6 * max(abs(a), abs(b)), 1e-9 * largest) * (1 + 1e-9)


def unit(number: str) -> float:
    """Unit of the last digit of a number as printed; 0 of one with more digits than rounding leaves."""
    mantissa, _, exponent = number.lower().partition("e")
    digits = len(mantissa.partition(".")[2])
    if len(re.sub(r"\D", "", mantissa)) > 12:
        return 0.0
    return float(10.0 ** (int(exponent or 0) - digits))


def differences(old: str, new: str) -> list[str]:
    """Lines that differ, as ``place: old | new``."""
    first, second = old.splitlines(), new.splitlines()
    found = [] if len(first) == len(second) else [f"{len(first)} lines | {len(second)} lines"]
    for place, (a, b) in enumerate(zip(first, second, strict=False), start=1):
        if a == b:
            continue
        (words, numbers), (others, theirs) = split(a), split(b)
        largest = max((abs(float(number)) for number in numbers), default=0.0)
        if words != others:
            found.append(f"{place}: {a[:150]} | {b[:150]}")
        elif wrong := [pair for pair in zip(numbers, theirs, strict=True) if not agree(*pair, largest)]:
            found.append(f"{place}: {a[:60]} : {len(wrong)} numbers, {wrong[0][0]} | {wrong[0][1]}")
    return found


def collect(checkout: Path, folder: Path, drives: list[str], only: str, jobs: int) -> None:
    """Run the worker for each drive, in processes of their own."""

    def one(drive: str) -> int:
        (folder / drive).mkdir(parents=True, exist_ok=True)
        environment = os.environ | {
            "PYTHONPATH": str((checkout / "src").resolve()),
            "OPENBLAS_NUM_THREADS": "1",
            "EPICYCLIC_JOBS": "1",
            "PYTHONHASHSEED": "0",
            "COLUMNS": "160",
            "LC_ALL": "C.UTF-8",
        }
        command = [sys.executable, str((HERE / "golden_worker.py").resolve()), drive, str((folder / drive).resolve())]
        with (folder / f"{drive}.log").open("w") as log:
            return subprocess.run(
                [*command, "--only", only], env=environment, cwd=folder, stdout=log, stderr=subprocess.STDOUT
            ).returncode

    with ThreadPoolExecutor(jobs) as pool:
        status = dict(zip(drives, pool.map(one, drives), strict=True))
    if failed := [drive for drive in drives if status[drive]]:
        raise SystemExit(f"no golden set of {', '.join(failed)}: see the .log files in {folder}")


def compare(old: Path, new: Path, renames: list[tuple[str, str]]) -> int:
    """Print what differs, file by file; the number of files that do."""
    names = sorted({p.relative_to(root).as_posix() for root in (old, new) for p in root.glob("*/*.txt")})
    moved = lines = 0
    for name in names:
        if missing := [str(root) for root in (old, new) if not (root / name).exists()]:
            print(f"{name}: not in {missing[0]}")
            moved += 1
            continue
        before, after = ((root / name).read_text(encoding="utf-8") for root in (old, new))
        for pattern, word in renames:
            before = re.sub(pattern, word, before)
        lines += before.count("\n")
        if found := differences(before, after):
            moved += 1
            print(f"{name}: {len(found)} lines differ", *found[:3], sep="\n    ")
    print(f"{len(names)} files, {lines} lines: {moved} files differ")
    return moved


def keep(folder: Path) -> None:
    """The part that the repository holds: ``tests/golden/DRIVE.words`` and ``DRIVE.numbers`` of what is collected."""
    texts: dict[str, str] = {}
    for pattern in KEPT_FILES:
        drive = pattern.partition("/")[0]
        if not (folder / drive).is_dir():
            continue
        words, numbers = [], []
        for file in sorted(folder.glob(pattern)):
            if file.stat().st_size > KEPT_LARGEST or file.name.startswith("help"):
                continue
            text, found = split(file.read_text(encoding="utf-8"))
            words.append(f"==== {file.name}\n{text}")
            numbers.append(" ".join([f"{file.name}:", *found]))
        if not words:
            raise SystemExit(f"{folder / drive} holds nothing to keep: collect it first")
        texts |= {f"{drive}.words": "".join(words), f"{drive}.numbers": "\n".join(numbers) + "\n"}
    others = (path.stat().st_size for path in KEPT.glob("*") if path.name not in texts)
    size = sum(len(text.encode()) for text in texts.values()) + sum(others)
    if size > KEPT_WHOLE:
        raise SystemExit(f"{size} bytes, of {KEPT_WHOLE}: collect fewer commands with --only")
    KEPT.mkdir(exist_ok=True)
    for name, text in texts.items():
        (KEPT / name).write_text(text, encoding="utf-8")


def kept(drive: str) -> dict[str, str]:
    """Texts of the files of a drive that the repository holds, by name."""
    words = re.split(r"^==== ", (KEPT / f"{drive}.words").read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    numbers = (KEPT / f"{drive}.numbers").read_text(encoding="utf-8").splitlines()
    texts = {}
    for part, line in zip(words, numbers, strict=True):
        name, _, text = part.partition("\n")
        values = iter(line.split()[1:])
        texts[name] = re.sub(PLACE, lambda _, values=values: next(values), text)
    return texts


def check(folder: Path) -> int:
    """Print what differs from the part that the repository holds, or is not collected; how many lines do."""
    compared, result = 0, list[str]()
    for drive in sorted(path.name for path in folder.iterdir() if path.is_dir()):
        for name, text in kept(drive).items():
            if not (file := folder / drive / name).exists():
                result.append(f"{drive}/{name}: not collected")
            else:
                compared += 1
                result += [f"{drive}/{name}:{line}" for line in differences(text, file.read_text(encoding="utf-8"))]
    print(*result, f"{compared} files compared", sep="\n")
    return len(result)


def main() -> int:
    """Run one of the four."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = parser.add_subparsers(required=True, dest="part")
    one = parts.add_parser("collect")
    one.add_argument("checkout", type=Path)
    one.add_argument("folder", type=Path)
    one.add_argument("--drives", default="")
    one.add_argument("--only", default="")
    one.add_argument("--jobs", type=int, default=2)
    two = parts.add_parser("compare")
    two.add_argument("old", type=Path)
    two.add_argument("new", type=Path)
    two.add_argument("--renames", type=Path)
    parts.add_parser("keep").add_argument("folder", type=Path)
    parts.add_parser("check").add_argument("folder", type=Path)
    given = parser.parse_args()
    if given.part == "collect":
        ready = sorted(p.stem for p in (given.checkout / "src/epicyclic/systems").glob("*.toml") if "." not in p.stem)
        given.folder.mkdir(parents=True, exist_ok=True)
        drives = given.drives.split(",") if given.drives else ["desk", *ready]
        collect(given.checkout, given.folder, drives, given.only, given.jobs)
        return 0
    if given.part == "keep":
        keep(given.folder)
        return 0
    if given.part == "check":
        return int(check(given.folder) > 0)
    text = given.renames.read_text(encoding="utf-8") if given.renames else ""
    renames = [(a.strip(), b.strip()) for a, arrow, b in (line.partition("->") for line in text.splitlines()) if arrow]
    return int(compare(given.old, given.new, renames) > 0)


if __name__ == "__main__":
    sys.exit(main())
