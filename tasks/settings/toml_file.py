"""Read a TOML file that people write by hand."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Final

from storage.errors import InputError
from tasks.settings.problems import MOST_PROBLEMS, Problem
from tasks.settings.toml_values import DOTTED, value_problems

LARGEST_FILE_BYTES: Final = 16_000_000
"""A campaign file is written by hand; what is larger is a scan given by mistake."""

LARGEST_SIDECAR_BYTES: Final = 64_000
"""A sidecar is a table; it may come from elsewhere, and takes a thousandth of this."""

POSITION_IN_TOML: Final = re.compile(r"\s*\(at (line \d+, column \d+|end of document)\)$")


@dataclass(frozen=True, slots=True)
class FileKind:
    """What a file is meant to be, and what to do where it is missing."""

    name: str
    hint: str
    largest_bytes: int = LARGEST_FILE_BYTES


CAMPAIGN_FILE: Final = FileKind("campaign file", "`tiltwatch init KIND FILE` writes an example")
SIDECAR: Final = FileKind("sidecar", "docs/watch.md has an example", LARGEST_SIDECAR_BYTES)
LIMIT_FILE: Final = FileKind("file of limits", "docs/limits.md has an example")


def input_error(path: Path, problems: list[Problem]) -> InputError:
    """Make the error that says all that is wrong with a file, a line a problem."""
    return InputError("\n".join(problem.line(str(path)) for problem in problems))


def read_toml(path: Path, kind: FileKind = CAMPAIGN_FILE) -> Mapping[str, object]:
    """Read a TOML file as it is.

    Raises
    ------
    InputError
        If it cannot be read, is no TOML in UTF-8, or holds values that no settings have.
    """
    raw = _parse(path, kind, _read_text(path, kind))
    problems = list(islice(value_problems(raw), MOST_PROBLEMS))
    if problems:
        raise input_error(path, problems)
    return raw


def _parse(path: Path, kind: FileKind, text: str) -> Mapping[str, object]:
    if DOTTED.search(text):
        raise input_error(path, [Problem("", f"has keys that are too deep to be a {kind.name}")])
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = POSITION_IN_TOML.search(str(error))
        where = found[1] if found else ""
        what = POSITION_IN_TOML.sub("", str(error))
        hint = "this is TOML: texts stand in quotes, tables in [brackets]"
        raise input_error(path, [Problem(where, what[:1].lower() + what[1:], hint)]) from error
    except ValueError as error:
        # Python reads no whole number of more than 4300 digits
        what = "holds a whole number of thousands of digits"
        raise input_error(path, [Problem("", what, "is a digit typed too often?")]) from error
    except RecursionError as error:
        raise input_error(path, [Problem("", f"is nested too deeply to be a {kind.name}")]) from error


def _read_text(path: Path, kind: FileKind) -> str:
    try:
        if path.stat().st_size > kind.largest_bytes:
            raise input_error(path, [Problem("", f"is too large to be a {kind.name}", "give the TOML file")])
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError as error:
        raise input_error(path, [Problem("", "no such file", kind.hint)]) from error
    except UnicodeDecodeError as error:
        raise input_error(path, [Problem("", "is not a text in UTF-8", "give the TOML file")]) from error
    except OSError as error:
        raise input_error(path, [Problem("", f"cannot be read: {error.strerror}")]) from error
