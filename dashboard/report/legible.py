"""Text of users as it can be printed: what the shipped fonts cannot show, or what would hide or turn text, is spelt out."""

import unicodedata
from functools import cache
from typing import Final

from matplotlib.ft2font import FT2Font

from dashboard.report.charts.style import FONTS

SHOWN_AS_SPACE: Final = "\u00a0\u2007\u2009"


def legible(text: str) -> str:
    """Spell out what cannot be printed: a line break as a backslash and an n, a sign without a glyph by its number."""
    known = _glyphs()
    return "".join(sign if ord(sign) in known and not _is_control(sign) else _spelt(sign) for sign in text)


def _spelt(sign: str) -> str:
    if sign in SHOWN_AS_SPACE:
        return " "
    if sign in "\n\r\t":
        return {"\n": "\\n", "\r": "\\r", "\t": "\\t"}[sign]
    return f"[U+{ord(sign):04X}]"


def _is_control(sign: str) -> bool:
    """Whether a sign has no shape of its own, as marks that turn the direction of writing."""
    return unicodedata.category(sign) in ("Cc", "Cf", "Cs", "Zl", "Zp")


@cache
def _glyphs() -> frozenset[int]:
    """Characters that both weights of one of the families have."""
    inter = [_of(name) for name in ("TiltwatchInter-Regular.otf", "TiltwatchInter-SemiBold.otf")]
    chinese = [_of(name) for name in ("TiltwatchNotoSC-Regular.otf", "TiltwatchNotoSC-SemiBold.otf")]
    return (inter[0] & inter[1]) | (chinese[0] & chinese[1])


def _of(name: str) -> frozenset[int]:
    return frozenset(FT2Font(str(FONTS / name)).get_charmap())


def label(text: str, most: int = 18) -> str:
    """Text of users for a drawing: legible, and cut where it is long."""
    whole = legible(text)
    return whole if len(whole) <= most else f"{whole[: most - 1]}…"
