"""Damage to LAS and LAZ by field: header, variable length records, the tables of LASzip."""

import random
import struct
from collections.abc import Callable

from tests.faults.fuzzing.byte_damage import DOUBLES, INTEGERS, WIDE

FIELDS = (
    ("file source", 4, "H"), ("encoding", 6, "H"), ("major", 24, "B"), ("minor", 25, "B"), ("header size", 94, "H"),
    ("offset to points", 96, "I"), ("number of VLRs", 100, "I"), ("format", 104, "B"), ("record length", 105, "H"),
    ("legacy count", 107, "I"), ("legacy returns", 111, "I"), ("scale x", 131, "d"), ("scale y", 139, "d"),
    ("scale z", 147, "d"), ("offset x", 155, "d"), ("offset y", 163, "d"), ("offset z", 171, "d"), ("max x", 179, "d"),
    ("min x", 187, "d"), ("max z", 211, "d"), ("waveforms at", 227, "Q"), ("EVLRs at", 235, "Q"),
    ("number of EVLRs", 243, "I"), ("count", 247, "Q"), ("returns", 255, "Q"),
)  # fmt: skip
VLR_FIELDS = ((0, "H"), (18, "H"), (20, "H"))
LASZIP_FIELDS = (
    (0, "H"),
    (2, "H"),
    (4, "B"),
    (8, "I"),
    (12, "I"),
    (16, "q"),
    (24, "q"),
    (32, "H"),
    (34, "H"),
    (36, "H"),
    (38, "H"),
)

Damage = Callable[[random.Random, bytes], bytes]


def other_value(rng: random.Random, code: str, old: float, n_bytes: int) -> float:
    """A value for a field: near the old one, at an edge, or near the size of the file."""
    if code == "d":
        return rng.choice((*DOUBLES, old * 2.0, old * 10.0, -old, old + 0.5))
    near = (
        old + 1,
        old - 1,
        old * 2,
        old // 2,
        n_bytes,
        n_bytes - 1,
        n_bytes + 1,
        old ^ (1 << rng.randrange(8)),
    )  # type: ignore[operator]
    value = rng.choice((*near, *near, *INTEGERS, *WIDE))
    n_bits = 8 * struct.calcsize(code)
    value %= 1 << n_bits
    return value - (1 << n_bits) if code.islower() and value >= 1 << (n_bits - 1) else value


def put_other(rng: random.Random, content: bytes, at: int, code: str) -> bytes:
    """Another value in a field of a little-endian header."""
    n_bytes = struct.calcsize(code)
    if at < 0 or at + n_bytes > len(content):
        return content
    (old,) = struct.unpack_from("<" + code, content, at)
    new = struct.pack("<" + code, other_value(rng, code, old, len(content)))
    return content[:at] + new + content[at + n_bytes :]


def header_field(rng: random.Random, content: bytes) -> bytes:
    """A lie in the header."""
    _, at, code = rng.choice(FIELDS)
    return put_other(rng, content, at, code)


def two_counts(rng: random.Random, content: bytes) -> bytes:
    """The same lie in both counts of points."""
    if len(content) < 375:
        return header_field(rng, content)
    (legacy,), (count,) = struct.unpack_from("<I", content, 107), struct.unpack_from("<Q", content, 247)
    new = max(0, (count or legacy) + rng.choice((-1, 1, -5, 100, 10**6, 10**9, 2**40)))
    damaged = bytearray(content)
    struct.pack_into("<I", damaged, 107, new % 2**32 if legacy else 0)
    if content[25] >= 4:
        struct.pack_into("<Q", damaged, 247, new % 2**64)
    return bytes(damaged)


def vlr_field(rng: random.Random, content: bytes) -> bytes:
    """A lie in the head of a variable length record, or its content."""
    places = list(vlr_places(content))
    if not places:
        return header_field(rng, content)
    at = rng.choice(places)
    if rng.random() < 0.5:
        return put_other(rng, content, at + rng.choice((0, 18, 20)), "H")
    return put_other(rng, content, at + 54 + rng.randrange(40), rng.choice("BHI"))


def laszip_field(rng: random.Random, content: bytes) -> bytes:
    """A lie in the record of LASzip, or in its table of chunks."""
    at = content.find(b"laszip encoded")
    if at < 0:
        return vlr_field(rng, content)
    if rng.random() < 0.5:
        place, code = rng.choice(LASZIP_FIELDS)
        return put_other(rng, content, at - 2 + 54 + place, code)
    return _chunk_table(rng, content)


def _chunk_table(rng: random.Random, content: bytes) -> bytes:
    (points_at,) = struct.unpack_from("<I", content, 96)
    if points_at + 8 > len(content):
        return content
    if rng.random() < 0.4:
        return put_other(rng, content, points_at, "q")
    (table_at,) = struct.unpack_from("<q", content, points_at)
    return put_other(rng, content, table_at + rng.choice((0, 4, 4, 8, 9)), rng.choice("BI"))


def vlr_places(content: bytes) -> list[int]:
    """Where the variable length records begin, by the header's word."""
    if len(content) < 227:
        return []
    (at,), (n_vlrs,) = struct.unpack_from("<H", content, 94), struct.unpack_from("<I", content, 100)
    places = []
    while len(places) < min(n_vlrs, 20) and at + 54 <= len(content):
        places.append(at)
        at += 54 + struct.unpack_from("<H", content, at + 20)[0]
    return places


IN_LAS: tuple[Damage, ...] = (
    header_field,
    header_field,
    header_field,
    two_counts,
    vlr_field,
    laszip_field,
    laszip_field,
)
