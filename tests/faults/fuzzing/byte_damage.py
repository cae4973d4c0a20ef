"""Damage that knows no format: flips, cuts, copies, splices."""

import random
import struct
from collections.abc import Callable

INTEGERS = (
    0,
    1,
    2,
    7,
    127,
    128,
    255,
    256,
    32767,
    65535,
    65536,
    2**24,
    2**31 - 1,
    2**31,
    2**32 - 1,
    2**32,
    2**53,
)
WIDE = (2**62, 2**63 - 1, 2**63, 2**64 - 1)
DOUBLES = (
    0.0, -0.0, 1.0, -1.0, 1e-4, 2e-4, 1e-320, 1e-300, 1e308, -1e308, 1e12, 1e13, 2.0**53, 1e5,
    float("nan"), float("inf"), float("-inf"),
)  # fmt: skip

Damage = Callable[[random.Random, bytes], bytes]


def flip_bits(rng: random.Random, content: bytes) -> bytes:
    """Flip one to eight bits."""
    damaged = bytearray(content)
    for _ in range(rng.choice((1, 1, 1, 2, 4, 8))):
        damaged[rng.randrange(len(damaged))] ^= 1 << rng.randrange(8)
    return bytes(damaged)


def set_byte(rng: random.Random, content: bytes) -> bytes:
    """Put another byte somewhere."""
    damaged = bytearray(content)
    damaged[rng.randrange(len(damaged))] = rng.choice(
        (0, 1, 10, 13, 26, 32, 44, 127, 128, 255, rng.randrange(256))
    )
    return bytes(damaged)


def put_number(rng: random.Random, content: bytes) -> bytes:
    """Overwrite a place with a number of a size and byte order."""
    code = rng.choice("BHIQdf")
    value: float = (
        rng.choice(DOUBLES)
        if code in "df"
        else rng.choice((*INTEGERS, *WIDE)) % (1 << 8 * struct.calcsize(code))
    )
    if code == "f" and abs(value) > 1e38:
        value = float("inf")
    raw = struct.pack(rng.choice("<>") + code, value)
    at = rng.randrange(max(1, len(content) - len(raw)))
    return content[:at] + raw + content[at + len(raw) :]


def cut(rng: random.Random, content: bytes) -> bytes:
    """Cut the end off, mostly a little of it."""
    n_bytes = rng.choice((1, 2, 3, 4, 8, 16, rng.randrange(1, 64), rng.randrange(1, len(content) + 1)))
    return content[: max(0, len(content) - n_bytes)]


def drop_slice(rng: random.Random, content: bytes) -> bytes:
    """Take some bytes out."""
    at, n_bytes = rng.randrange(len(content)), rng.choice((1, 2, 4, 8, rng.randrange(1, 200)))
    return content[:at] + content[at + n_bytes :]


def repeat_slice(rng: random.Random, content: bytes) -> bytes:
    """Write some bytes twice, or many times."""
    at, n_bytes = rng.randrange(len(content)), rng.choice((1, 4, 16, rng.randrange(1, 400)))
    piece = content[at : at + n_bytes]
    return content[:at] + piece * rng.choice((2, 2, 2, 3, 50)) + content[at + n_bytes :]


def insert(rng: random.Random, content: bytes) -> bytes:
    """Put bytes in between."""
    at = rng.randrange(len(content) + 1)
    piece = rng.choice((b"\0", b"\0" * 16, b"\n", b"\r\n", b"\xff" * 8, rng.randbytes(rng.randrange(1, 32))))
    return content[:at] + piece + content[at:]


def append(rng: random.Random, content: bytes) -> bytes:
    """Put bytes behind the end."""
    return content + rng.choice(
        (b"\0", b"\n", b"\r\n\r\n", bytes(1024), content, rng.randbytes(rng.randrange(1, 300)))
    )


def swap_slices(rng: random.Random, content: bytes) -> bytes:
    """Exchange two pieces of the same length."""
    n_bytes = rng.choice((1, 4, 8, 32))
    if len(content) < 2 * n_bytes + 2:
        return content[::-1]
    first = rng.randrange(len(content) // 2 - n_bytes + 1)
    second = rng.randrange(len(content) // 2, len(content) - n_bytes)
    damaged = bytearray(content)
    damaged[first : first + n_bytes], damaged[second : second + n_bytes] = (
        content[second : second + n_bytes],
        content[first : first + n_bytes],
    )
    return bytes(damaged)


def clear_slice(rng: random.Random, content: bytes) -> bytes:
    """Make a piece zeros, as a disk does that lost it."""
    at, n_bytes = rng.randrange(len(content)), rng.choice((4, 64, 512, 4096))
    piece = content[at : at + n_bytes]
    return content[:at] + bytes(len(piece)) + content[at + n_bytes :]


ANYWHERE: tuple[Damage, ...] = (
    flip_bits, flip_bits, set_byte, put_number, cut, drop_slice, repeat_slice, insert, append, swap_slices, clear_slice,
)  # fmt: skip


def splice(rng: random.Random, content: bytes, other: bytes) -> bytes:
    """Begin as one file and go on as another."""
    first = rng.randrange(len(content) + 1)
    second = rng.choice((first, rng.randrange(len(other) + 1)))
    return content[:first] + other[second:]
