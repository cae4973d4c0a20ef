"""Parquet files written by hand, which no library would write: three columns x, y, z of doubles over one chunk."""

import struct

I32, I64, BINARY, LIST, STRUCT = 5, 6, 8, 9, 12


def _varint(value: int) -> bytes:
    head, rest = value & 127, value >> 7
    return bytes([head | 128]) + _varint(rest) if rest else bytes([head])


def _number(step: int, value: int, form: int = I64) -> bytes:
    """Field ``step`` after the one before."""
    return bytes([step << 4 | form]) + _varint(2 * value)


def _list(step: int, form: int, items: list[bytes]) -> bytes:
    return bytes([step << 4 | LIST, 0xF0 | form]) + _varint(len(items)) + b"".join(items)


def _text(text: bytes) -> bytes:
    return _varint(len(text)) + text


def page_of(n_values: int, full_bytes: int, content: bytes, *, is_dictionary: bool = False) -> bytes:
    """A page with its header; plain values, as many as it claims or not."""
    inner = _number(1, n_values, I32) + _number(1, 0, I32)
    if not is_dictionary:
        inner += _number(1, 3, I32) + _number(1, 3, I32)
    sizes = _number(1, 2 if is_dictionary else 0, I32) + _number(1, full_bytes, I32)
    sizes += _number(1, len(content), I32)
    return sizes + bytes([(4 if is_dictionary else 2) << 4 | STRUCT]) + inner + b"\0\0" + content


def footer_of(pages: bytes, *, n_records: int, codec: int = 0, chunk_type: int = 5) -> bytes:
    """A footer with one row group whose columns all lie in the same pages, right behind the magic.

    Its statistics state numbers from 1 to 8.
    """
    root = bytes([4 << 4 | BINARY]) + _text(b"r") + _number(1, 3, I32) + b"\0"
    leaves = [
        _number(1, 5, I32) + _number(2, 0, I32) + bytes([1 << 4 | BINARY]) + _text(name) + b"\0"
        for name in (b"x", b"y", b"z")
    ]
    chunks = [
        _number(2, 4)
        + bytes([1 << 4 | STRUCT])
        + _number(1, chunk_type, I32)
        + _list(1, I32, [b"\0"])
        + _list(1, BINARY, [_text(name)])
        + _number(1, codec, I32)
        + _number(1, n_records)
        + _number(1, len(pages))
        + _number(1, len(pages))
        + _number(2, 4)
        + bytes([3 << 4 | STRUCT])
        + bytes([5 << 4 | BINARY])
        + _text(struct.pack("<d", 8.0))
        + bytes([1 << 4 | BINARY])
        + _text(struct.pack("<d", 1.0))
        + b"\0\0\0"
        for name in (b"x", b"y", b"z")
    ]
    group = _list(1, STRUCT, chunks) + _number(1, 0) + _number(1, n_records) + b"\0"
    return (
        _number(1, 2, I32)
        + _list(1, STRUCT, [root, *leaves])
        + _number(1, n_records)
        + _list(1, STRUCT, [group])
        + b"\0"
    )


def whole_file(pages: bytes, footer: bytes) -> bytes:
    return b"PAR1" + pages + footer + struct.pack("<I", len(footer)) + b"PAR1"
