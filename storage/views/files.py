"""Views as files, for those that read nothing but views."""

import io

from storage.export import export_view
from storage.workspace import Workspace


def view_csv(ws: Workspace, view: str, structure: str) -> bytes:
    """The rows of a structure in a view as CSV, the same bytes for the same rows.

    Raises
    ------
    UsageError
        If there is no such view.
    StorageError
        If the catalog cannot be read.
    """
    out = io.BytesIO()
    export_view(ws, view, "csv", out, structure)
    return out.getvalue()
