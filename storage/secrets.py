"""Secrets come from the environment, or from a file that only its owner may read; never from a campaign file."""

import os
import re
import stat
from pathlib import Path
from typing import Final

from storage.errors import InputError

FILE_SUFFIX: Final = "_FILE"
"""``NAME_FILE`` names the file of the secret ``NAME``. Of a container's secrets the mode must be set: 0400."""

MOST_BYTES: Final = 65_536

_FOR_OTHERS: Final = stat.S_IRWXG | stat.S_IRWXO

_LOGIN: Final = re.compile(r"(?<=//)[^/?#]*@")


def secret_in(variable: str) -> str | None:
    """The secret in a variable of the environment, or in the file that ``variable``_FILE names; None without both.

    Raises
    ------
    InputError
        If the file cannot be read, is empty, or can be read by others.
    """
    given = os.environ.get(variable, "").strip()
    if given:
        return given
    file = os.environ.get(f"{variable}{FILE_SUFFIX}")
    return secret_of(Path(file), f"{variable}{FILE_SUFFIX}") if file else None


def secret_of(file: Path, named_by: str) -> str:
    """The secret that a file holds, without the blanks around it.

    Parameters
    ----------
    named_by
        The option or variable that names the file, for the message.

    Raises
    ------
    InputError
        If the file cannot be read, is empty, or can be read by others.
    """
    check_private(file, named_by)
    try:
        with file.open("rb") as opened:
            text = opened.read(MOST_BYTES).decode().strip()
    except OSError as fault:
        raise InputError(f"{named_by}: {file} cannot be read ({fault.strerror})") from fault
    except UnicodeDecodeError:
        # what it holds is not shown, not even as the cause
        raise InputError(f"{named_by}: {file} is no text; write the secret into it, in a line") from None
    if not text:
        raise InputError(f"{named_by}: {file} is empty; write the secret into it, in a line")
    return text


def check_private(file: Path, named_by: str) -> None:
    """Refuse a file of a secret that others than its owner may read or write.

    Raises
    ------
    InputError
        If it is no file, or others may.
    """
    try:
        mode = file.stat().st_mode
    except OSError as fault:
        raise InputError(f"{named_by}: {file} cannot be read ({fault.strerror})") from fault
    if not stat.S_ISREG(mode):
        raise InputError(f"{named_by}: {file} is no file")
    if os.name == "posix" and mode & _FOR_OTHERS:
        raise InputError(
            f"{named_by}: {file} can be read by others (mode {stat.S_IMODE(mode):03o}); `chmod 600 {file}` keeps it to "
            "you"
        )


def without_login(url: str) -> str:
    """A URL for people to read: a user and password in it are not shown."""
    return _LOGIN.sub("***@", url)


def has_login(url: str) -> bool:
    """Whether a URL carries a user or password."""
    return without_login(url) != url
