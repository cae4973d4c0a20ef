"""What no value of a settings file may be, whatever its key: found before any value is shown to people."""

import re
from collections.abc import Iterator, Mapping
from typing import Final

from tasks.settings.problems import Problem
from tasks.settings.section import CONTROL

DEEPEST: Final = 32
"""Levels of tables and arrays; the settings themselves need 6."""

DOTTED: Final = re.compile(
    rf"""(?<![\w"'-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{DEEPEST + 1}}}"""
)
"""A dotted key deeper than that: the reader of TOML takes time with the square of its length."""

INT64: Final = range(-(2**63), 2**63)
"""What a whole number of TOML may be."""

MAY_BREAK: Final = str.maketrans("", "", "\n\t")
"""A longer text may have lines; names of one line are held to that by their fields."""

Place = tuple[str, ...]


def value_problems(raw: Mapping[str, object]) -> Iterator[Problem]:
    """Find whole numbers that are too large, texts with control characters, and what is nested too deeply."""
    waiting: list[tuple[Place, object]] = [((), raw)]
    while waiting:
        place, value = waiting.pop()
        if isinstance(value, Mapping | list) and len(place) > DEEPEST:
            yield Problem(_name(place[:3]), f"is nested deeper than {DEEPEST} levels", "the settings need 6")
        elif isinstance(value, Mapping):
            yield from (_bad_key(place, key) for key in value if CONTROL.search(key))
            waiting.extend(((*place, key), item) for key, item in reversed([*value.items()]))
        elif isinstance(value, list):
            waiting.extend(
                ((*place, f"#{number}"), item) for number, item in reversed([*enumerate(value, 1)])
            )
        elif isinstance(value, str) and (found := CONTROL.search(value.translate(MAY_BREAK))):
            what = f"holds the control character {found[0]!r}"
            yield Problem(_name(place), what, "write the text without it")
        elif isinstance(value, int) and value not in INT64:
            yield Problem(
                _name(place), "needs a whole number of at most 19 digits", "is a digit typed too often?"
            )


def _bad_key(place: Place, key: str) -> Problem:
    return Problem(_name(place), f"holds a control character in the key {key[:60]!r}", "drop the key")


def _name(place: Place) -> str:
    """The place as messages name it, its keys without signs that a terminal would obey."""
    return ".".join(CONTROL.sub("?", word)[:60] for word in place)
