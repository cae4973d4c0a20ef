"""How a stored column says what it is."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from datetime import datetime
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

COLUMN_TYPES = (bool, int, float, str, datetime)


@dataclass(frozen=True, slots=True)
class Column:
    """Unit and meaning of a stored column; ``unit`` is "" for counts, names and states, "1" for ratios."""

    meaning: str
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Field:
    """A column of a record class: its name, Python type, whether it may be missing, unit and meaning."""

    name: str
    python_type: type
    nullable: bool
    unit: str
    meaning: str


def columns_of(record: type) -> Iterator[Field]:
    """List the columns of a record class in their order.

    Raises
    ------
    TypeError
        If a field carries no ``Column`` annotation or a type that is not stored.
    """
    hints = get_type_hints(record, include_extras=True)
    for field in fields(record):
        yield _column(record, field.name, hints[field.name])


def _column(record: type, name: str, hint: Any) -> Field:
    base, *notes = get_args(hint) or (hint,)
    column = next((note for note in notes if isinstance(note, Column)), None)
    if column is None:
        raise TypeError(f"{record.__name__}.{name} needs an Annotated[..., Column(...)]")
    kinds = list(get_args(base)) if get_origin(base) in (Union, UnionType) else [base]
    nullable = type(None) in kinds
    python_type = next(t for t in kinds if t is not type(None))
    if python_type not in COLUMN_TYPES:
        raise TypeError(f"{record.__name__}.{name} has type {python_type}; stored are {COLUMN_TYPES}")
    return Field(name, python_type, nullable, column.unit, column.meaning)
