"""A drawing as CSV: a header, a row a shape; a last column of well-known text for GIS. NULL is empty."""

import csv
import io
from typing import Final

from storage.drawing.content import Drawing, Value
from storage.drawing.plain_columns import columns_of_drawing

NAME: Final = "csv"


def encode(drawing: Drawing) -> bytes:
    """CSV of a drawing; ``frame`` says in every row what its coordinates are."""
    columns = columns_of_drawing(drawing)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*columns, "frame"])
    for row in zip(*columns.values(), strict=True):
        writer.writerow([*map(_cell, row), drawing.frame.meaning])
    return text.getvalue().encode()


def _cell(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else str(value)
