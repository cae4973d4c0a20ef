"""Words that stand for secrets, and a search for them in all that a command leaves behind."""

import base64
import gzip
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import duckdb
import pyarrow as pa
import pyarrow.parquet as pq
from pypdf import PdfReader

from storage.sealed import unsealed


@dataclass(frozen=True)
class Found:
    """Where a secret lies that should not."""

    secret: str
    where: str


def forms(secret: str) -> set[bytes]:
    """A secret as it stands, as in an address, and within base64, wherever it begins there."""
    found = {secret.encode(), quote(secret, safe="").encode(), secret.encode("utf-16-le")}
    for offset in range(3):
        encoded = base64.b64encode(b"x" * offset + secret.encode())
        # the letters at both ends hold bits of the neighbours
        found.add(encoded[4 if offset else 0 : len(encoded) // 4 * 4 - 4])
    return found


def search(secrets: dict[str, str], folders: list[Path], texts: dict[str, str]) -> list[Found]:
    """Look for secrets in files, in what is packed in them, and in texts; gives every place."""
    wanted = {name: forms(secret) for name, secret in secrets.items()}
    places = [*texts_of(folders), *((name, text.encode()) for name, text in texts.items())]
    return [
        Found(name, where)
        for where, content in places
        for name, shapes in wanted.items()
        if any(shape in content for shape in shapes)
    ]


def texts_of(folders: list[Path]) -> Iterator[tuple[str, bytes]]:
    """Every file as it lies, and as those who read it see it."""
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                yield str(path), path.read_bytes()
                yield f"{path} (read)", "\n".join(_read(path)).encode()
            yield f"{path} (its name)", path.name.encode()


def _read(path: Path) -> Iterator[str]:
    if path.suffix == ".parquet":
        # a second copy has its digest before it
        content = path.read_bytes()
        table = pq.read_table(pa.BufferReader(unsealed(content) or content))
        yield str(table.schema.metadata)
        yield str(table.to_pydict())
    elif path.suffix == ".duckdb":
        with duckdb.connect(str(path), read_only=True) as catalog:
            for schema, name in catalog.execute(
                "SELECT table_schema, table_name FROM information_schema.tables"
            ).fetchall():
                yield str(catalog.execute(f'SELECT * FROM "{schema}"."{name}"').fetchall())  # noqa: S608
    elif path.suffix == ".db":
        with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as database:
            yield from database.iterdump()
    elif path.suffix == ".gz":
        yield gzip.decompress(path.read_bytes()).decode(errors="replace")
    elif path.suffix == ".pdf":
        yield from (page.extract_text() for page in PdfReader(path).pages)
