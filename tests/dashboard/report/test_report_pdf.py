"""The report on paper: archivable, the same bytes again, and the numbers of the catalog."""

import io
from pathlib import Path

from pypdf import PdfReader

from dashboard import numbers
from dashboard.report.blocks import Document
from dashboard.report.paper import TEMPLATE, pdf_of
from storage.views import change_rows, slice_rows_of, station_rows, tilt_rows
from storage.workspace import Workspace, open_workspace
from tests.dashboard.report.reported import document, limited, publish, text_of
from tests.storage.campaign import STRUCTURE


def test_the_same_rows_give_the_same_bytes_in_another_workspace(paper: bytes, tmp_path: Path) -> None:
    other = open_workspace(tmp_path / "other")
    publish(other, 2, limited)
    assert pdf_of(document(other)) == paper


def test_it_claims_pdf_a_2b_and_is_dated_by_the_publication(paper: bytes, english: Document) -> None:
    reader = PdfReader(io.BytesIO(paper))
    xmp = reader.trailer["/Root"]["/Metadata"].get_data().decode()
    assert "<pdfaid:part>2</pdfaid:part>" in xmp
    assert "<pdfaid:conformance>B</pdfaid:conformance>" in xmp
    assert reader.metadata is not None
    assert str(reader.metadata["/CreationDate"]).startswith(
        f"D:{english.year}{english.month:02d}{english.day:02d}"
    )


def test_every_font_is_in_the_file(paper: bytes) -> None:
    fonts = {
        str(font.get_object()["/BaseFont"])
        for page in PdfReader(io.BytesIO(paper)).pages
        for font in page["/Resources"]["/Font"].values()
    }
    assert fonts
    assert all("+Tiltwatch" in name for name in fonts), "a subset of a shipped font each"


def test_the_numbers_are_those_of_the_catalog(paper: bytes, published: Workspace) -> None:
    text = text_of(paper)
    tilt = tilt_rows(published, STRUCTURE, "e1")[0]
    change = next(row for row in change_rows(published, STRUCTURE) if row.epoch == "e1")
    assert f"{numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m)} (k = 2)" in text
    assert numbers.dms(tilt.tilt_deg) in text
    assert numbers.mm(tilt.allowable_m) in text
    assert numbers.mm_with_u(change.d_top_m, change.sigma_top_m) in text
    assert numbers.mm(change.smallest_detectable_m) in text
    for part in (tilt.d_east, tilt.d_north, tilt.d_up):
        assert numbers.number(part, 8) in text
    for slice_row in slice_rows_of(published, STRUCTURE, "e1"):
        assert numbers.number(slice_row.center_east_m, 4) in text
    for station in station_rows(published, STRUCTURE, "e1"):
        assert station.station in text
        assert station.scan_digest is not None
        assert station.scan_digest in text


def test_the_template_asks_no_registry() -> None:
    assert "@" not in TEMPLATE.read_text().replace("@font-face", "")
