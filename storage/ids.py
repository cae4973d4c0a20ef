"""Which ids of structures, epochs and runs can be file names on every system."""

import re
from typing import Final

from storage.errors import InputError

_SAFE: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")

DEVICES: Final = frozenset(
    ["CON", "PRN", "AUX", "NUL", *(f"{port}{n}" for port in ("COM", "LPT") for n in range(10))]
)
"""Windows takes these for devices, with any extension: "NUL.parquet" is still the null device."""


def check_id(value: str, what: str) -> str:
    """Return an id that is a safe file name on Linux, macOS and Windows.

    Parameters
    ----------
    value : str
        The id.
    what : str
        What it is the id of, for the message.

    Raises
    ------
    InputError
        If the id holds other signs than letters, digits, dot, dash and underscore, is longer than 64, starts
        with another sign than a letter or digit, ends in a dot, or is the name of a Windows device.
    """
    if not _SAFE.fullmatch(value) or value.endswith("."):
        raise InputError(
            f"id {value!r} of {what} cannot be a file name; needed are 1 to 64 letters (a-z, A-Z), digits, '.', "
            "'-' and '_', beginning with a letter or digit and not ending in '.'"
        )
    if value.split(".", maxsplit=1)[0].upper() in DEVICES:
        raise InputError(
            f"id {value!r} of {what} is the name of a device on Windows; choose another, as 'e-{value}'"
        )
    return value
