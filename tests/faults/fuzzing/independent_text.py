"""What stands in texts, PLY and PCD, read a second time: slowly, strictly, and with none of the product's code.

Each function gives the records (n, 3) as they stand. ``Unsure`` says that it cannot tell; any other exception says that
the file is none.
"""

import re
import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

STRICT = re.compile(r"[+-]?(\d++\.?\d*+|\.\d++)([eE][+-]?\d++)?", re.ASCII)
PLY_CODES = {
    "char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
    "int": "i", "int32": "i", "uint": "I", "uint32": "I", "int64": "q", "uint64": "Q",
    "float": "f", "float32": "f", "double": "d", "float64": "d",
}  # fmt: skip
PCD_CODES = {
    "F4": "f",
    "F8": "d",
    "I1": "b",
    "I2": "h",
    "I4": "i",
    "I8": "q",
    "U1": "B",
    "U2": "H",
    "U4": "I",
    "U8": "Q",
}
Records = NDArray[np.float64]


class Unsure(Exception):  # noqa: N818 - an answer, no fault
    """The independent reader cannot tell."""


def number_in(token: str) -> float:
    """A number in plain notation, or one that is not finite by its own word."""
    if token.strip().lower().lstrip("+-") in {"nan", "inf", "infinity"}:
        return float(token)
    if not STRICT.fullmatch(token.strip()):
        raise ValueError(f"{token[:30]!r} is no number")
    return float(token)


def _fields(line: str, separator: str | None) -> list[str]:
    return [field.strip() for field in line.split(separator)]


def _is_row(line: str) -> bool:
    return any(_n_numbers(line, separator) >= 3 for separator in (";", "\t", ",", None))


def _n_numbers(line: str, separator: str | None) -> int:
    n_found = 0
    for field in _fields(line, separator):
        try:
            number_in(field)
        except ValueError:
            continue
        n_found += 1
    return n_found


def delimited(content: bytes, wanted: Sequence[str]) -> Records:
    """A point a line, with or without names and a count before them."""
    text = content.removeprefix(b"\xef\xbb\xbf").decode("latin-1")
    lines = re.split(r"\r\n|\n|\r", text)
    first = next((place for place, line in enumerate(lines) if _is_row(line)), None)
    if first is None:
        raise ValueError("no rows")
    names, declared = _before_rows(lines[:first])
    separator = next(s for s in (";", "\t", ",", None) if _n_numbers(lines[first], s) >= 3)
    columns = (0, 1, 2) if names is None else _named(names, separator, wanted)
    rows = [_fields(line, separator) for line in lines[first:] if line.strip()]
    if declared is not None and declared != len(rows):
        raise ValueError("another count")
    return np.array([[number_in(row[column]) for column in columns] for row in rows])


def _before_rows(lines: Sequence[str]) -> tuple[str | None, int | None]:
    """The line of names and the count that stand before the rows."""
    names, declared = None, None
    for line in lines:
        if re.match(r"\s*(#|//)", line):
            if not re.fullmatch(r"\s*(#|//)\s*(x[ ,;\t]+y[ ,;\t]+z|[^xsXS]*)\s*", line):
                raise Unsure
        elif re.fullmatch(r"\s*\d{1,18}\s*", line) and declared is None:
            declared = int(line)
        elif line.strip():
            if names is not None:
                raise ValueError("two lines of names")
            names = line
    return names, declared


def _named(line: str, separator: str | None, wanted: Sequence[str]) -> list[int]:
    parts = line.split(separator) if separator and separator in line else re.split(r"[;,\t ]+", line.strip())
    plain = [re.sub(r"\s*[\[(].*[\])]", "", part.strip().strip("\"'")).strip().lower() for part in parts]
    plain = [re.sub(r"_(m|deg)$", "", name) for name in plain]
    if any(plain.count(name) != 1 for name in wanted):
        raise ValueError("no such names")
    return [plain.index(name) for name in wanted]


