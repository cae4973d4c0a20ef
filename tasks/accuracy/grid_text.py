"""Numbers and aligned lines of plain text for the tables."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

NO_VALUE: Final = "--"
"""What the paper prints where there is no value."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line of a table: what it shows, and a text for each column."""

    label: str
    cells: tuple[str, ...]


def number(value: float | None, decimals: int, factor: float = 1.0) -> str:
    """Write a number with fixed decimals, after a change of unit by ``factor``."""
    return NO_VALUE if value is None else f"{factor * value:.{decimals}f}"


def degrees_minutes_seconds(angle_deg: float | None) -> str:
    """Write an angle as 0°34'58" to the nearest second, with a minus where it is negative."""
    if angle_deg is None:
        return NO_VALUE
    seconds = round(abs(angle_deg) * 3600.0)
    sign = "-" if angle_deg < 0.0 and seconds else ""
    return f"{sign}{seconds // 3600}°{seconds // 60 % 60:02d}'{seconds % 60:02d}\""


def grid(title: str, columns: Sequence[str], lines: Sequence[Line]) -> list[str]:
    """Lines of a table: title, header, then a line each, labels to the left and cells to the right."""
    table = [Line("", tuple(columns)), *lines]
    label_width = max(len(line.label) for line in table)
    widths = [max(len(line.cells[k]) for line in table) for k in range(len(columns))]
    body = [
        "  ".join(
            [line.label.ljust(label_width), *(c.rjust(w) for c, w in zip(line.cells, widths, strict=True))]
        )
        for line in table
    ]
    return [title, *(text.rstrip() for text in body)]
