"""Damage to TOML: values of all kinds in all places, keys, tables, depth, and signs that names must not have."""

import random
import re
from collections.abc import Callable

VALUES = (
    "nan", "inf", "-inf", "1e308", "1e999", "-0.0", "0", "-1", "1", "1.0", "true", '""', '" "', '"a"', "[]", "{}", "[[]]",
    "[1.0]", "[1.0, 2.0, 3.0, 4.0]", "[nan, nan]", "9223372036854775807", "9223372036854775808", "1" + "0" * 400,
    "9" * 5000, "0x" + "f" * 5000, "0xff", "0b1", "1_000", "1.5e3", "2025-03-14", "06:00:00", "0001-01-01T00:00:00Z",
    "9999-12-31T23:59:59Z", "2025-02-30T00:00:00Z", "2025-03-14T06:00:00", "2025-03-14T25:00:00Z",
    "2025-03-14T06:00:00+23:59", "2025-03-14T06:00:00-24:00", "2024-12-31T23:59:60Z", '"../../etc/passwd"', '"/etc/passwd"',
    '"a\\nb"', '"a\\u0000b"', '"a\\u001b[31mb"', '"a\\rb"', '"\\u202Eabc"', '"\\uFEFFa"', '"<script>alert(1)</script>"',
    "\"'; drop table epochs; --\"", '"--help"', '"-rf"', '"NUL"', '"con.laz"', '"LPT1"', '"e1/../../../x.laz"',
    '"//host/x.laz"',    '"C:\\\\x.laz"', '"~/x.laz"', '"$HOME/x.laz"', '"file:///x.laz"', '"."', '".."',
    '"e1"', '"ENU"', '"NEU"', '"chimney"',
    '"' + "a" * 5000 + '"', '"\\uD800"', "[" * 60 + "]" * 60, "[" * 3000 + "]" * 3000, "{a = " * 40 + "1" + "}" * 40,
    "{" + "a." * 200 + "a = 1}", '"""a\nb"""', "'a'", "1.2.3", "= 1", "[1", '"a', "\u0663", "'\u0663'", "0.0001", "1e-320",
)  # fmt: skip
LINES = (
    "[structure]", "[[epochs]]", "[[epochs.stations]]", "[epochs]", "[[structure]]", "[limits]", "[[limits]]", "[schemes.G]",
    '[schemes."../x"]', "[schemes.NUL]", "unknown = 1", "id = 1", "a.b.c.d = 1", "a" + ".a" * 300 + " = 1",
    "[a" + ".a" * 300 + "]",    '"" = 1', "\u00e4 = 1", "x = \x00", "# \x01", "\x7f", "[notify]",
    "[[alarms]]", "[execution]", "[schedule]", "[files]",
    'roots = ["/"]', "roots = ['..']", 'file = "own.toml"', '__proto__ = "x"', "[report]", 'primary = ["Z", "surface"]',
    "interval_m = 1e-300", "interval_m = 1e-5", "schema_version = 2", "reference = true",
)  # fmt: skip
KEY_VALUE = re.compile(r"^([\w.\"-]+) = (.+)$", re.M)
NUMBER = re.compile(r"-?\d+\.\d+|-?\b\d+\b")

Damage = Callable[[random.Random, str], str]


def other_value(rng: random.Random, text: str) -> str:
    """Another value of a key."""
    hits = list(KEY_VALUE.finditer(text))
    if not hits:
        return text + rng.choice(LINES)
    hit = rng.choice(hits)
    return text[: hit.start(2)] + rng.choice(VALUES) + text[hit.end(2) :]


def other_number(rng: random.Random, text: str) -> str:
    """Another number, inside arrays too: one that may stand, or none."""
    hits = list(NUMBER.finditer(text))
    if not hits:
        return other_value(rng, text)
    hit = rng.choice(hits)
    stays = f"{rng.uniform(-400.0, 400.0):.4g}"
    new = rng.choice((stays, stays, str(rng.randrange(-2, 3000)), rng.choice(VALUES)))
    return text[: hit.start()] + new + text[hit.end() :]


def other_key(rng: random.Random, text: str) -> str:
    """Another name of a key, or a letter of it."""
    hits = list(KEY_VALUE.finditer(text))
    if not hits:
        return text + rng.choice(LINES)
    hit = rng.choice(hits)
    key = hit[1]
    new = rng.choice(
        (key[1:], key + "x", key.upper(), rng.choice(hits)[1], f"{key}.{key}", f'"{key}"', "\u00e9", "")
    )
    return text[: hit.start(1)] + new + text[hit.end(1) :]


def lines(rng: random.Random, text: str) -> str:
    """A line dropped, written twice, moved, or put in between."""
    rows = text.split("\n")
    at, deed = rng.randrange(len(rows)), rng.randrange(4)
    if deed == 0:
        del rows[at]
    elif deed == 1:
        rows.insert(at, rows[at])
    elif deed == 2:
        rows.insert(rng.randrange(len(rows)), rows.pop(at))
    else:
        rows.insert(at, rng.choice(LINES))
    return "\n".join(rows)


def tables_twice(rng: random.Random, text: str) -> str:
    """A part of the file written again, once or often."""
    starts = [hit.start() for hit in re.finditer(r"^\[", text, re.M)] or [0]
    first = rng.choice(starts)
    return text + text[first:] * rng.choice((1, 1, 2, 30))


IN_TOML: tuple[Damage, ...] = (
    other_value, other_value, other_value, other_value, other_number, other_number, other_key, lines, lines, tables_twice,
)  # fmt: skip