def pts(content: bytes, part: int | None) -> Records:
    """Counts and as many rows each."""
    blocks, lines = [], content.removeprefix(b"\xef\xbb\xbf").decode("latin-1").split("\n")
    while lines:
        head = lines.pop(0)
        if not head.strip():
            continue
        n_rows = _whole(head)
        rows, lines = _take(lines, n_rows)
        is_asked = part in {None, len(blocks) + 1}
        blocks.append(_rows(rows if is_asked else [], {3, 4, 6, 7}))
    return np.concatenate(blocks if part is None else [blocks[part - 1]])


def _whole(text: str) -> int:
    if not re.fullmatch(r"\d{1,18}", text.strip(), re.ASCII):
        raise ValueError(f"{text[:30]!r} is no count")
    return int(text)


def _take(lines: list[str], n_rows: int) -> tuple[list[str], list[str]]:
    rows = lines[:n_rows]
    if len(rows) < n_rows or not all(row.strip() for row in rows):
        raise ValueError("too few rows")
    return rows, lines[n_rows:]


def _rows(lines: Sequence[str], widths: set[int]) -> Records:
    """First three numbers of rows that are all of one width."""
    if not lines:
        return np.empty((0, 3))
    separator = next((sign for sign in (";", ",") if sign in lines[0]), None)
    rows = [_fields(line, separator) for line in lines]
    if len({len(row) for row in rows}) != 1 or len(rows[0]) not in widths:
        raise ValueError("rows of other widths")
    return np.array([[number_in(field) for field in row][:3] for row in rows])


def ptx(content: bytes, part: int | None, *, in_file: bool) -> Records:
    """Scans of ten lines and their rows, placed by their matrices where the frame of the file is asked for."""
    scans, lines = [], content.removeprefix(b"\xef\xbb\xbf").decode("latin-1").split("\n")
    while lines:
        if not lines[0].strip():
            lines.pop(0)
            continue
        n_rows = _whole(lines[0]) * _whole(lines[1])
        head, (rows, lines) = lines[6:10], _take(lines[10:], n_rows)
        if part not in {None, len(scans) + 1}:
            scans.append(np.empty((0, 3)))
            continue
        matrix = np.array([[number_in(field) for field in line.split()] for line in head])
        points = _rows([row.replace(",", "x").replace(";", "x") for row in rows], {3, 4, 6, 7})
        if in_file and len(points):
            is_there = points.any(axis=1)
            points[is_there] = points[is_there] @ matrix[:3, :3] + matrix[3, :3]
        scans.append(points)
    return np.concatenate(scans if part is None else [scans[part - 1]])


