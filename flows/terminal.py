"""What goes to the screen: results to stdout, everything else to stderr, one JSON object for programs."""

import json
import os
import sys
from collections.abc import Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Final, TextIO, TypeAlias

Json: TypeAlias = "bool | int | float | str | Sequence[Json] | Mapping[str, Json] | None"

TRACEBACK_VERBOSITY: Final = 2
"""From -vv on, tracebacks and the noise of libraries are shown."""

ANSWER_SCHEMA: Final = 1
"""Version of the form of all JSON answers."""


@dataclass(frozen=True, slots=True)
class Terminal:
    """What the user wants to see."""

    verbosity: int = 0
    quiet: bool = False
    color: bool = True
    log_folder: Path | None = None

    @property
    def verbose(self) -> bool:
        """Whether more than the usual is wanted."""
        return self.verbosity > 0


_terminal: ContextVar[Terminal] = ContextVar("terminal", default=Terminal())  # noqa: B039 (it is frozen)


def terminal() -> Terminal:
    """Return what the user wants to see in this call of the command line."""
    return _terminal.get()


def use_terminal(wanted: Terminal) -> None:
    """Set what the user wants to see."""
    _terminal.set(wanted)


def log_into(folder: Path) -> None:
    """Let the log of a fault go into a folder, once a command knows its workspace."""
    _terminal.set(replace(_terminal.get(), log_folder=folder))


def say(*lines: str) -> None:
    """Write lines of the result to stdout."""
    sys.stdout.writelines(f"{line}\n" for line in lines)


def note(*lines: str) -> None:
    """Write lines about the work to stderr, unless the user wants it quiet."""
    if not terminal().quiet:
        complain(*lines)


def complain(*lines: str) -> None:
    """Write lines to stderr, whatever the user wants: errors and warnings."""
    sys.stdout.flush()
    sys.stderr.writelines(f"{line}\n" for line in lines)
    sys.stderr.flush()


def answer(exit_code: int, content: Mapping[str, Json]) -> int:
    """Write the one JSON object of a command to stdout and return the exit code.

    ``ok`` is true exactly where the exit code is 0.
    """
    head: Mapping[str, Json] = {"ok": exit_code == 0, "schema": ANSWER_SCHEMA, "exit_code": exit_code}
    say(json.dumps({**head, **content}, default=_plain, allow_nan=False))
    return exit_code


def survive_any_text(stream: TextIO) -> None:
    """Let a stream of a narrow encoding replace what it cannot show, instead of failing."""
    reconfigure = getattr(stream, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="replace")


def forget_stdout() -> None:
    """Send what is left for a closed stdout nowhere, so that the end of the process is quiet."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def hush_exit() -> None:
    """Send what libraries write to stderr while the process ends nowhere; all that is ours is written by then.

    Prefect's own server complains of events that it could not flush, duckdb of objects that outlive it; neither
    means anything to the user. With -vv it is shown.
    """
    if terminal().verbosity < TRACEBACK_VERBOSITY:
        sys.stderr.flush()
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())


def _plain(value: object) -> str:
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"an answer cannot hold {type(value).__name__}")
