"""What follows from all epochs of a structure: made anew after each of them, one file a table and structure."""

from collections.abc import Mapping, Sequence

from storage.assessed import forget_assessed
from storage.atomic import write_our_own
from storage.errors import StorageError
from storage.locks import publish_lock
from storage.parquet import encode_rows
from storage.records import TABLES
from storage.tables import SERIES, SERIES_TABLES, table_path
from storage.workspace import Workspace


def publish_series(ws: Workspace, structure: str, tables: Mapping[str, Sequence[object]]) -> bool:
    """Replace tables that follow from all epochs of a structure; a table whose rows are the same stays untouched.

    A crash between two of them leaves the later ones as they were: they are made anew by the next run.

    Returns
    -------
    bool
        False if nothing changed.

    Raises
    ------
    StorageError
        If a table is not one of ``SERIES_TABLES``, a row is of another structure or may not be stored, or the disk refuses.
    InputError
        If the id cannot be a file name.
    """
    for table, rows in tables.items():
        if table not in SERIES_TABLES:
            raise StorageError(
                f"table {table!r} does not follow from epochs; known: {', '.join(SERIES_TABLES)}"
            )
        strangers = {getattr(row, "structure", "") for row in rows} - {structure}
        if strangers:
            raise StorageError(
                f"table {table}: needed rows of {structure}, got {', '.join(sorted(strangers))}"
            )
    contents = {table: encode_rows(table, TABLES[table], rows) for table, rows in tables.items()}
    changed = False
    with publish_lock(ws):
        for table, content in contents.items():
            path = table_path(ws, table, structure, SERIES)
            if not path.is_file() or path.read_bytes() != content:
                forget_assessed(ws, structure)  # verify holds the series against it
                write_our_own(path, content)
                changed = True
    return changed
