"""Make the fonts of the report: subsets of Inter and Noto Sans CJK SC under names of their own.

Of the folders of Debian's fonts-inter and fonts-noto-cjk: ``.venv/bin/python docs/make_report_fonts.py
/usr/share/fonts/opentype/inter /usr/share/fonts/opentype/noto``. The names are their own so that fonts of the same name on a
machine, whose version may be another, never take their place.
"""

import sys
from collections.abc import Iterable
from pathlib import Path

from fontTools import subset
from fontTools.ttLib import TTFont

OUT = Path(__file__).resolve().parents[1] / "dashboard" / "report" / "fonts"
SIGNS = (
    *range(0x20, 0x7F),
    *range(0xA0, 0x250),
    *range(0x370, 0x460),
    *range(0x1E00, 0x1F00),
    *range(0x2000, 0x20AD),
    *range(0x2100, 0x2600),
    0x2713,
    0x2717,
)
"""Latin, Greek, Cyrillic, punctuation, arrows, mathematics, shapes."""

SIMPLIFIED_CHINESE = 2
"""Number of that face in Noto's collection."""

SEMIBOLD = 600


def gb2312() -> set[int]:
    """All signs of GB 2312."""
    found = set()
    for first in range(0xA1, 0xF8):
        for second in range(0xA1, 0xFF):
            text = bytes([first, second]).decode("gb2312", errors="ignore")
            found.update(map(ord, text))
    return found


def make(font: TTFont, signs: Iterable[int], family: str, style: str, features: list[str]) -> None:
    """Keep these signs and features, give the font its name, and write it."""
    options = subset.Options()
    options.layout_features = features
    options.name_IDs = ["*"]
    options.notdef_outline = True
    options.hinting = False
    options.drop_tables += ["DSIG", "vhea", "vmtx", "VORG", "BASE"]
    cutter = subset.Subsetter(options)
    cutter.populate(unicodes=signs)
    cutter.subset(font)
    _rename(font, family, style)
    font["head"].modified = font["head"].created
    font.recalcTimestamp = False
    font.save(OUT / f"{family.replace(' ', '')}-{style}.otf")


def _rename(font: TTFont, family: str, style: str) -> None:
    postscript = f"{family.replace(' ', '')}-{style}"
    names = {1: family, 2: style, 3: postscript, 4: f"{family} {style}", 6: postscript}
    font["name"].names = [row for row in font["name"].names if row.nameID in (0, 5, 7, 8, 9, 11, 13, 14)]
    for number, text in names.items():
        font["name"].setName(text, number, 3, 1, 0x409)
    font["CFF "].cff.fontNames = [postscript]
    font["OS/2"].usWeightClass = 400 if style == "Regular" else SEMIBOLD


if __name__ == "__main__":
    inter, noto = Path(sys.argv[1]), Path(sys.argv[2])
    for style in ("Regular", "SemiBold"):
        kept = ["kern", "mark", "mkmk", "ccmp", "locl", "tnum"]
        make(TTFont(inter / f"Inter-{style}.otf"), SIGNS, "Tiltwatch Inter", style, kept)
    for style, weight in (("Regular", "Regular"), ("SemiBold", "Bold")):
        chinese = TTFont(noto / f"NotoSansCJK-{weight}.ttc", fontNumber=SIMPLIFIED_CHINESE)
        make(chinese, {*range(0x20, 0x180), *gb2312()}, "Tiltwatch Noto SC", style, ["kern", "locl"])
