"""A part of a page: a drawing or a table, with the rows that it was made of."""

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TypeAlias

from dash.development.base_component import Component
from plotly.graph_objects import Figure

Cell: TypeAlias = str | int | float | bool | datetime | None


@dataclass(frozen=True, slots=True)
class Table:
    """Rows as the catalog has them: names with units, numbers unrounded, None for what does not exist."""

    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]

    def as_csv(self) -> str:
        """The table as CSV: a header, times in ISO 8601, what does not exist is empty."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([_cell(value) for value in row] for row in self.rows)
        return text.getvalue()


@dataclass(frozen=True, slots=True)
class Panel:
    """A titled part of a page.

    ``span`` is how many of the twelve columns it takes on a wide screen. ``missing`` says why there is nothing to
    show; then ``content`` is None. ``note`` is a sentence below: what the drawing does not say itself. A drawing that needs
    ``least_px`` is moved sideways on a narrower screen.
    """

    name: str
    title: str
    content: Figure | Component | Sequence[Component] | None
    table: Table | None = None
    span: int = 6
    note: str | None = None
    missing: str | None = None
    tools: Sequence[Component] = ()
    least_px: int = 0


Draw: TypeAlias = Callable[..., Panel]


def _cell(value: Cell) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, datetime):
        return value.isoformat().replace("+00:00", "Z")
    if isinstance(value, str) and value[:1] in ("=", "+", "-", "@", "\t", "\r"):
        # a spreadsheet would take it for a formula
        return f"'{value}"
    return str(value)
