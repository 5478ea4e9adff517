"""Damaged REXS files, made from good ones by seed: each is read or refused with a ModelError, soon, in little memory.

    python benchmarks/rexs_mutations.py --count 10000 --jobs 2 [--encoding json] [GOOD.rexs ...]

reads that many of each encoding in processes of limited memory and prints counts, the longest time and the largest
memory.  Exit status 1 where anything but a model or a ModelError came, or one file took longer than the limit.
"""

from __future__ import annotations

import argparse
import copy
import io
import itertools
import json
import random
import re
import resource
import signal
import subprocess
import sys
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from rexs_nasty import JSON_NASTY, NASTY, TYPES

from epicyclic.document.document import read
from epicyclic.engine.source import train_of
from epicyclic.errors import ModelError
from epicyclic.rexs.encodings import read_rexs_file, rexs_bytes
from epicyclic.rexs.export import rexs_of
from epicyclic.rexs.import_train import read_rexs
from epicyclic.train.resolution import resolve

__all__ = ["ENCODINGS", "Fault", "damaged", "good_files", "tried"]

ENCODINGS = ("xml", "json", "zip")
SECONDS = 5.0  # of a processor, for one file: what else the machine does is no matter
MEGABYTES = 500  # of a process that reads them
_SPACE = 3_000_000_000  # bytes of addresses: numerical libraries reserve what they never touch
_MINE = {
    "format": 2,
    "title": "A stage",
    "stages": {
        "main": {
            "planets": 3,
            "module": "4 mm",
            "helix_angle": "15 deg",
            "face_width": "50 mm",
            "sun": {"teeth": 24, "support": {"radial": "5e7 N/m"}},
            "planet": {"teeth": 30, "bearing": {"radial": "4e8 N/m"}},
            "ring": {"teeth": 84, "rim": "25 mm", "addendum": 0.9},
            "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
}


class Fault(Exception):
    """What must not come: anything but a model or a ModelError, or too late."""


def good_files(paths: Sequence[str | Path] = ()) -> list[bytes]:
    """Files in XML to damage: a stage and a herringbone stage of our own, and those given."""
    own = [rexs_bytes(rexs_of(train_of(source)).file, "xml") for source in (_MINE, "ren2021")]
    return [*own, *(rexs_bytes(read_rexs_file(path), "xml") for path in paths)]


def damaged(good: Sequence[bytes], encoding: str, seed: int) -> tuple[str, bytes]:
    """Name of the damage and the damaged file of a seed."""
    chance = random.Random(f"{encoding} {seed}")
    xml = chance.choice(good)
    kinds = {"xml": _XML, "json": _JSON, "zip": _ZIP}[encoding]
    name = chance.choice(list(kinds))
    return name, kinds[name](chance, xml)


def tried(raw: bytes) -> str:
    """What becomes of a file: read to the end, or refused, with the first words of the reason.

    Raises
    ------
    Fault : another error than ModelError.
    """
    try:
        resolve(read(read_rexs(raw).document))
    except ModelError as error:
        str(error)
        return f"refused: {error.problem[:40]}"
    except Exception as error:
        raise Fault(f"{type(error).__name__}: {error}\n{traceback.format_exc(limit=-3)}") from error
    return "read"


# damage to bytes


def _flipped(chance: random.Random, raw: bytes) -> bytes:
    changed = bytearray(raw)
    for _ in range(chance.choice((1, 1, 2, 5, 50))):
        changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
    return bytes(changed)


def _cut(chance: random.Random, raw: bytes) -> bytes:
    at = chance.randrange(len(raw))
    return chance.choice((raw[:at], raw[at:], raw[:at] + raw[at + chance.randrange(2000) :]))


def _repeated(chance: random.Random, raw: bytes) -> bytes:
    at = chance.randrange(len(raw))
    return raw[:at] + raw[at : at + chance.randrange(1, 3000)] * chance.choice((2, 3, 20)) + raw[at:]


def _inserted(chance: random.Random, raw: bytes) -> bytes:
    at = chance.randrange(len(raw))
    return raw[:at] + chance.randbytes(chance.choice((1, 4, 100, 5000))) + raw[at:]


_BYTES: dict[str, Callable[[random.Random, bytes], bytes]] = {
    "bits flipped": _flipped,
    "cut": _cut,
    "slice repeated": _repeated,
    "bytes inserted": _inserted,
}


def _word(chance: random.Random, raw: bytes) -> bytes:
    """A number or word of the text replaced by a nasty one."""
    places = list(re.finditer(rb'(?<=[">])[^<>"\n]+(?=["<])', raw))
    for one in sorted(chance.sample(places, chance.choice((1, 1, 3))), key=lambda p: -p.start()):
        new = str(chance.choice(NASTY)).encode("utf-8", "surrogatepass")
        raw = raw[: one.start()] + new + raw[one.end() :]
    return raw


# damage to the tree of an XML file


def _tree(change: Callable[[random.Random, ElementTree.Element], None]) -> Callable[[random.Random, bytes], bytes]:
    def damage(chance: random.Random, raw: bytes) -> bytes:
        root = ElementTree.fromstring(raw)
        for _ in range(chance.choice((1, 1, 2, 4))):
            change(chance, root)
        raw = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
        return bytes(raw)

    return damage


def _any(chance: random.Random, root: ElementTree.Element) -> tuple[ElementTree.Element, ElementTree.Element]:
    """Any element but the root, with its parent."""
    parents = [element for element in root.iter() if len(element)]
    parent = chance.choice(parents)
    return parent, chance.choice(list(parent))


def _removed(chance: random.Random, root: ElementTree.Element) -> None:
    parent, element = _any(chance, root)
    parent.remove(element)


def _doubled(chance: random.Random, root: ElementTree.Element) -> None:
    parent, element = _any(chance, root)
    new = copy.deepcopy(element)
    if chance.random() < 0.5 and "id" in new.attrib:
        new.set("id", str(chance.randrange(1, 400)))
    parent.append(new)


def _renamed(chance: random.Random, root: ElementTree.Element) -> None:
    _, element = _any(chance, root)
    if chance.random() < 0.3:
        element.tag = chance.choice(("component", "attribute", "array", "matrix", "c", "r", "relations", "model", "x"))
    elif element.attrib:
        key = chance.choice(list(element.attrib))
        element.set(chance.choice(("id", "type", "role", "unit", "code", "order")), element.attrib.pop(key))


def _retyped(chance: random.Random, root: ElementTree.Element) -> None:
    typed = [element for element in root.iter() if "type" in element.attrib]
    chance.choice(typed).set("type", chance.choice(TYPES))


def _swapped(chance: random.Random, root: ElementTree.Element) -> None:
    """Ids, roles or values of two elements exchanged; or one of them given to the other."""
    alike = [element for element in root.iter(chance.choice(("ref", "component", "attribute", "relation")))]
    a, b = chance.choice(alike), chance.choice(alike)
    key = chance.choice([key for key in a.attrib] or ["id"])
    one, other = a.get(key, ""), b.get(key, "")
    b.set(key, one)
    if chance.random() < 0.7:
        a.set(key, other)


def _looped(chance: random.Random, root: ElementTree.Element) -> None:
    """References of position, of stages and of assemblies in circles."""
    ids = [element.get("id", "1") for element in root.iter("component")]
    for element in root.iter("attribute"):
        if element.get("id") == "reference_component_for_position" and chance.random() < 0.7:
            element.text = chance.choice(ids)
    if chance.random() < 0.5:
        relations = root.find("relations")
        assert relations is not None
        for number in range(chance.choice((1, 10, 300))):
            kind = chance.choice(TYPES)
            new = ElementTree.SubElement(relations, "relation", id=str(5000 + number), type=kind)
            for role in chance.sample(("assembly", "part", "stage", "gear_1", "gear_2", "shaft", "origin", "referenced",
                                       "inner_part", "outer_part", "planetary_stage"), 3):  # fmt: skip
                ElementTree.SubElement(new, "ref", id=chance.choice(ids), role=role)


def _valued(chance: random.Random, root: ElementTree.Element) -> None:
    """Values of attributes replaced: numbers, units, arrays of other sizes, coded arrays."""
    element = chance.choice(list(root.iter("attribute")))
    kind = chance.randrange(4)
    safe = [
        text for text in NASTY if isinstance(text, str) and re.fullmatch(r"[\t\n\r\x20-\ud7ff\ue000-\ufffd]*", text)
    ]
    if kind == 0:
        element.text = chance.choice(safe)
    elif kind == 1:
        element.set("unit", chance.choice(safe))
    elif kind == 2:
        element.text, element[:] = "", []
        array = ElementTree.SubElement(element, chance.choice(("array", "matrix", "array_of_arrays")))
        for _ in range(chance.choice((0, 1, 2, 4, 1000))):
            ElementTree.SubElement(array, chance.choice(("c", "c", "r", "array"))).text = chance.choice(safe)
    else:
        element.text, element[:] = "", []
        array = ElementTree.SubElement(element, chance.choice(("array", "matrix")), code=chance.choice(
            ("float64", "float32", "int32", "int64", "x")),
            rows=chance.choice(("1000000000", "-1", "3", "x")))  # fmt: skip
        array.text = chance.choice(("", "AAAA", "AAAAAAAA8D8=", "#", "A" * 99999))


def _nested(chance: random.Random, raw: bytes) -> bytes:
    depth = chance.choice((20, 200, 20_000, 200_000))
    tag = chance.choice((b"component", b"attribute", b"array", b"model"))
    inner = b"<" + tag + b">"
    return raw.replace(b"</components>", inner * depth + chance.choice((b"", inner.replace(b"<", b"</") * depth)), 1)


def _entities(chance: random.Random, raw: bytes) -> bytes:
    """Entity bombs, external entities, document types, references to style sheets and to other files."""
    bomb = '<!ENTITY a "aaaaaaaaaa">' + "".join(
        f'<!ENTITY {chr(98 + i)} "{"&" + chr(97 + i) + ";"}{"&" + chr(97 + i) + ";" * 9}">' for i in range(20)
    )
    heads = (
        f"<!DOCTYPE model [{bomb}]>",
        '<!DOCTYPE model [<!ENTITY a SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE model SYSTEM "http://localhost:9/x.dtd">',
        '<!DOCTYPE model [<!ENTITY % a SYSTEM "file:///etc/passwd">%a;]>',
        f'<!DOCTYPE model [<!ENTITY a "{"a" * 100_000}">]>',
        '<?xml-stylesheet href="file:///etc/passwd"?>',
        "<!DOCTYPE model>",
    )
    used = chance.choice((b"&u;", b"&a;", b"&a;" * 1000, b"&#0;", b"&#x110000;", b"&lt;"))
    head = chance.choice(heads).encode()
    return raw.replace(b"<model ", head + b"<model ", 1).replace(b'name="main', b'name="' + used, 1)


def _encoded(chance: random.Random, raw: bytes) -> bytes:
    """Another encoding than the one that stands in the head, or a head of another one."""
    text = raw.decode("utf-8")
    name = chance.choice(
        ("utf-16", "utf-32", "latin-1", "utf-7", "cp037", "utf-8-sig", "idna", "punycode", "x", "zlib")
    )
    if chance.random() < 0.5:
        return raw.replace(b'encoding="UTF-8"', f'encoding="{name}"'.encode(), 1)
    try:
        return text.encode(name, "replace")
    except (LookupError, UnicodeError):
        return raw.replace(b"UTF-8", b"UTF-16", 1)


def _many(chance: random.Random, raw: bytes) -> bytes:
    """Very many elements of one kind."""
    kind = chance.choice(
        (b'<component id="%d" type="shaft"/>', b'<component id="%d" type="planetary_stage"/>', b"<c>%d</c>")
    )
    count = chance.choice((1000, 20_000, 400_000))
    return raw.replace(b"</components>", b"".join(kind % (1000 + i) for i in range(count)) + b"</components>", 1)


def _planets(chance: random.Random, raw: bytes) -> bytes:
    """Many planet shafts, stages and meshes of the same gears."""
    kinds = re.findall(rb"    <relation (?:.*\n)+?    </relation>\n", raw)
    some = chance.sample(kinds, min(len(kinds), 8)) * chance.choice((2, 50, 300))
    fresh = (re.sub(rb'<relation id="\d+"', b'<relation id="%d"' % (7000 + i), one) for i, one in enumerate(some))
    return raw.replace(b"  </relations>", b"".join(fresh) + b"  </relations>", 1)


_XML: dict[str, Callable[[random.Random, bytes], bytes]] = {
    **_BYTES,
    "word": _word,
    "element removed": _tree(_removed),
    "element doubled": _tree(_doubled),
    "renamed": _tree(_renamed),
    "type": _tree(_retyped),
    "swapped": _tree(_swapped),
    "loops": _tree(_looped),
    "value": _tree(_valued),
    "nested": _nested,
    "entities": _entities,
    "encoding": _encoded,
    "many": _many,
    "relations repeated": _planets,
}


# damage to the tables of a JSON file


def _as_json(raw: bytes) -> bytes:
    return rexs_bytes(read_rexs_file(raw), "json")


def _tables(change: Callable[[random.Random, list[tuple[Any, Any]]], None]) -> Callable[[random.Random, bytes], bytes]:
    def damage(chance: random.Random, raw: bytes) -> bytes:
        tables = json.loads(_as_json(raw))
        for _ in range(chance.choice((1, 1, 2, 4))):
            change(chance, _nodes(tables))
        return json.dumps(tables).encode("utf-8", "surrogatepass")

    return damage


def _nodes(table: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) of nested tables and lists."""
    found: list[tuple[Any, Any]] = []
    keys = range(len(table)) if isinstance(table, list) else list(table)
    for key in keys:
        found.append((table, key))
        if isinstance(table[key], (dict, list)):
            found += _nodes(table[key])
    return found


def _json_removed(chance: random.Random, nodes: list[tuple[Any, Any]]) -> None:
    table, key = chance.choice(nodes)
    del table[key]


def _json_doubled(chance: random.Random, nodes: list[tuple[Any, Any]]) -> None:
    lists = [(table, key) for table, key in nodes if isinstance(table, list)]
    table, key = chance.choice(lists)
    table.append(copy.deepcopy(table[key]))


def _json_renamed(chance: random.Random, nodes: list[tuple[Any, Any]]) -> None:
    tables = [(table, key) for table, key in nodes if isinstance(table, dict)]
    table, key = chance.choice(tables)
    names = (
        "id",
        "unit",
        "type",
        "refs",
        "attributes",
        "floating_point_array_coded",
        "integer_matrix_coded",
        "string",
        "x",
    )
    table[chance.choice(names)] = table.pop(key)


def _json_valued(chance: random.Random, nodes: list[tuple[Any, Any]]) -> None:
    table, key = chance.choice(nodes)
    table[key] = copy.deepcopy(chance.choice((*JSON_NASTY, *NASTY)))


def _json_swapped(chance: random.Random, nodes: list[tuple[Any, Any]]) -> None:
    key = chance.choice(("id", "type", "role", "unit", "floating_point", "integer", "floating_point_array"))
    alike = [table for table, name in nodes if name == key and isinstance(table, dict)]
    if len(alike) > 1:
        a, b = chance.sample(alike, 2)
        a[key], b[key] = b[key], (a[key] if chance.random() < 0.7 else b[key])


def _json_looped(chance: random.Random, nodes: list[tuple[Any, Any]]) -> None:
    for table, key in nodes:
        if key == "reference_component" and chance.random() < 0.7:
            table[key] = chance.randrange(1, 120)


def _json_nested(chance: random.Random, raw: bytes) -> bytes:
    depth = chance.choice((20, 200, 20_000, 200_000))
    opened, closed = chance.choice((("[", "]"), ('{"a":', "}")))
    middle = chance.choice(("1", "", "null"))
    return f'{{"model": {opened * depth}{middle}{chance.choice(("", closed * depth))}}}'.encode()


def _json_many(chance: random.Random, raw: bytes) -> bytes:
    tables = json.loads(_as_json(raw))
    count = chance.choice((1000, 20_000, 300_000))
    kind = chance.choice(("shaft", "planetary_stage", "cylindrical_gear"))
    tables["model"]["components"] += [{"id": 1000 + i, "type": kind} for i in range(count)]
    return json.dumps(tables).encode()


def _json_bytes(damage: Callable[[random.Random, bytes], bytes]) -> Callable[[random.Random, bytes], bytes]:
    return lambda chance, raw: damage(chance, _as_json(raw))


_JSON: dict[str, Callable[[random.Random, bytes], bytes]] = {
    **{name: _json_bytes(damage) for name, damage in _BYTES.items()},
    "key removed": _tables(_json_removed),
    "entry doubled": _tables(_json_doubled),
    "key renamed": _tables(_json_renamed),
    "value": _tables(_json_valued),
    "swapped": _tables(_json_swapped),
    "loops": _tables(_json_looped),
    "nested": _json_nested,
    "many": _json_many,
}


# damage to a zip


def _packed(entries: Sequence[tuple[str, bytes]], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    packed = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(packed, "w", method) as archive:
        warnings.simplefilter("ignore")  # of names that stand twice
        for name, raw in entries:
            archive.writestr(zipfile.ZipInfo(name), raw, compress_type=method, compresslevel=1)
    return packed.getvalue()


def _zip_names(chance: random.Random, raw: bytes) -> bytes:
    """Names that leave the folder, several files, folders, names without end."""
    names = (
        "../a.rexs",
        "/etc/passwd",
        "..\\a.rexs",
        "C:\\a.rexs",
        "a/../../b",
        "",
        "a" * 60_000,
        "\x00",
        "x/",
        "a.rexs",
    )
    count = chance.choice((0, 1, 1, 1, 2, 100))
    return _packed([(f"{chance.choice(names)}{i or ''}", raw) for i in range(count)])


def _zip_methods(chance: random.Random, raw: bytes) -> bytes:
    return _packed([("a.rexs", raw)], chance.choice((zipfile.ZIP_STORED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)))


def _zip_bomb(chance: random.Random, raw: bytes) -> bytes:
    """Much in little: blanks, zeros, a zip within a zip, a size in the head that is not that of the content."""
    size = chance.choice((1_000_000, 15_000_000, 40_000_000))
    content = chance.choice(
        (raw[:200] + b" " * size, b"\x00" * size, raw.replace(b"<components>", b"<components>" + b"<c/>" * 100_000))
    )
    packed = _packed([("a.rexs", content)])
    return chance.choice((packed, _packed([("a.rexsz", packed)]), _lying(chance, packed)))


def _lying(chance: random.Random, packed: bytes) -> bytes:
    """Sizes, flags, methods and check sums in the heads changed."""
    changed = bytearray(packed)
    for mark, fields in ((b"PK\x01\x02", (8, 10, 16, 20, 24, 28, 30, 32, 42)),
                         (b"PK\x03\x04", (6, 8, 14, 18, 22, 26, 28)),
                         (b"PK\x05\x06", (4, 8, 10, 12, 16, 20))):  # fmt: skip
        at = packed.find(mark)
        if at >= 0 and chance.random() < 0.6:
            place = at + chance.choice(fields)
            new = chance.choice(
                (b"\xff\xff\xff\xff", b"\x00\x00\x00\x00", chance.randbytes(4), b"\x01\x00", b"\x64\x00\x00\x00")
            )
            changed[place : place + len(new)] = new
    return bytes(changed)


def _zip_inner(chance: random.Random, raw: bytes) -> bytes:
    name = chance.choice([name for name in _XML if name not in ("many", "nested")])
    return _packed([("a.rexs", _XML[name](chance, raw))])


def _zip_json(chance: random.Random, raw: bytes) -> bytes:
    name = chance.choice([name for name in _JSON if name not in ("many", "nested")])
    return _packed([("a.rexsj", _JSON[name](chance, raw))])


def _zip_deflate(chance: random.Random, raw: bytes) -> bytes:
    """The compressed stream itself damaged, with heads that fit."""
    packed = bytearray(_packed([("a.rexs", raw)]))
    for _ in range(chance.choice((1, 3, 20))):
        packed[chance.randrange(36, len(packed) - 80)] ^= 1 << chance.randrange(8)
    return bytes(packed)


def _zip_bytes(damage: Callable[[random.Random, bytes], bytes]) -> Callable[[random.Random, bytes], bytes]:
    return lambda chance, raw: damage(chance, _packed([("a.rexs", raw)]))


_ZIP: dict[str, Callable[[random.Random, bytes], bytes]] = {
    **{name: _zip_bytes(damage) for name, damage in _BYTES.items()},
    "names": _zip_names,
    "methods": _zip_methods,
    "bomb": _zip_bomb,
    "heads": _zip_bytes(_lying),
    "xml within": _zip_inner,
    "json within": _zip_json,
    "stream": _zip_deflate,
}


# the whole run


def _late(*_: object) -> None:
    raise Fault(f"longer than {SECONDS} s")


def _child(encoding: str, start: int, stop: int, paths: Sequence[str]) -> None:
    """Read the damaged files of some seeds; print a JSON line of what came."""
    resource.setrlimit(resource.RLIMIT_AS, (_SPACE, _SPACE))
    signal.signal(signal.SIGPROF, _late)
    good = good_files(paths)
    came: Counter[str] = Counter()
    faults: list[str] = []
    longest = (0.0, 0, "")
    for seed in range(start, stop):
        name, raw = damaged(good, encoding, seed)
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        begun = time.process_time()
        try:
            came[tried(raw).partition(":")[0]] += 1
        except Fault as fault:
            faults.append(f"{encoding} {seed} ({name}): {fault}")
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        longest = max(longest, (time.process_time() - begun, seed, name))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
    print(json.dumps({"came": came, "faults": faults, "longest": longest, "memory": memory}), flush=True)


def main() -> int:
    """Run all encodings; status 1 where there was a fault or a limit was passed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("good", nargs="*", help="real files to damage as well")
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--encoding", choices=ENCODINGS)
    parser.add_argument("--child", type=int, nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        start, stop = given.child
        _child(given.encoding, start, stop, given.good)
        return 0
    failed = False
    for encoding in [given.encoding] if given.encoding else ENCODINGS:
        cuts = [given.start + round(given.count * i / given.jobs) for i in range(given.jobs + 1)]
        runs = [
            subprocess.Popen(
                [sys.executable, __file__, *given.good, "--encoding", encoding, "--child", str(a), str(b)],
                stdout=subprocess.PIPE, text=True,
            )
            for a, b in itertools.pairwise(cuts)
        ]  # fmt: skip
        died = '{"came": {}, "faults": ["died"], "longest": [0, 0, ""], "memory": 0}'
        results = [json.loads(run.communicate()[0] or died)
                   for run in runs]  # fmt: skip
        came: Counter[str] = sum((Counter(one["came"]) for one in results), Counter())
        faults = [fault for one in results for fault in one["faults"]]
        longest, memory = max(one["longest"] for one in results), max(one["memory"] for one in results)
        print(f"{encoding}: {dict(came)}, {len(faults)} faults, longest {longest[0]:.2f} s (seed {longest[1]}, "
              f"{longest[2]}), at most {memory:.0f} MB", flush=True)  # fmt: skip
        for fault in faults[:20]:
            print(fault)
        failed = failed or bool(faults) or memory > MEGABYTES
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
