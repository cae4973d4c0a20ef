"""Views as files, for those that read nothing but views."""

import io

from storage.export import export_view
from storage.workspace import Workspace


def view_file(ws: Workspace, view: str, structure: str, file_format: str) -> bytes:
    """The rows of a structure in a view as a file (csv, json or parquet), the same bytes for the same rows.

    Raises
    ------
    UsageError
        If there is no such view or format.
    StorageError
        If the catalog cannot be read.
    """
    out = io.BytesIO()
    export_view(ws, view, file_format, out, structure)
    return out.getvalue()
