"""Damage to lines of text: numbers that are none, counts that lie, line ends, encodings."""

import random
import re
from collections.abc import Callable

NUMBERS = (
    "nan", "NaN", "-nan", "inf", "-Infinity", "1e308", "-1e308", "1e999", "1e-320", "-0.0", "0", "0x1p3", "0x10", "1_000",
    "1,5", "1.5.2", "--1", "+1", "+", "-", "1e", "1e400", "1d5", "1.0f", "1E+01", ".5", "5.", "1e5", "1e7", "1e13", "true",
    "None", "1j", "(1)", "#1", "//", '"1"', "'1'", "\u00b2", "\uff11\uff12", "\u0663", "\u2212" + "5", "1\u00a0000", "1\x85",
    "\ufeff1", "\x00", "\x1a", "\x0b1", "\x0c", "9" * 400, "9" * 5000, "0" * 5000 + "1", "1." + "3" * 70_000,
    "4294967296", "9223372036854775808", "18446744073709551617", "-1", "2147483648", "999999999999999999", "1e3",
)  # fmt: skip
NUMBER = re.compile(rb"[-+]?\d+(\.\d+)?([eE][-+]?\d+)?")

Damage = Callable[[random.Random, bytes], bytes]


def other_number(rng: random.Random, content: bytes) -> bytes:
    """Put another token where a number stands."""
    found = list(NUMBER.finditer(content))
    if not found:
        return content + rng.choice(NUMBERS).encode()
    hit = rng.choice(found[: rng.choice((3, 12, len(found)))])
    return (
        content[: hit.start()]
        + rng.choice(NUMBERS).encode(rng.choice(("utf-8", "utf-8", "utf-16")))
        + content[hit.end() :]
    )


def changed_count(rng: random.Random, content: bytes) -> bytes:
    """Make a whole number one more, one less, or a lie."""
    found = [hit for hit in NUMBER.finditer(content) if hit[0].isdigit()][:10]
    if not found:
        return content
    hit = rng.choice(found)
    value = int(hit[0][:18])
    new = rng.choice((value + 1, max(0, value - 1), value * 2, 0, 10**9, 10**15, 2**31, 2**63, value * 1000))
    return content[: hit.start()] + str(new).encode() + content[hit.end() :]


def _with_lines(change: Callable[[random.Random, list[bytes]], list[bytes]]) -> Damage:
    def damage(rng: random.Random, content: bytes) -> bytes:
        return b"".join(change(rng, content.splitlines(keepends=True) or [b""]))

    damage.__name__ = getattr(change, "__name__", "lines").lstrip("_")
    return damage


def _without_line(rng: random.Random, lines: list[bytes]) -> list[bytes]:
    at = rng.randrange(len(lines))
    return lines[:at] + lines[at + 1 :]


def _line_twice(rng: random.Random, lines: list[bytes]) -> list[bytes]:
    at = rng.randrange(len(lines))
    return lines[: at + 1] + [lines[at]] * rng.choice((1, 1, 5)) + lines[at + 1 :]


def _lines_swapped(rng: random.Random, lines: list[bytes]) -> list[bytes]:
    first, second = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[first], lines[second] = lines[second], lines[first]
    return lines


def _line_between(rng: random.Random, lines: list[bytes]) -> list[bytes]:
    at = rng.randrange(len(lines) + 1)
    new = rng.choice(
        (
            b"\n",
            b"  \t\n",
            b"\r",
            b"# a comment\n",
            b"1 2 3\n",
            b"1 2\n",
            b"7\n",
            b"x y z\n",
            b"\0\n",
            b"//\n",
            b"a" * 70_000,
        )
    )
    return [*lines[:at], new, *lines[at:]]


def _without_end(_rng: random.Random, lines: list[bytes]) -> list[bytes]:
    return [*lines[:-1], lines[-1].rstrip(b"\r\n")]


def _column_dropped(rng: random.Random, lines: list[bytes]) -> list[bytes]:
    at = rng.randrange(len(lines))
    fields = re.split(rb"([;,\s]+)", lines[at])
    if len(fields) > 2:
        place = 2 * rng.randrange(len(fields) // 2)
        del fields[place : place + 2]
    lines[at] = b"".join(fields)
    return lines


def _words_swapped(rng: random.Random, lines: list[bytes]) -> list[bytes]:
    at = rng.randrange(min(len(lines), 12))
    words = lines[at].split(b" ")
    rng.shuffle(words)
    lines[at] = b" ".join(words)
    return lines


def line_ends(rng: random.Random, content: bytes) -> bytes:
    """Write other line ends."""
    new = rng.choice(
        (b"\r\n", b"\r", b"\n\n", b"\n\r", b"\x85", b"\x0b", b"\x0c\n", b" \n", b"\t\r\n", b"\xe2\x80\xa8")
    )
    return content.replace(b"\n", new, rng.choice((-1, -1, 1)))


def encoded(rng: random.Random, content: bytes) -> bytes:
    """Write the text in another encoding."""
    text = content.decode("latin-1")
    return rng.choice(
        (
            b"\xef\xbb\xbf" + content,
            text.encode("utf-16"),
            text.encode("utf-16-be"),
            text.encode("utf-32"),
            b"\xef\xbb\xbf" * 2 + content,
        )
    )


def separators(rng: random.Random, content: bytes) -> bytes:
    """Write other separators."""
    old, new = (
        rng.choice((b" ", b",", b";", b".")),
        rng.choice((b" ", b",", b";", b"\t", b"  ", b", ", b"\xa0", b",,", b"|")),
    )
    return content.replace(old, new, rng.choice((-1, -1, 1, 30)))


def long_line(rng: random.Random, content: bytes) -> bytes:
    """Make one line very long."""
    at = rng.randrange(len(content) + 1)
    return (
        content[:at]
        + rng.choice((b" ", b"0", b"1 ", b"x", b",")) * rng.choice((5000, 66_000, 300_000))
        + content[at:]
    )


IN_TEXT: tuple[Damage, ...] = (
    other_number, other_number, other_number, changed_count, changed_count, _with_lines(_without_line),
    _with_lines(_line_twice), _with_lines(_lines_swapped), _with_lines(_line_between), _with_lines(_without_end),
    _with_lines(_column_dropped), _with_lines(_words_swapped), line_ends, encoded, separators, long_line,
)  # fmt: skip
