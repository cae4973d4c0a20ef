"""How errors are told: lines on stderr, an object on stdout for programs, a log file for faults of the program."""

import os
import sys
import tempfile
import traceback
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import Final

from flows.terminal import TRACEBACK_VERBOSITY, answer, complain, terminal
from flows.version import VERSION

FAULT: Final = 1


def report_error(message: str, exit_code: int, *, wants_json: bool) -> int:
    """Tell what the user can mend, one ``error:`` line a problem, and return the exit code."""
    lines = message.splitlines()
    complain(*(f"error: {line}" for line in lines))
    return answer(exit_code, {"errors": lines}) if wants_json else exit_code


def report_fault(error: BaseException, *, wants_json: bool) -> int:
    """Tell a fault of the program in one line, with the path of the log that holds the traceback."""
    details = "".join(traceback.format_exception(error))
    if terminal().verbosity >= TRACEBACK_VERBOSITY:
        complain(details)
    what = str(error).splitlines()[0] if str(error) else "no message"
    message = (
        f"this is a fault of tiltwatch: {type(error).__name__}: {what}; traceback in {keep_log(details)}"
    )
    return report_error(message, FAULT, wants_json=wants_json)


def keep_log(details: str) -> str:
    """Write a traceback to a log file and return its path, or say that no folder can be written."""
    name = f"tiltwatch-{datetime.now(UTC):%Y%m%dT%H%M%SZ}-{os.getpid()}"
    text = f"tiltwatch {VERSION}, python {sys.version}, {sys.platform}\ncall: {sys.argv}\n\n{details}"
    for folder in (terminal().log_folder, Path(tempfile.gettempdir())):
        if folder is None:
            continue
        try:
            folder.mkdir(exist_ok=True)  # a workspace that is not there is not made for a log
            path = _written_beside_others(folder, name, text)
        except OSError:
            continue
        return str(path)
    return "no file: neither the workspace nor the folder for temporary files can be written"


def _written_beside_others(folder: Path, name: str, text: str) -> Path:
    """Write a log under a name that none has: two faults of a second, or of a clock that was set back, are two logs."""
    for number in count(1):
        path = folder / (f"{name}.log" if number == 1 else f"{name}.{number}.log")
        try:
            with path.open("x", encoding="utf-8") as file:
                file.write(text)
        except FileExistsError:
            continue
        break
    return path
