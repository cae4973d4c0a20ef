"""The description of an E57 file: XML, taken apart here before any foreign library sees it.

The library would follow references to other files and addresses, and its recursion knows no bottom.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from xml.parsers import expat

from storage.errors import InputError

DEEPEST: Final = 32
"""Levels; the standard itself needs 7."""

MOST_ELEMENTS: Final = 100_000
"""A scan has about 60: over a thousand scans with images fit, and time and memory stay bounded."""


@dataclass(frozen=True, slots=True)
class Element:
    """An element of the description; ``name`` has its prefix, as in ``nor:normalX``."""

    name: str
    attributes: dict[str, str]
    children: list["Element"] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """What stands in it, without the space around."""
        return "".join(self.texts).strip()

    def child(self, *names: str) -> "Element | None":
        """The first descendant along these names, None where there is none."""
        found: Element | None = self
        for name in names:
            if found is None:
                return None
            found = next((child for child in found.children if child.name == name), None)
        return found


class _Forbidden(Exception):  # noqa: N818 - never leaves this module
    """What a description may not have."""


class _Builder:
    """Handlers of the parser; they grow the tree under ``root``."""

    def __init__(self) -> None:
        self.root = Element("", {})
        self.stack = [self.root]
        self.n_elements = 0

    def start(self, name: str, attributes: dict[str, str]) -> None:
        self.n_elements += 1
        if self.n_elements > MOST_ELEMENTS:
            raise _Forbidden(f"more than {MOST_ELEMENTS} elements")
        if len(self.stack) > DEEPEST:
            raise _Forbidden(f"elements deeper than {DEEPEST} levels")
        element = Element(name, attributes)
        self.stack[-1].children.append(element)
        self.stack.append(element)

    def end(self, _name: str) -> None:
        self.stack.pop()

    def text(self, text: str) -> None:
        self.stack[-1].texts.append(text)


def _refuse_encoding(_version: str, encoding: str | None, _standalone: int) -> None:
    if encoding is not None and encoding.upper() != "UTF-8":
        raise _Forbidden(f"the encoding {encoding[:20]}")


def _refuse_doctype(_name: str, _system: str | None, _public: str | None, _has_subset: int) -> None:
    raise _Forbidden("a DOCTYPE")


def parse_description(path: Path, content: bytes) -> Element:
    """The element ``e57Root``.

    Raises
    ------
    InputError
        If the content is no XML, or XML that no scanner writes.
    """
    builder = _Builder()
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.text
    parser.XmlDeclHandler = _refuse_encoding
    parser.StartDoctypeDeclHandler = _refuse_doctype
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, _Forbidden, ValueError) as error:
        raise InputError(
            f"{path}: needs a description (XML) as the E57 standard has it, came {error}; "
            "the file is damaged, copy or export it again"
        ) from error
    root = builder.root.children[0]
    if root.name != "e57Root":
        raise InputError(
            f"{path}: needs a description (XML) of e57Root, came {root.name[:40]!r}; export the file again"
        )
    return root
