"""The variable length records of a LAS file, walked within bounds."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

from storage.errors import InputError
from tasks.ingest.las_header import LasHeader

RECORD_HEAD_BYTES: Final = 54
LATE_RECORD_HEAD_BYTES: Final = 60
LONGEST_KEPT: Final = 1 << 20
"""Of a record behind the points no more than this is kept: coordinate systems are short, hierarchies are not."""


@dataclass(frozen=True, slots=True)
class LasRecord:
    """A variable length record; ``owner`` is its user id."""

    owner: bytes
    number: int
    content: bytes


def read_las_records(path: Path, file: BinaryIO, header: LasHeader) -> tuple[LasRecord, ...]:
    """All variable length records, those before the points and those behind them.

    Raises
    ------
    InputError
        If they do not fit where the header says they are.
    """
    before = header.points_at - header.header_bytes
    if header.n_records * RECORD_HEAD_BYTES > before:
        raise InputError(
            f"{path}: needs room for the {header.n_records} variable length records that its header states, "
            f"came {before} bytes between header and points; the header is damaged, export the scan again"
        )
    early = _walk(path, file, _Span(header.header_bytes, header.points_at, header.n_records, is_late=False))
    if header.n_late_records == 0:
        return tuple(early)
    late = _Span(header.late_records_at, header.size_bytes, header.n_late_records, is_late=True)
    return (*early, *_walk(path, file, late))


@dataclass(frozen=True, slots=True)
class _Span:
    start: int
    end: int
    n_records: int
    is_late: bool


def _walk(path: Path, file: BinaryIO, span: _Span) -> Iterator[LasRecord]:
    head_bytes = LATE_RECORD_HEAD_BYTES if span.is_late else RECORD_HEAD_BYTES
    at = span.start
    for index in range(span.n_records):
        content_at = at + head_bytes
        length = 0
        if content_at <= span.end:
            file.seek(at)
            _, owner, number, length = struct.unpack(
                "<H16sHQ" if span.is_late else "<H16sHH", file.read(head_bytes - 32)
            )
        if content_at + length > span.end:
            raise InputError(
                f"{path}: needs {span.n_records} variable length records before byte {span.end}, came {index} that fit; "
                "the file is cut short or damaged, copy or export it again"
            )
        file.seek(content_at)
        yield LasRecord(owner.split(b"\0")[0], number, file.read(min(length, LONGEST_KEPT)))
        at = content_at + length
