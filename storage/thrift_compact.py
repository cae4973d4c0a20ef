"""Thrift's compact protocol, as far as Parquet writes its footer and its page headers in it.

pyarrow ends the whole process when a footer contradicts itself (an exception of C++ that its metadata objects do not
catch), so what must be known of a file that anyone may have written is read here.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

MOST_VALUES: Final = 300_000
"""In one struct with all that it holds: a footer of 1 MiB with statistics has as many."""

DEEPEST: Final = 16
"""Structs and lists within each other; a footer has seven."""

LONGEST_NUMBER: Final = 10
"""Bytes of an integer of 64 bits."""

TRUE, FALSE, BYTE, I16, I32, I64, DOUBLE, BINARY, LIST, SET, STRUCT = 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12

Value: TypeAlias = "int | bytes | tuple[Value, ...] | Struct"


@dataclass(frozen=True, slots=True)
class Struct:
    """A struct, its values by the number of the field."""

    fields: Mapping[int, Value]

    def number(self, field: int) -> int:
        """Integer of a field that must be there and not negative; ValueError otherwise."""
        value = self.fields.get(field)
        if not isinstance(value, int) or value < 0:
            raise ValueError(f"field {field} needs a number >= 0, came {type(value).__name__}")
        return value

    def content(self, field: int) -> bytes | None:
        """Bytes of a field, None if it is not there; ValueError if it is something else."""
        value = self.fields.get(field)
        if value is not None and not isinstance(value, bytes):
            raise ValueError(f"field {field} needs bytes, came {type(value).__name__}")
        return value

    def struct(self, field: int) -> "Struct":
        """Struct of a field, empty if it is not there; ValueError if it is something else."""
        value = self.fields.get(field, Struct({}))
        if isinstance(value, Struct):
            return value
        raise ValueError(f"field {field} needs a struct, came {type(value).__name__}")

    def structs(self, field: int) -> "tuple[Struct, ...]":
        """Structs of a list; ValueError if it is something else."""
        value = self.fields.get(field)
        items = value if isinstance(value, tuple) else ()
        found = tuple(item for item in items if isinstance(item, Struct))
        if not isinstance(value, tuple) or len(found) != len(value):
            raise ValueError(f"field {field} needs a list of structs, came {type(value).__name__}")
        return found


class CompactReader:
    """Reads one struct from the begin of some bytes; ``at`` is then where it ends."""

    def __init__(self, content: bytes) -> None:
        self.content = content
        self.at = 0
        self.n_values = 0

    def read_struct(self, depth: int = 0) -> Struct:
        """Struct at ``at``.

        Raises
        ------
        ValueError
            If there is none, or it is too large.
        """
        fields: dict[int, Value] = {}
        number = 0
        while head := self._byte():
            step, form = head >> 4, head & 15
            number = number + step if step else self._integer()
            fields[number] = self._value(form, depth)
        return Struct(fields)

    def _value(self, form: int, depth: int) -> Value:
        self.n_values += 1
        if self.n_values > MOST_VALUES or depth > DEEPEST:
            raise ValueError(f"needs at most {MOST_VALUES} values, {DEEPEST} deep, came more")
        if form in (I16, I32, I64):
            return self._integer()
        if form == BINARY:
            return self._bytes(self._varint())
        if form == STRUCT:
            return self.read_struct(depth + 1)
        if form in (LIST, SET):
            return self._list(depth + 1)
        if form in (TRUE, FALSE):
            return int(form == TRUE)
        if form in (BYTE, DOUBLE):
            return self._bytes(1 if form == BYTE else 8)
        raise ValueError(f"form {form} is none that Parquet uses")

    def _list(self, depth: int) -> tuple[Value, ...]:
        head = self._byte()
        length, form = head >> 4, head & 15
        if length == 15:
            length = self._varint()
        if form in (TRUE, FALSE):
            form = BYTE
        return tuple(self._value(form, depth) for _ in range(length))

    def _bytes(self, length: int) -> bytes:
        start, self.at = self.at, self.at + length
        if self.at > len(self.content):
            raise ValueError("it is cut short")
        return self.content[start : self.at]

    def _byte(self) -> int:
        return self._bytes(1)[0]

    def _integer(self) -> int:
        value = self._varint()
        return (value >> 1) ^ -(value & 1)

    def _varint(self) -> int:
        value = 0
        for place in range(LONGEST_NUMBER):
            byte = self._byte()
            value |= (byte & 127) << 7 * place
            if byte < 128:
                return value
        raise ValueError("a number has over 64 bits")
