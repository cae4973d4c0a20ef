"""Damage to the words of text headers: PLY, PCD, and the ten lines of PTX."""

import random
from collections.abc import Callable

from tests.faults.fuzzing.text_damage import NUMBERS

PLY_WORDS = (
    b"char", b"uchar", b"short", b"ushort", b"int", b"uint", b"float", b"double", b"int64", b"uint64", b"float16", b"list",
    b"list uchar int", b"list float int", b"list int double", b"list char int", b"vertex", b"x", b"y", b"z", b"ascii",
    b"binary_little_endian", b"binary_big_endian", b"1.0", b"2.0", b"element", b"property", b"comment", b"obj_info",
    b"end_header", b"ply", b"format", b"",
)  # fmt: skip
PLY_LINES = (
    b"element vertex 3\n", b"element edge 1000000000000\n", b"element edge 5\nproperty int a\n",
    b"property list int int a\n",    b"property double w\n", b"comment " + b"x" * 2000 + b"\n",
    b"property float x\n", b"element face 0\n", b"end_header\n",
)  # fmt: skip
PCD_WORDS = (
    b"x", b"y", b"z", b"_", b"F", b"U", b"I", b"4", b"8", b"2", b"1", b"0", b"3", b".6", b".5", b"0.7", b"ascii", b"binary",
    b"binary_compressed", b"FIELDS", b"SIZE", b"COUNT", b"WIDTH", b"POINTS", b"DATA", b"#", b"-1", b"1000000000", b"",
)  # fmt: skip
PCD_LINES = (
    b"COUNT 1 1 1 1000000000\n",
    b"HEIGHT 0\n",
    b"POINTS 25\n",
    b"# a\n",
    b"VIEWPOINT 0 0 0 2 0 0 0\n",
    b"WIDTH 25\n",
)
PTX_LINES = (
    b"-1 0 0 0\n", b"0 0 0 1\n", b"1 2 3 1\n", b"nan nan nan nan\n", b"1e308 0 0 0\n", b"2 0 0 0\n", b"0 0\n", b"0 -1 0 0\n",
)  # fmt: skip

Damage = Callable[[random.Random, bytes], bytes]


def _head_end(content: bytes) -> int:
    """The byte behind the header of a PLY or PCD file, or the first 300."""
    for mark in (b"end_header\n", b"DATA ascii\n", b"DATA binary\n", b"DATA binary_compressed\n"):
        at = content.find(mark)
        if at >= 0:
            return at + len(mark)
    return min(len(content), 300)


def _words_changed(known: tuple[bytes, ...], new_lines: tuple[bytes, ...]) -> Damage:
    def header_words(rng: random.Random, content: bytes) -> bytes:
        end = _head_end(content)
        lines = content[:end].splitlines(keepends=True) or [b"\n"]
        at = rng.randrange(len(lines))
        deed = rng.randrange(6)
        if deed == 0:
            lines.insert(at, rng.choice(new_lines))
        elif deed == 1:
            del lines[at]
        elif deed == 2:
            lines[at], lines[-1 - at] = lines[-1 - at], lines[at]
        else:
            words = lines[at].split()
            if words:
                words[rng.randrange(len(words))] = rng.choice((*known, rng.choice(NUMBERS).encode()))
            lines[at] = b" ".join(words) + b"\n"
        return b"".join(lines) + content[end:]

    return header_words


def ptx_header(rng: random.Random, content: bytes) -> bytes:
    """Another line among the ten of a scan, or another number in them."""
    lines = content.splitlines(keepends=True)
    at = rng.randrange(min(10, len(lines)) or 1) if lines else 0
    if not lines:
        return b"1\n1\n"
    if rng.random() < 0.5:
        lines[at] = rng.choice(PTX_LINES)
    else:
        words = lines[at].split() or [b"0"]
        words[rng.randrange(len(words))] = rng.choice(
            (*NUMBERS, "0.99999", "1.00001", "-1", "0.5", "25", "24")
        ).encode()
        lines[at] = b" ".join(words) + b"\n"
    return b"".join(lines)


IN_PLY: tuple[Damage, ...] = (_words_changed(PLY_WORDS, PLY_LINES),)
IN_PCD: tuple[Damage, ...] = (_words_changed(PCD_WORDS, PCD_LINES),)
IN_PTX: tuple[Damage, ...] = (ptx_header,)
