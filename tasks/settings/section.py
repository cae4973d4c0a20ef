"""What every table of the campaign file has in common: strict types, no unknown keys, safe names."""

import re
from typing import Annotated, Final

from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError

from storage.errors import InputError
from storage.ids import check_id

ID_PATTERN: Final = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$"
"""Ids become names of folders and files: 1 to 64 letters, digits, dots, underscores and hyphens."""

PROBLEM: Final = "tiltwatch"
"""Type of the validation errors whose message is ours; ``hint`` stands in their context."""

CONTROL: Final = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069]")
"""Control characters, ends of lines, and what turns the direction of writing around."""

HIGHEST_M: Final = 1500.0
"""No structure is taller: the tallest tower planned so far has 1000 m. Above it, the unit is wrong."""


class Section(BaseModel):
    """A table of the campaign file: frozen, strict (no text for numbers, no NaN), unknown keys refused."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, str_strip_whitespace=True
    )


def problem(what: str, hint: str) -> PydanticCustomError:
    """Make the error that a validator raises: what is wrong, and what to do about it."""
    return PydanticCustomError(PROBLEM, "{what}", {"what": what, "hint": hint})


def _portable(name: str) -> str:
    try:
        return check_id(name, "a folder")
    except InputError as error:
        raise problem(f"{name!r} cannot name a folder on every system", "choose another") from error


def _of_one_line(text: str) -> str:
    if CONTROL.search(text):
        raise problem(
            f"needs one line of plain text, got {text[:60]!r}", "write it without control characters"
        )
    return text


Line = Annotated[str, AfterValidator(_of_one_line)]
"""A text that stands within a line of messages, tables and file names."""

SafeId = Annotated[str, Field(pattern=ID_PATTERN), AfterValidator(_portable)]
"""An id that can name a folder on every system."""

Pair = Annotated[tuple[float, float], Field(strict=False)]
"""Two numbers; strict=False lets a TOML array be a tuple, the numbers stay strict."""

Triple = Annotated[tuple[float, float, float], Field(strict=False)]
"""Three numbers."""
