"""Read a campaign file, and say everything that is wrong with it at once."""

import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from storage.errors import InputError
from tasks.settings.campaign import FOLDER, Campaign
from tasks.settings.cross_checks import problems_between_names, problems_between_values
from tasks.settings.outline import outline_of
from tasks.settings.problems import Problem, problems_of

LARGEST_FILE_BYTES: Final = 16_000_000
"""A campaign file is written by hand; what is larger is a scan given by mistake."""

POSITION_IN_TOML: Final = re.compile(r"\s*\(at (line \d+, column \d+|end of document)\)$")


def load_campaign(path: Path) -> Campaign:
    """Read and check a campaign file; no scan is opened.

    Raises
    ------
    InputError
        One line for every problem, each ``FILE: where: what; hint``.
    """
    raw = read_toml(path)
    folder = path.absolute().parent
    problems = list(problems_between_names(outline_of(raw), folder))
    try:
        campaign = Campaign.model_validate(raw, context={FOLDER: folder})
    except ValidationError as error:
        problems = [*problems_of(error, raw, Campaign), *problems]
        raise input_error(path, problems) from error
    problems.extend(_later_problems(campaign))
    if problems:
        raise input_error(path, problems)
    return campaign


def _later_problems(campaign: Campaign) -> Iterator[Problem]:
    yield from problems_between_values(campaign)


def input_error(path: Path, problems: list[Problem]) -> InputError:
    """Make the error that says all that is wrong with a file, a line a problem."""
    return InputError("\n".join(problem.line(str(path)) for problem in problems))


def read_toml(path: Path) -> Mapping[str, object]:
    """Read a TOML file as it is.

    Raises
    ------
    InputError
        If it cannot be read, or is no TOML in UTF-8.
    """
    text = _read_text(path)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = POSITION_IN_TOML.search(str(error))
        where = found[1] if found else ""
        what = POSITION_IN_TOML.sub("", str(error))
        hint = "this is TOML: texts stand in quotes, tables in [brackets]"
        raise input_error(path, [Problem(where, what[:1].lower() + what[1:], hint)]) from error
    except RecursionError as error:
        raise input_error(path, [Problem("", "is nested too deeply to be a campaign file")]) from error


def _read_text(path: Path) -> str:
    try:
        if path.stat().st_size > LARGEST_FILE_BYTES:
            raise input_error(path, [Problem("", "is too large to be a campaign file", "give the TOML file")])
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError as error:
        hint = "`tiltwatch init KIND FILE` writes an example"
        raise input_error(path, [Problem("", "no such file", hint)]) from error
    except UnicodeDecodeError as error:
        raise input_error(path, [Problem("", "is not a text in UTF-8", "give the TOML file")]) from error
    except OSError as error:
        raise input_error(path, [Problem("", f"cannot be read: {error.strerror}")]) from error
