"""Write plain tables as TOML: what a watch notes of the epochs that it takes in."""

import json
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime

from storage.errors import InputError


def toml_text(comment: str, table: Mapping[str, object]) -> str:
    """Write a table whose values are texts, numbers, times, arrays of these, and arrays of such tables.

    What is None is left out.

    Raises
    ------
    InputError
        If a value has no form in TOML.
    """
    return "\n".join([*(f"# {line}" for line in comment.splitlines()), *_lines(table, ""), ""])


def _lines(table: Mapping[str, object], above: str) -> Iterator[str]:
    for key, value in table.items():
        if value is not None and not _is_tables(value):
            yield f"{key} = {_value(value)}"
    for key, value in table.items():
        if isinstance(value, Sequence) and _is_tables(value):
            for item in value:
                yield f"\n[[{above}{key}]]"
                yield from _lines(item, f"{above}{key}.")


def _is_tables(value: object) -> bool:
    return (
        isinstance(value, list | tuple) and bool(value) and all(isinstance(item, Mapping) for item in value)
    )


def _value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # a JSON text is a TOML text, but for DEL and for characters that JSON writes as two
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, Sequence):
        return f"[{', '.join(_value(item) for item in value)}]"
    raise InputError(f"TOML has no form for {type(value).__name__}")
