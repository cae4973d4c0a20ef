"""A report put together: facts and words in, written blocks and charts out."""

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, Final

from dashboard import numbers
from dashboard.report.blocks import Beside, Block, Document, Missing, Section, Table
from dashboard.report.facts import Facts
from dashboard.report.legible import legible
from dashboard.report.parts import annex, comparison, course, method, owner, quality, shape
from dashboard.report.words import Words

CHAPTERS: Final[Sequence[Callable[[Facts, Words, dict[str, str]], Section]]] = (
    method.section,
    course.section,
    shape.section,
    comparison.section,
    quality.section,
    annex.section,
)
"""In the order of the pages."""

WIDEST_LETTERS: Final = 60
FIRST_WIDE: Final = 0x2E80
"""Chinese signs from here on are as wide as two letters."""


def document_of(facts: Facts, words: Words) -> Document:
    """Write a report in a language; its date is that of the publication, not of today."""
    charts: dict[str, str] = {}
    published = facts.published_at
    first = owner.first_page(facts, words, charts)
    epoch = facts.epoch.epoch
    return Document(
        lang=words.lang,
        title=words("report.title"),
        structure=facts.name,
        subtitle=words(
            "report.subtitle",
            structure=facts.structure,
            epoch=epoch,
            date=numbers.day(facts.epoch.epoch_time),
        ),
        date=words("report.date", date=numbers.day(published)),
        footer=words("report.footer", run=facts.epoch.run, program=facts.program_version),
        page_word=words("report.page"),
        first=first,
        sections=_paged([chapter(facts, words, charts) for chapter in CHAPTERS]),
        year=published.year,
        month=published.month,
        day=published.day,
        charts=charts,
    )


def _paged(sections: Sequence[Section]) -> tuple[Section, ...]:
    """A chapter of which nothing exists needs no page of its own, nor does the one behind it; the annex begins one."""
    paged: list[Section] = []
    for section in sections:
        follows_whole = not paged or paged[-1].breaks
        breaks = section.annex or (follows_whole and any(_exists(block) for block in section.blocks))
        paged.append(replace(section, breaks=breaks))
    return tuple(paged)


def _exists(block: Block) -> bool:
    return any(map(_exists, block.blocks)) if isinstance(block, Beside) else not isinstance(block, Missing)


def content_of(document: Document) -> dict[str, Any]:
    """Return a document for a template: plain JSON, every text legible, without the charts."""
    content = _plain(document)
    content.pop("charts")
    return dict(content)


def _plain(value: Any) -> Any:
    if isinstance(value, str):
        return legible(value)
    if isinstance(value, Table):
        return {
            **{field.name: _plain(getattr(value, field.name)) for field in fields(value)},
            "weights": weights_of(value),
        }
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, tuple | list):
        return [_plain(each) for each in value]
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    return value


def weights_of(table: Table) -> list[int]:
    """Width that each column asks for, in letters; one of many words may be broken into lines."""
    columns = list(zip(table.head, *table.rows, strict=True))
    return [min(max([7, *(_letters(cell) for cell in column)]), WIDEST_LETTERS) for column in columns]


def _letters(text: str) -> int:
    return sum(2 if ord(sign) >= FIRST_WIDE else 1 for sign in text)
