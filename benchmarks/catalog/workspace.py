"""A workspace of many epochs: written file by file, because publishing a thousand epochs one by one takes long."""

from pathlib import Path

from benchmarks.catalog.made_up import (
    SETTINGS,
    STRUCTURE,
    epoch_content,
    epoch_name,
    run_content,
    run_name,
    series_content,
)
from storage.catalog import rebuild_catalog
from storage.digests import text_sha256
from storage.ledger import store_settings
from storage.parquet import encode_table
from storage.tables import RUNS, SERIES, epochs_on_disk, table_path
from storage.workspace import Workspace, open_workspace


def grown_workspace(folder: Path, n_epochs: int) -> Workspace:
    """The workspace in the folder, with epochs added until it has so many, and without a catalog."""
    ws = open_workspace(folder)
    store_settings(ws, text_sha256(SETTINGS), SETTINGS)
    for number in range(len(epochs_on_disk(ws)), n_epochs):
        for table, content in epoch_content(number).items():
            _write(table_path(ws, table, STRUCTURE, epoch_name(number)), encode_table(content))
        _write(table_path(ws, RUNS, STRUCTURE, run_name(number)), encode_table(run_content(number)))
    for table, content in series_content(n_epochs).items():
        _write(table_path(ws, table, STRUCTURE, SERIES), encode_table(content))
    ws.catalog.unlink(missing_ok=True)
    return ws


def rebuilt_from_nothing(ws: Workspace) -> None:
    """Make the catalog of all Parquet files."""
    ws.catalog.unlink(missing_ok=True)
    rebuild_catalog(ws)


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
