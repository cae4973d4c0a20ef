"""What a catalog is made of: definitions, columns, and the files with their stamps."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import duckdb

from storage.catalog_parts import CATALOG_TABLES, stamps_of
from storage.records import columns_of
from storage.view_definitions import VIEWS, view_definition
from storage.workspace import Workspace


@dataclass(frozen=True, slots=True)
class Sources:
    """All that a catalog is made of."""

    definitions: str
    """Digest of the views, the columns and the version of DuckDB."""
    columns: Mapping[str, str]
    """Table to the digest of its columns: where it is the same, rows can be taken over from an older catalog."""
    stamps: Mapping[str, str]
    """File, relative to the workspace, to its inode, size and time of change."""


def sources_of(ws: Workspace) -> Sources:
    """What a catalog would be made of now."""
    return Sources(catalog_definitions(), _columns(), stamps_of(ws))


@cache
def catalog_definitions() -> str:
    """Digest of what turns tables into views: the views, their columns and the version of DuckDB."""
    sql = {name: view_definition(name).sql for name in VIEWS}
    meanings = {name: repr(list(columns_of(record))) for name, record in VIEWS.items()}
    return _digest([sql, meanings, duckdb.__version__])


@cache
def _columns() -> Mapping[str, str]:
    return {
        table: _digest(
            [(column.name, str(column.python_type), column.nullable) for column in columns_of(record)]
        )
        for table, record in CATALOG_TABLES.items()
    }


def _digest(content: object) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True, slots=True)
class Difference:
    """What of the sources changed: files whose rows must go, and files that must be read."""

    gone: Sequence[str]
    new: Sequence[str]
    kept: Sequence[str]


def difference_of(old: Sources, new: Sources) -> Difference:
    """What changed since the old catalog was made."""
    kept = [file for file, stamp in new.stamps.items() if old.stamps.get(file) == stamp]
    same = frozenset(kept)
    return Difference(
        gone=[file for file in old.stamps if file not in same],
        new=[file for file in new.stamps if file not in same],
        kept=kept,
    )
