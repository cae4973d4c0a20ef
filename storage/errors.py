"""The exceptions of tiltwatch: one root, and what the command line answers to each."""

from typing import ClassVar


class TiltwatchError(Exception):
    """Root of everything that tiltwatch raises on purpose; the message is for the user."""

    exit_code: ClassVar[int] = 1


class UsageError(TiltwatchError):
    """The words of a command do not fit together."""

    exit_code: ClassVar[int] = 2


class InputError(TiltwatchError):
    """A campaign file or a scan is bad; the message says where, what, and what to do."""

    exit_code: ClassVar[int] = 3


class StorageError(TiltwatchError):
    """A workspace cannot be read or written."""

    exit_code: ClassVar[int] = 3


class ShapeError(TiltwatchError, ValueError):
    """A function was called with arrays that do not fit: a fault of the caller."""