def ply(content: bytes, wanted: Sequence[str]) -> Records:
    """The element vertex of a PLY file."""
    end = re.search(rb"^[ \t]*end_header[ \t\r]*\n", content, re.M)
    if end is None:
        raise ValueError("no end of the header")
    lines = [line.split() for line in content[: end.start()].decode("latin-1").splitlines()]
    kind = next(line[1] for line in lines if line[:1] == ["format"])
    elements: list[tuple[str, int, list[list[str]]]] = []
    for words in lines:
        if words[:1] == ["element"]:
            elements.append((words[1], _whole(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    if kind == "ascii":
        body = content[end.end() :].decode("latin-1").split("\n")
        return _ply_text(elements, body, wanted)
    return _ply_binary(elements, content, end.end(), "<" if "little" in kind else ">", wanted)


def _wanted_of(properties: list[list[str]], wanted: Sequence[str]) -> list[int]:
    names = [known[-1].lower() for known in properties]
    return [names.index(name) for name in wanted]


def _ply_text(
    elements: list[tuple[str, int, list[list[str]]]], body: list[str], wanted: Sequence[str]
) -> Records:
    found = None
    for name, count, properties in elements:
        rows, body = body[:count], body[count:]
        if name == "vertex":
            if len(rows) < count or any(known[0] == "list" for known in properties):
                raise Unsure
            table = [[number_in(field) for field in row.split()] for row in rows]
            if {len(row) for row in table} != {len(properties)}:
                raise ValueError("rows of other widths")
            found = np.array(table)[:, _wanted_of(properties, wanted)]
    if found is None:
        raise ValueError("no vertices")
    return found


def _ply_binary(
    elements: list[tuple[str, int, list[list[str]]]],
    content: bytes,
    at: int,
    order: str,
    wanted: Sequence[str],
) -> Records:
    found = None
    for name, count, properties in elements:
        places = _wanted_of(properties, wanted) if name == "vertex" else []
        rows = []
        for _ in range(count if properties else 0):
            row = []
            for known in properties:
                code = order + PLY_CODES[known[1] if known[0] == "list" else known[0]]
                (value,) = struct.unpack_from(code, content, at)
                at += struct.calcsize(code)
                if known[0] == "list":
                    if value < 0:
                        raise ValueError("a list of less than nothing")
                    at += value * struct.calcsize(order + PLY_CODES[known[2]])
                row.append(float(value))
            rows.append([row[place] for place in places])
        if name == "vertex":
            found = np.array(rows)
    if found is None or at > len(content):
        raise ValueError("no vertices, or not whole")
    return found


def pcd(content: bytes, wanted: Sequence[str]) -> Records:
    """All points of a PCD file."""
    end = re.search(rb"^[ \t]*DATA[ \t]+(\w+)[ \t\r\f\v]*\n", content, re.M)
    if end is None:
        raise ValueError("no DATA")
    lines = [line.split() for line in content[: end.start()].decode("latin-1").split("\n")]
    entries = {words[0]: words[1:] for words in lines if words}
    names = [name.lower() for name in entries["FIELDS"]]
    codes = [PCD_CODES[kind + size] for kind, size in zip(entries["TYPE"], entries["SIZE"], strict=True)]
    counts = [_whole(word) for word in entries.get("COUNT", ["1"] * len(names))]
    n_points = _whole(entries["WIDTH"][0]) * _whole(entries.get("HEIGHT", ["1"])[0])
    columns = [names.index(name) for name in wanted]
    body = content[end.end() :]
    if end[1] == b"ascii":
        rows = [line for line in body.decode("latin-1").split("\n")[:n_points] if line.strip()]
        if len(rows) != n_points or set(counts) != {1}:
            raise Unsure
        separator = next((sign for sign in (";", ",") if sign in rows[0]), None)
        table = [[number_in(field) for field in _fields(row, separator)] for row in rows]
        return np.array(table)[:, columns]
    runs = [f"{count}{code}" for code, count in zip(codes, counts, strict=True)]
    if end[1] == b"binary":
        record = struct.Struct("<" + "".join(runs))
        starts = [sum(counts[:column]) for column in columns]
        records = [record.unpack_from(body, number * record.size) for number in range(n_points)]
        return np.array([[float(row[start]) for start in starts] for row in records])
    plain = _unpacked(body)
    widths = [struct.calcsize("<" + run) for run in runs]
    table = [
        np.frombuffer(plain, "<" + np.dtype(codes[column]).str[1:], n_points, n_points * sum(widths[:column]))
        for column in columns
    ]
    return np.array(table, dtype=np.float64).T


def _unpacked(body: bytes) -> bytes:
    n_packed, n_plain = struct.unpack_from("<II", body)
    packed, plain, at = body[8 : 8 + n_packed], bytearray(), 0
    while at < len(packed):
        control = packed[at]
        if control < 32:
            plain += packed[at + 1 : at + 2 + control]
            at += 2 + control
            continue
        length = control >> 5
        if length == 7:
            at += 1
            length += packed[at]
        back = ((control & 31) << 8 | packed[at + 1]) + 1
        at += 2
        for _ in range(length + 2):
            plain.append(plain[-back])
    if len(plain) != n_plain:
        raise ValueError("another size")
    return bytes(plain)
