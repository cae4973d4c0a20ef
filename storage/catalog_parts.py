"""The files that a catalog is made of: which table each fills, and by which values its rows are known there."""

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pyarrow as pa
import pyarrow.compute as pc

from storage.arrow_columns import arrow_column
from storage.errors import StorageError
from storage.parquet import read_table, schema_of, table_from_rows
from storage.records import TABLES, TiltRow
from storage.tables import part_column
from storage.version import VersionRow, VersionTiltRow
from storage.version_manifest import MANIFEST, read_manifest
from storage.workspace import Workspace

VERSIONS: Final = "versions"
VERSION_TILT: Final = "version_tilt"

CATALOG_TABLES: Final[Mapping[str, type]] = {
    **TABLES,
    VERSIONS: VersionRow,
    VERSION_TILT: VersionTiltRow,
}
"""Table of the catalog to record class: the stored tables, and those that are read from archived epochs."""

_OF_VERSIONS: Final = {MANIFEST: VERSIONS, "tilt.parquet": VERSION_TILT}


@dataclass(frozen=True, slots=True)
class Part:
    """A file whose rows stand in one table of the catalog, and the values that no row of another file has."""

    table: str
    path: Path
    key: tuple[str, ...]
    """Values of ``key_columns(table)``."""


def key_columns(table: str) -> tuple[str, ...]:
    """Columns that tell the rows of one file of a table from those of the others."""
    if table in (VERSIONS, VERSION_TILT):
        return ("structure", "version", "epoch")
    part = part_column(table)
    return ("structure",) if part is None else ("structure", part)


def stamps_of(ws: Workspace) -> dict[str, str]:
    """Each file that a catalog is made of, relative to the workspace, with its inode, size and time of change.

    Thousands of files are looked at on every rebuild: no ``Path`` is made for each.
    """
    root = str(ws.root)
    return {
        name: _stamp(os.path.join(root, name))  # noqa: PTH118
        for name in (*_table_files(root), *_version_files(root))
    }


def stamps_of_structure(ws: Workspace, structure: str, tables: Iterable[str]) -> dict[str, str]:
    """The same of some tables of one structure; to be asked with the publish lock, so that no file goes meanwhile."""
    root = str(ws.root)
    folders = [f"tables/{table}/{structure}" for table in tables]
    there = [folder for folder in folders if os.path.isdir(os.path.join(root, folder))]  # noqa: PTH112, PTH118
    names = [
        f"{folder}/{name}" for folder in there for name in _names(root, folder) if name.endswith(".parquet")
    ]
    return {name: _stamp(os.path.join(root, name)) for name in names}  # noqa: PTH118


def part_of(ws: Workspace, name: str) -> Part:
    """What a file of ``stamps_of`` holds."""
    words = name.split("/")
    if words[0] == ws.versions.name:
        _, structure, version, epoch, file = words
        return Part(_OF_VERSIONS[file], ws.root / name, (structure, version, epoch))
    _, table, structure, file = words
    key = (structure, file.removesuffix(".parquet"))
    return Part(table, ws.root / name, key[: len(key_columns(table))])


def read_part(part: Part) -> pa.Table:
    """Rows of a file, as they stand in the catalog.

    A file of an archived epoch that is damaged, or that of another, gives no rows: earlier results must not keep the present
    ones from being shown, and `verify` tells of it.

    Raises
    ------
    StorageError
        If a published table is damaged, or is that of another epoch or structure: its rows would stand beside the true ones
        and stay there when the file is put right.
    """
    if part.table in _OF_VERSIONS.values():
        return _read_archive(part)
    content = read_table(part.path, part.table, TABLES[part.table])
    _check_whose(content, part)
    return content


def _check_whose(content: pa.Table, part: Part) -> None:
    """Refuse rows that are not those of the file's name."""
    for column, value in zip(key_columns(part.table), part.key, strict=True):
        there = pc.unique(content[column]).to_pylist() if column in content.column_names else []
        strangers = [one for one in there if one != value]
        if strangers:
            raise StorageError(
                f"{part.path} holds rows of {column} {strangers[0]}; run the epoch again, or restore the file from a backup"
            )


def _read_archive(part: Part) -> pa.Table:
    schema = schema_of(part.table, CATALOG_TABLES[part.table])
    try:
        if part.table == VERSIONS:
            content = table_from_rows(VERSIONS, VersionRow, [read_manifest(part.path.parent).row])
            _check_whose(content, part)
            return content
        content = read_table(part.path, "tilt", TiltRow)
        _check_whose(content, part)
    except StorageError:
        return table_from_rows(part.table, CATALOG_TABLES[part.table], [])
    version = arrow_column([part.key[1]] * content.num_rows, pa.string())
    return pa.Table.from_arrays([*content.columns, version], schema=schema)


def _table_files(root: str) -> Iterator[str]:
    for table in TABLES:
        for structure in _folders(root, f"tables/{table}"):
            for name in _names(root, structure):
                if name.endswith(".parquet"):
                    yield f"{structure}/{name}"


def _version_files(root: str) -> Iterator[str]:
    for structure in _folders(root, "versions"):
        for version in _folders(root, structure):
            for epoch in _folders(root, version):
                # an epoch that is being put aside has a name that begins with a dot
                for name in () if epoch.rpartition("/")[2].startswith(".") else _names(root, epoch):
                    if name in _OF_VERSIONS:
                        yield f"{epoch}/{name}"


def _folders(root: str, folder: str) -> list[str]:
    try:
        with os.scandir(os.path.join(root, folder)) as entries:  # noqa: PTH118
            return sorted(f"{folder}/{entry.name}" for entry in entries if entry.is_dir())
    except FileNotFoundError:
        return []


def _names(root: str, folder: str) -> list[str]:
    return sorted(os.listdir(os.path.join(root, folder)))  # noqa: PTH118, PTH208


def _stamp(path: str) -> str:
    stat = os.stat(path)  # noqa: PTH116
    return f"{stat.st_ino} {stat.st_size} {stat.st_mtime_ns}"
