"""LZF, the compression of PCD files (the format of liblzf by Marc Lehmann, as PCL writes it)."""

from typing import Final

from storage.errors import InputError

LITERAL: Final = 32
"""Control bytes below begin a run of literals, those from here on repeat what was there before."""

LONG: Final = 7
"""A length of three bits that says that another byte of length follows."""

SHORTEST: Final = 2
"""Added to every length of a repetition."""


def decompress_lzf(packed: bytes, n_bytes: int) -> bytearray:
    """Unpack exactly ``n_bytes``, and never hold more than one step of 264 bytes beyond them.

    Raises
    ------
    InputError
        If the packed bytes are damaged or hold another number of bytes; the message is a clause without the file.
    """
    out = bytearray()
    at = 0
    try:
        while at < len(packed) and len(out) <= n_bytes:
            control = packed[at]
            if control < LITERAL:
                out += packed[at + 1 : at + control + 2]
                at += control + 2
                continue
            length = (control >> 5) + SHORTEST
            if length == LONG + SHORTEST:
                at += 1
                length += packed[at]
            start = len(out) - ((control & 31) << 8) - packed[at + 1] - 1
            at += 2
            # a repetition may overlap with what it appends
            piece = out[start : start + length] if start >= 0 else b""
            out += piece if len(piece) == length else _overlapping(piece, length)
    except IndexError as error:
        raise InputError("compressed points that end within a step") from error
    if len(out) != n_bytes or at != len(packed):
        raise InputError(f"compressed points that unpack to {len(out)} bytes instead of {n_bytes}")
    return out


def _overlapping(piece: bytes | bytearray, length: int) -> bytes | bytearray:
    """``length`` bytes of a piece over and over."""
    if not piece:
        raise InputError("compressed points that refer to bytes before the first")
    return (piece * (length // len(piece) + 1))[:length]
