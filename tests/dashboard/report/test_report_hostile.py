"""Text of users comes out as it was written, on paper and on the web."""

import re
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from dashboard.report.legible import label, legible
from dashboard.report.page import html_of
from dashboard.report.paper import pdf_of
from dashboard.report.settings import settings_of
from storage.workspace import open_workspace
from tests.dashboard.report.reported import SETTINGS, document, limited, publish, text_of

NAME = "</title><script>alert(1)</script> #panic[x] $1/0$ *b* _i_ @a <l> `r` // ${y} {z}"
REASON = '#read("/etc/passwd") {{ 7*7 }} "quoted" \'single\' -- %s'


def test_markup_of_every_kind_comes_out_literally(tmp_path: Path) -> None:
    def hostile(tables: dict[str, list[Any]]) -> None:
        limited(tables)
        tables["epochs"] = [replace(tables["epochs"][0], state="degraded", reason=REASON)]
        tables["stations"] = [
            replace(row, station=f"{row.station}<b>&", state="suspect", reason=REASON, notes=NAME)
            for row in tables["stations"]
        ]
        tables["reference_leans"] = [replace(tables["reference_leans"][0], source="<i>$x$ \n#y")]

    ws = open_workspace(tmp_path / "ws")
    publish(ws, 2, hostile)
    settings = settings_of({**SETTINGS, "structure": {**SETTINGS["structure"], "name": NAME}})
    made = document(ws, settings=settings)
    text, page = text_of(pdf_of(made)), html_of(made)
    assert NAME in text
    assert REASON in text
    assert "ST01<b>&" in text
    assert "<i>$x$ \\n#y" in text
    assert "<script" not in page
    assert "<b>" not in page
    assert NAME in unescape(page)
    assert REASON in unescape(page)


def test_the_page_asks_for_nothing_outside_of_it(tmp_path: Path) -> None:
    ws = open_workspace(tmp_path / "ws")
    publish(ws, 2, limited)
    page = html_of(document(ws))
    assert re.findall(r'(?:src|href)="(?!#|data:image/png)[^"]*"', page) == []
    assert re.findall(r"url\((?!#)", page) == []
    assert "@import" not in page
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids)), "charts in one page share no id"


def test_what_cannot_be_printed_is_spelt_out() -> None:
    assert legible("a\nb\tc") == "a\\nb\\tc"
    assert legible("Turm \U0001f5fc") == "Turm [U+1F5FC]"
    assert legible("turned \u202eback") == "turned [U+202E]back"
    assert legible("1\u202f000 ± 2 µm, 倾斜") == "1\u202f000 ± 2 µm, 倾斜"
    assert label("x" * 30) == "x" * 17 + "…"


@pytest.mark.slow
def test_signs_without_a_glyph_do_not_stop_the_pdf(tmp_path: Path) -> None:
    ws = open_workspace(tmp_path / "ws")
    publish(ws, 2, limited)
    settings = settings_of(
        {**SETTINGS, "structure": {**SETTINGS["structure"], "name": "Turm \U0001f5fc\u0007"}}
    )
    assert "Turm [U+1F5FC][U+0007]" in text_of(document(ws, settings=settings))
