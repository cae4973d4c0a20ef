"""Plain JSON for the dataclasses that travel between stages, and back: exact to the last bit.

Only what the stages use is known: dataclasses, arrays of float64, tuples, numbers, text, words of an enumeration, None.
Of several dataclasses that a field may hold, the names of their fields tell which one it was.
"""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import StrEnum
from functools import cache
from types import NoneType, UnionType
from typing import Any, Final, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from tasks.produced import Json

T = TypeVar("T")

PLAIN_KINDS: Final = (bool, int, float, str)


def plain(value: object) -> Json:
    """Plain JSON of a value; a Python float and its JSON text are the same number.

    Raises
    ------
    TypeError
        If the value, or a part of it, is of a kind that does not travel.
    """
    if isinstance(value, StrEnum):
        return str(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray):
        return cast("Json", value.tolist())
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    raise TypeError(f"a {type(value).__name__} does not travel between stages")


def rebuild(kind: type[T], value: object) -> T:
    """Build a dataclass from what ``plain`` made of one.

    Raises
    ------
    TypeError
        If the value does not fit the dataclass.
    """
    if not isinstance(value, Mapping):
        raise TypeError(f"{kind.__name__} needs an object, got {type(value).__name__}")
    hints = _hints_of(cast("Any", kind))
    if hints.keys() != set(value):
        raise TypeError(f"{kind.__name__} needs {sorted(hints)}, got {sorted(value)}")
    return kind(**{name: _of_hint(hint, value[name]) for name, hint in hints.items()})


@cache
def _hints_of(kind: type) -> Mapping[str, Any]:
    """Type of every field; to find them takes longer than to build the dataclass."""
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in fields(cast("Any", kind))}


def _of_hint(hint: Any, value: object) -> object:
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return None if value is None else _of_hint(_member(inner, value), value)
    if origin in (np.ndarray, NDArray):
        return np.array(value, dtype=np.float64)
    if origin is tuple:
        items = cast("list[object]", value)
        kinds = [inner[0]] * len(items) if inner[-1] is Ellipsis else list(inner)
        return tuple(_of_hint(k, item) for k, item in zip(kinds, items, strict=True))
    if is_dataclass(hint):
        return rebuild(cast("type", hint), value)
    if origin is Literal or hint in PLAIN_KINDS:
        return value
    if isinstance(hint, type) and issubclass(hint, StrEnum):
        return hint(str(value))
    raise TypeError(f"a field of type {hint} does not travel between stages")


def _member(inner: tuple[Any, ...], value: object) -> Any:
    """The member of a union that a value was: the dataclass with these fields, else the first that is not None."""
    members = [member for member in inner if member is not NoneType]
    if not isinstance(value, Mapping):
        return members[0]
    fitting = (m for m in members if is_dataclass(m) and {field.name for field in fields(m)} == set(value))
    return next(fitting, members[0])
