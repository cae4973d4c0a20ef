"""A workspace of rows, and the report of one of its epochs."""

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pypdf import PdfReader

from dashboard.report.blocks import Document
from dashboard.report.document import document_of
from dashboard.report.facts import Facts, Origin, gather
from dashboard.report.paper import pdf_of
from dashboard.report.settings import Settings, settings_of
from dashboard.report.words import words_of
from storage.catalog import rebuild_catalog
from storage.ledger import append_run
from storage.publish import publish_epoch
from storage.records import VerdictRow
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, stage_run_row

Change = Callable[[dict[str, list[Any]]], None]
"""Changes the tables of an epoch in place."""

SETTINGS = {
    "structure": {
        "name": "Heritage chimney",
        "kind": "chimney",
        "height_m": 102.0,
        "shaft_z_m": [2.0, 102.0],
        "radius_m": [4.6, 2.7],
        "base_xy_m": [0.0, 0.0],
    },
    "frame": {"horizontal": "local"},
    "instrument": {
        "range_sigma_m": 0.005,
        "angle_sigma_deg": 0.001,
        "level_sigma_deg": 0.0008,
        "position_sigma_m": [0.015, 0.0225],
        "heading_sigma_deg": 0.15,
    },
    "epochs": [{"id": "e0", "temperature_c": 12.5}, {"id": "e1"}],
}


def limited(tables: dict[str, list[Any]], allowable_m: float = 0.06, verdict: str = "fail") -> None:
    """Give the epoch a limit."""
    tables["tilt"] = [
        replace(row, allowable_m=allowable_m, verdict=verdict, verdict_reason="figures")
        for row in tables["tilt"]
    ]
    tables["verdicts"] = [
        VerdictRow(
            structure=STRUCTURE,
            epoch=row.epoch,
            scheme=row.scheme,
            method=row.method,
            limit_name="works",
            is_primary=True,
            version=1,
            kind="construction",
            document="Works rule 12",
            edition="2019",
            clause="4.2",
            height_m=row.height_m,
            allowable_m=allowable_m,
            deviation_m=row.deviation_m,
            sigma_m=row.deviation_sigma_m,
            verdict=verdict,
            reason="figures",
        )
        for row in tables["tilt"]
    ]


def nothing(tables: dict[str, list[Any]]) -> None:
    """Change nothing."""


def publish(ws: Workspace, epochs: int = 2, change: Change = nothing) -> None:
    """Publish epochs e0, e1, ...; the change goes to the last."""
    for number in range(epochs):
        publish_one(ws, number, change if number == epochs - 1 else limited)
    rows = [stage_run_row("run-1", f"e{number}") for number in range(epochs)]
    append_run(ws, "run-1", STRUCTURE, rows)
    rebuild_catalog(ws)


def publish_one(ws: Workspace, number: int, change: Change = limited) -> None:
    """Publish one epoch."""
    epoch = f"e{number}"
    tables = epoch_tables(epoch, number, (0.007 + 1e-4 * number, -0.0057))
    tables["scheme_comparison"] = []
    tables["verdicts"] = []
    change(tables)
    publish_epoch(ws, STRUCTURE, epoch, tables)


def facts_of(ws: Workspace, epoch: str = "e1", settings: Settings | None = None, **origin: Any) -> Facts:
    """Gather what the report of an epoch says."""
    known = settings or settings_of(SETTINGS)
    given = {"primary": ("A", "paper"), "settings": known, "library_versions": ("numpy==2.4.0",), **origin}
    return gather(Origin(workspace=ws, structure=STRUCTURE, epoch=epoch, program_version="0.1.0", **given))


def document(ws: Workspace, epoch: str = "e1", lang: str = "en", **origin: Any) -> Document:
    """Write the report of an epoch."""
    return document_of(facts_of(ws, epoch, **origin), words_of(lang))


def text_of(made: Document | bytes) -> str:
    """The text of a PDF, with plain spaces."""
    content = made if isinstance(made, bytes) else pdf_of(made)
    pages = PdfReader(io.BytesIO(content)).pages
    return " ".join(" ".join(page.extract_text() for page in pages).replace("\u200b", "").split())
