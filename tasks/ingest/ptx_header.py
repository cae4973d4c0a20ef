"""The ten lines before each scan of a PTX file, and where its rows are.

Two counts, the place and the three axes of the scanner as registered, and a 4x4 matrix for row vectors: its fourth
row is the translation, its upper left block the transpose of the rotation of ``FilePose``.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.conventions import ARCSEC_RAD
from tasks.ingest.file_pose import pose_of_matrix
from tasks.ingest.scan import FilePose
from tasks.ingest.text_layout import is_number, split_row
from tasks.ingest.text_rows import CountedRows, count_in, next_line, skip_lines, too_few

COLUMNS: Final = frozenset({3, 4, 6, 7})
"""x y z, intensity, colour, or both."""

WIDTHS: Final = (3, 3, 3, 3, 4, 4, 4, 4)
"""Numbers in the lines after the two counts."""

SAME_PLACE: Final = 1e-3
"""In the unit of the file: a millimetre, far above what rounding of written coordinates can do."""

SAME_AXES: Final = 1e-5
"""Two matrices that were written with five decimals and more."""

SIX_DIGITS: Final = 2e-6
"""What six digits behind the point leave open of an element of a rotation, and a little more."""


@dataclass(frozen=True, slots=True)
class PtxScan:
    """One scan of a PTX file.

    ``number`` counts from 1. ``matrix`` (4, 4) is as written, ``registered`` (4, 3) the place and the axes of the scanner.
    """

    number: int
    rows: CountedRows
    rows_at: int
    matrix: NDArray[np.float64]
    registered: NDArray[np.float64]


def pose_of(path: Path, scan: PtxScan) -> FilePose:
    """Pose of a scan, from its matrix.

    Raises
    ------
    InputError
        If the matrix is no rotation and translation of row vectors.
    """
    where = f"the matrix of scan {scan.number}"
    if not np.array_equal(scan.matrix[:, 3], (0.0, 0.0, 0.0, 1.0)):
        last = ", ".join(f"{value:g}" for value in scan.matrix[:, 3])
        raise InputError(
            f"{path}: needs 0, 0, 0, 1 in the last column and the translation in the last row, came {last} in {where}; "
            "transpose that matrix, or export again"
        )
    return pose_of_matrix(path, where, scan.matrix[:3, :3].T, scan.matrix[3, :3])


def pose_notes(scan: PtxScan, pose: FilePose) -> tuple[str, ...]:
    """Notes if the lines on the scanner say something else than the matrix, or the matrix is rougher than a level."""
    notes: tuple[str, ...] = ()
    place, axes = scan.registered[0], scan.registered[1:]
    is_same_place = np.abs(place - scan.matrix[3, :3]).max() <= SAME_PLACE
    if not (is_same_place and np.abs(axes - scan.matrix[:3, :3]).max() <= SAME_AXES):
        notes += (
            f"scan {scan.number}: the lines on place and axes of the scanner differ from the matrix; the matrix counts",
        )
    away = float(np.abs(scan.matrix[:3, :3].T - pose.rotation).max())
    if away > SIX_DIGITS:
        notes += (
            f"scan {scan.number}: the matrix is off a rotation by {away / ARCSEC_RAD:.1f} arc seconds, and directions are "
            "as rough; export it with more digits",
        )
    return notes


def index_scans(path: Path, file: BinaryIO) -> tuple[PtxScan, ...]:
    """The scans of a file; the lines of points are counted, not read.

    Raises
    ------
    InputError
        If a header is none, or a scan has fewer lines than it states.
    """
    scans: list[PtxScan] = []
    line = 0
    while (text := next_line(path, file)) is not None:
        line += 1
        if not text:
            continue
        scan = _read_header(path, file, text, line, scans)
        found = skip_lines(path, file, scan.rows.n_rows)
        if found < scan.rows.n_rows:
            raise too_few(path, scan.rows.n_rows, found, scan.rows.stated_by)
        scans.append(scan)
        line = scan.rows.first_line - 1 + found
    if not any(scan.rows.n_rows for scan in scans):
        raise InputError(f"{path}: needs points, came a file that holds no points; export the scan again")
    return tuple(scans)


def _read_header(path: Path, file: BinaryIO, text: str, line: int, before: list[PtxScan]) -> PtxScan:
    """Header whose first line is ``text``; the file then stands at its first row."""
    counts = [_count(path, line, text, before), _count(path, line + 1, next_line(path, file), before)]
    numbers = [
        _numbers(path, line + 2 + index, next_line(path, file), width) for index, width in enumerate(WIDTHS)
    ]
    number, first_line = len(before) + 1, line + 2 + len(WIDTHS)
    rows_at = file.tell()
    n_rows = counts[0] * counts[1]
    row = next_line(path, file) if n_rows else None
    file.seek(rows_at)
    n_columns = len(split_row(row, None)) if row else 4
    if n_columns not in COLUMNS:
        raise InputError(
            f"{path}: needs rows x y z intensity [r g b], came {n_columns} columns in line {first_line} "
            f"{(row or '')[:60]!r}; export again"
        )
    rows = CountedRows(n_rows, n_columns, (0, 1, 2), None, first_line, f"the header of scan {number}")
    return PtxScan(number, rows, rows_at, np.array(numbers[4:]), np.array(numbers[:4]))


def _count(path: Path, line: int, text: str | None, before: list[PtxScan]) -> int:
    count = None if text is None else count_in(text.removeprefix("\u00ef\u00bb\u00bf"))
    if count is None:
        after = f" after the {before[-1].rows.n_rows} rows of scan {before[-1].number}" if before else ""
        raise InputError(
            f"{path}: needs the count of columns, then that of rows{after}, came {_quoted(text)} in line {line}; "
            "the file is cut short, or the counts are wrong, export it again"
        )
    return count


def _numbers(path: Path, line: int, text: str | None, width: int) -> list[float]:
    fields = split_row(text or "", None)
    if len(fields) != width or not all(is_number(field) for field in fields):
        raise InputError(
            f"{path}: needs {width} numbers in line {line} of the header, came {_quoted(text)}; "
            "the file is cut short or damaged, export it again"
        )
    return [float(field) for field in fields]


def _quoted(text: str | None) -> str:
    return "the end of the file" if text is None else repr(text[:60])
