"""The words of the report in a language, from a file beside it; values are put in as plain text."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from storage.errors import UsageError

LANGUAGES: Final = ("en", "zh")

_NO_WORD: Final = re.compile("[^a-z0-9]+")

FOLDER: Final = Path(__file__).parent / "words"


@dataclass(frozen=True, slots=True)
class Words:
    """What is said in one language, by dotted key."""

    lang: str
    said: Mapping[str, str]

    def __call__(self, key: str, **values: str | int) -> str:
        """Say something; ``values`` take the places that are named in braces."""
        return self.said[key].format(**values)

    def named(self, group: str, name: str) -> str:
        """Say a stored word, as a state or a kind; one that has no translation is said as it is stored."""
        return self.said.get(f"{group}.{_NO_WORD.sub('_', name.lower()).strip('_')}", name)


@cache
def words_of(lang: str) -> Words:
    """Load a language.

    Raises
    ------
    UsageError
        If there is none of that name.
    """
    if lang not in LANGUAGES:
        raise UsageError(f"no report in language {lang!r}; known: {', '.join(LANGUAGES)}")
    content = tomllib.loads((FOLDER / f"{lang}.toml").read_text(encoding="utf-8"))
    return Words(
        lang, {f"{group}.{key}": text for group, table in content.items() for key, text in table.items()}
    )
