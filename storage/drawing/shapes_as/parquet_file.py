"""A drawing as Parquet: a row a shape; what the coordinates are stands in the metadata of the file."""

from typing import Final

import pyarrow as pa

from storage.arrow_columns import arrow_column
from storage.drawing.content import Drawing, Value
from storage.drawing.plain_columns import COORDINATES, columns_of_drawing
from storage.parquet import ARROW_TYPES, encode_table

NAME: Final = "parquet"


def encode(drawing: Drawing) -> bytes:
    """Parquet of a drawing, a column a coordinate or attribute."""
    columns = columns_of_drawing(drawing)
    kinds = {name: _kind(name, values) for name, values in columns.items()}
    arrays = [arrow_column(_as_kind(values, kinds[name]), kinds[name]) for name, values in columns.items()]
    metadata = {"tiltwatch": drawing.what, "frame": drawing.frame.meaning}
    return encode_table(pa.Table.from_arrays(arrays, schema=pa.schema(kinds.items(), metadata=metadata)))


def _kind(name: str, values: list[Value]) -> pa.DataType:
    """Type of a column, by its values: what is a number here or there is a float, what is never there is one, too."""
    found = {type(value) for value in values if value is not None}
    if found <= {int, float}:
        return ARROW_TYPES[int] if found == {int} and name not in COORDINATES else ARROW_TYPES[float]
    return ARROW_TYPES[found.pop()] if len(found) == 1 else ARROW_TYPES[str]


def _as_kind(values: list[Value], kind: pa.DataType) -> list[Value]:
    if kind == ARROW_TYPES[str]:
        return [None if value is None else str(value) for value in values]
    return values
