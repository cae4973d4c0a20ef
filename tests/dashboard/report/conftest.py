"""One workspace with a report for the tests that only read it."""

import pytest

from dashboard.report.blocks import Document
from dashboard.report.paper import pdf_of
from storage.workspace import Workspace, open_workspace
from tests.dashboard.report.reported import document, limited, publish


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """Epochs e0 and e1 of scheme A, method paper, over their limit."""
    ws = open_workspace(tmp_path_factory.mktemp("report"))
    publish(ws, 2, limited)
    return ws


@pytest.fixture(scope="module")
def english(published: Workspace) -> Document:
    """The report of e1 in English."""
    return document(published)


@pytest.fixture(scope="module")
def paper(english: Document) -> bytes:
    """The same as PDF."""
    return pdf_of(english)
