"""A REXS file, in XML, JSON or a zip of one, read into `RexsFile` whatever it holds: safe, bounded, with reasons."""

from __future__ import annotations

import io
import json
import struct
import xml.etree.ElementTree as ElementTree
import zipfile
import zlib
from pathlib import Path

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from ..errors import ModelError
from ..input_files import read_bytes
from .json_parts import json_file
from .limits import MAX_BYTES, MAX_DEPTH, MAX_MARKS, MAX_RATIO
from .structure import RexsFile
from .xml_parts import xml_file

__all__ = ["read_rexs_file"]

VERSIONS = ("1.1", "1.2", "1.3", "1.4", "1.5", "1.6", "1.7", "2.0", "2.0.0")
_ALLOWED = "a REXS file in XML (.rexs), JSON (.rexsj) or a zip of one of them (.rexsz)"
_BOM = b"\xef\xbb\xbf"
_WIDE = (b"\xff\xfe", b"\xfe\xff")  # UTF-16


def read_rexs_file(source: str | Path | bytes) -> RexsFile:
    """Read a REXS file by its content: XML, JSON, or a zip with one of them.

    Parameters
    ----------
    source : path of a file of at most 16 MB, or its bytes.

    Raises
    ------
    ModelError : no such file, none of these encodings, cut short or damaged, a document type, an entity or a reference
        to another file, more than the limits of `limits`, another version than 1.1 to 1.7 and 2.0.0.
    """
    raw = source if isinstance(source, bytes) else read_bytes(source, most=MAX_BYTES, allowed=_ALLOWED)
    name = "REXS file" if isinstance(source, bytes) else str(source)
    try:
        file = _parsed(raw, name, zipped=False)
        _check_version(file)
    except ModelError as error:
        if error.path.startswith(name):
            raise
        where = f"{name}, {error.path}" if error.path else name
        raise error.at(where) from None
    return file


def _parsed(raw: bytes, name: str, *, zipped: bool) -> RexsFile:
    """The file of bytes of any encoding. Raises ModelError as of `read_rexs_file`."""
    if len(raw) > MAX_BYTES:
        raise ModelError("too large", path=name, allowed=f"at most {MAX_BYTES} bytes")
    if raw.startswith(b"PK") and not zipped:
        return _parsed(_unzipped(raw, name), name, zipped=True)
    start = raw.removeprefix(_BOM)[:200].lstrip()
    if start.startswith(b"<") or raw.startswith(_WIDE):
        return xml_file(_tree(raw, name))
    if start.startswith((b"{", b"[")):
        return json_file(_json(raw.removeprefix(_BOM), name))
    raise ModelError("empty" if not raw.strip() else "not a REXS file", path=name, allowed=_ALLOWED)


def _unzipped(raw: bytes, name: str) -> bytes:
    """The one file of a zip, unpacked in memory.

    Raises
    ------
    ModelError : no zip, not exactly one file in it, encrypted, packed by another method than deflate, a name that
        leaves its folder, unpacked larger than the limits of size and ratio.
    """
    allowed = "a zip of one REXS file, packed with deflate"
    # each entry of the directory is an object: more than a few are refused before the directory is read
    if raw.count(b"PK\x01\x02") > 50:
        raise ModelError("a zip of many files", path=name, allowed=allowed)
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            members = [member for member in archive.infolist() if not member.filename.endswith("/")]
            if len(members) != 1:
                raise ModelError(f"a zip of {len(members)} files", path=name, allowed=allowed)
            _check_member(members[0], name, allowed)
            with archive.open(members[0]) as opened:
                content = opened.read(MAX_BYTES + 1)
    except (
        zipfile.BadZipFile,
        zlib.error,
        struct.error,
        EOFError,
        OSError,
        ValueError,
        RuntimeError,
        OverflowError,
    ) as e:
        if isinstance(e, ModelError):
            raise
        raise ModelError(f"a damaged zip ({e})", path=name, allowed=allowed) from None
    if len(content) > MAX_BYTES:
        raise ModelError("unpacked too large", path=name, allowed=f"at most {MAX_BYTES} bytes")
    return content


