"""The pieces that a report is laid out of, the same on paper and on the web: everything in them is written text."""

from dataclasses import dataclass, field
from typing import Literal

Tone = Literal["", "ok", "warning", "alarm", "quality", "missing"]


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph."""

    text: str
    type: str = "text"


@dataclass(frozen=True, slots=True)
class Remark:
    """Something to mind: what, and what follows from it."""

    tone: Tone
    what: str
    consequence: str = ""
    type: str = "remark"


@dataclass(frozen=True, slots=True)
class Missing:
    """What is not there, and why."""

    what: str
    why: str
    type: str = "missing"


@dataclass(frozen=True, slots=True)
class Pairs:
    """Names and values, two columns of them."""

    pairs: tuple[tuple[str, str], ...]
    type: str = "pairs"


@dataclass(frozen=True, slots=True)
class Table:
    """A table; ``align`` has a letter a column (l, r, c), ``marked`` the rows that are stressed."""

    title: str
    head: tuple[str, ...]
    align: str
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    marked: tuple[int, ...] = ()
    small: bool = False
    type: str = "table"


@dataclass(frozen=True, slots=True)
class Chart:
    """A chart by the name of its file, with its title and what it shows in words for those who cannot see it."""

    name: str
    title: str
    note: str
    described: str
    type: str = "chart"


@dataclass(frozen=True, slots=True)
class Beside:
    """Blocks side by side; ``shares`` are their widths as parts of the whole."""

    blocks: tuple["Block", ...]
    shares: tuple[float, ...]
    type: str = "beside"


@dataclass(frozen=True, slots=True)
class SignOff:
    """Lines to sign on."""

    head: tuple[str, ...]
    roles: tuple[str, ...]
    type: str = "signoff"


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading within a section."""

    text: str
    type: str = "heading"


Block = Text | Remark | Missing | Pairs | Table | Chart | Beside | SignOff | Heading


@dataclass(frozen=True, slots=True)
class Section:
    """A chapter of the report; it begins a page on paper where ``breaks``."""

    title: str
    blocks: tuple[Block, ...]
    breaks: bool = True
    annex: bool = False


@dataclass(frozen=True, slots=True)
class Card:
    """A figure of the first page: what, how much, what it means."""

    label: str
    value: str
    note: str
    tone: Tone


@dataclass(frozen=True, slots=True)
class FirstPage:
    """The verdict for the owner."""

    tone: Tone
    icon: str
    word: str
    sentence: str
    measured_label: str
    measured: str
    limit_label: str
    limit: str
    cards: tuple[Card, ...]
    statement_label: str
    statement: tuple[str, ...]
    next_label: str
    next_steps: tuple[str, ...]
    sketch: Chart | Missing


@dataclass(frozen=True, slots=True)
class Document:
    """A whole report."""

    lang: str
    title: str
    structure: str
    subtitle: str
    date: str
    footer: str
    page_word: str
    first: FirstPage
    sections: tuple[Section, ...]
    year: int
    month: int
    day: int
    charts: dict[str, str] = field(default_factory=dict)
    """SVG by name of the chart; empty in the JSON that goes to a template, which reads files."""
