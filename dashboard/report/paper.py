"""The report as PDF/A by typst: its template, its fonts and the data as JSON beside; the network is never asked."""

import json
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import typst

from dashboard.report.blocks import Document
from dashboard.report.charts.style import FONTS
from dashboard.report.document import content_of

TEMPLATE: Final = Path(__file__).parent / "templates" / "report.typ"

STANDARD: Final = "a-2b"
"""PDF/A-2, basic: what archives ask for; every font is in the file."""


def pdf_of(document: Document) -> bytes:
    """Set a report on paper; the same document gives the same bytes.

    Its date is that of the document: the clock is not asked.
    """
    published = datetime(document.year, document.month, document.day, tzinfo=UTC)
    with _compiler(document) as compiler:
        made = compiler.compile(format="pdf", pdf_standards=[STANDARD], timestamp=published)
    if not isinstance(made, bytes):
        raise TypeError(f"a PDF comes as bytes; typst gave {type(made).__name__}")
    return made


def pictures_of(document: Document, dots_per_inch: float) -> list[bytes]:
    """The same pages as PNG, for people who want to see them elsewhere."""
    with _compiler(document) as compiler:
        made = compiler.compile(format="png", ppi=dots_per_inch)
    return [made] if isinstance(made, bytes) else list(made or [])


@contextmanager
def _compiler(document: Document) -> Iterator[typst.Compiler]:
    """Lay template, data and charts in a folder, and hand out what reads them and nothing else."""
    with tempfile.TemporaryDirectory(prefix="tiltwatch-report-") as folder:
        place = Path(folder)
        (place / "report.typ").write_bytes(TEMPLATE.read_bytes())
        content = json.dumps(content_of(document), ensure_ascii=False)
        (place / "document.json").write_text(content, encoding="utf-8")
        for name, svg in document.charts.items():
            (place / f"{name}.svg").write_text(svg, encoding="utf-8")
        fonts = typst.Fonts(include_system_fonts=False, include_embedded_fonts=False, font_paths=[str(FONTS)])
        yield typst.Compiler(str(place / "report.typ"), root=str(place), font_paths=fonts)