def _check_member(member: zipfile.ZipInfo, name: str, allowed: str) -> None:
    """Raise ModelError for a member of a zip that is not unpacked."""
    parts = member.filename.replace("\\", "/").split("/")
    problem = ""
    if ".." in parts or parts[0] == "" or ":" in parts[0]:
        problem = "a name in the zip that leaves its folder"
    elif member.flag_bits & 0x1:
        problem = "an encrypted zip"
    elif member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        problem = "a zip packed by another method"
    elif member.file_size > MAX_BYTES:
        problem = f"unpacked too large ({member.file_size} bytes)"
    elif member.file_size > MAX_RATIO * max(member.compress_size, 1):
        problem = f"unpacked more than {MAX_RATIO} times as large: a zip bomb"
    if problem:
        raise ModelError(problem, path=name, given=member.filename, allowed=allowed)


class _BoundedTree(ElementTree.TreeBuilder):
    """Builder of an XML tree that stops where it is deeper than any REXS file."""

    def __init__(self) -> None:
        super().__init__()
        self._depth = 0

    def start(self, tag: str, attrs: dict[str, str], /) -> ElementTree.Element:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise ModelError("nested too deeply", allowed=f"at most {MAX_DEPTH} levels")
        return super().start(tag, attrs)

    def end(self, tag: str, /) -> ElementTree.Element:
        self._depth -= 1
        return super().end(tag)


def _tree(raw: bytes, name: str) -> ElementTree.Element:
    """The XML tree of bytes. Raises ModelError for what is no XML, too much, or refers to anything outside."""
    _check_marks(raw.count(b"<"), name)
    _check_marks(raw.count(b"="), name)
    parser = DefusedXMLParser(target=_BoundedTree(), forbid_dtd=True, forbid_entities=True, forbid_external=True)
    try:
        parser.feed(raw)
        root: ElementTree.Element = parser.close()
    except ModelError as error:
        raise error.at(name) from None
    except DefusedXmlException:
        problem = "a document type, an entity or a reference to another file in the XML"
        raise ModelError(problem, path=name, allowed="plain XML") from None
    except (ElementTree.ParseError, ValueError, LookupError, AssertionError) as error:
        raise ModelError(f"not XML: {error}", path=name, allowed=_ALLOWED) from None
    return root


def _json(raw: bytes, name: str) -> object:
    """The tables of JSON bytes. Raises ModelError for what is no JSON or too much."""
    _check_marks(sum(raw.count(mark) for mark in (b"{", b"[", b":")), name)
    try:
        return json.loads(raw.decode("utf-8"), parse_constant=str)
    except RecursionError:
        raise ModelError("nested too deeply", path=name, allowed=f"at most {MAX_DEPTH} levels") from None
    except UnicodeDecodeError as error:
        raise ModelError(f"not UTF-8 (byte {error.start})", path=name, allowed=_ALLOWED) from None
    except ValueError as error:
        raise ModelError(f"not JSON: {error}", path=name, allowed=_ALLOWED) from None


def _check_marks(count: int, name: str) -> None:
    """Raise ModelError for more elements than a REXS file may have."""
    if count > MAX_MARKS:
        raise ModelError(f"more than {MAX_MARKS} elements", path=name, allowed="a file of one gear unit")


def _check_version(file: RexsFile) -> None:
    """Raise ModelError for a version that is not read."""
    if file.version == "1.0":
        problem = "REXS 1.0 has no planetary stage (nor ring gear, planet carrier, side plate, coupling)"
        raise ModelError(problem, path="version", given="1.0", allowed="a planetary gear unit in REXS 1.1 or later")
    if file.version not in VERSIONS:
        raise ModelError("not a version that is read", path="version", given=file.version, allowed=", ".join(VERSIONS))
