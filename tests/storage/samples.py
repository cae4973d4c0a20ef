"""A row of any record class, made from its columns alone."""

from datetime import UTC, datetime, timedelta
from typing import TypeVar

from storage.records import columns_of

Row = TypeVar("Row")

VALUES = {
    bool: lambda n: n % 2 == 0,
    int: lambda n: n - 1,
    float: lambda n: (n + 1) / 3.0 * 10.0 ** (n % 7 - 3),
    str: lambda n: f"Süd-{n}'\"",
    datetime: lambda n: datetime(1969, 12, 31, 23, 59, 59, 999_999, tzinfo=UTC) + timedelta(days=n),
}


def full_row(record: type[Row], seed: int = 0) -> Row:
    fields = list(columns_of(record))
    return record(**{field.name: VALUES[field.python_type](seed + k) for k, field in enumerate(fields)})


def bare_row(record: type[Row], seed: int = 0) -> Row:
    """A row in which all that may be missing is missing."""
    values = {
        field.name: None if field.nullable else VALUES[field.python_type](seed + k)
        for k, field in enumerate(columns_of(record))
    }
    return record(**values)
