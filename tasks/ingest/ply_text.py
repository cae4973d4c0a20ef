"""The body of a PLY file that is a text: a record a line, elements after each other."""

from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.ply_header import PlyElement, PlyHeader
from tasks.ingest.scan import RawScan
from tasks.ingest.text_layout import is_number, text_of
from tasks.ingest.text_rows import (
    CountedRows,
    count_in,
    end_notes,
    read_rows,
    refuse_rest,
    skip_lines,
    take_lines,
    too_few,
)

STATED_BY = "its header"


def read_ply_text(path: Path, file: BinaryIO, header: PlyHeader, columns: tuple[int, int, int]) -> RawScan:
    """The wanted columns of the vertices; the file stands behind the header.

    Raises
    ------
    InputError
        If an element has more or fewer records than stated, or a vertex is no row of numbers.
    """
    line = header.first_line
    for element in header.elements[: header.vertex]:
        line += _pass_over(path, file, element)
    vertex = header.elements[header.vertex]
    rows = CountedRows(vertex.count, len(vertex.properties), columns, None, line, STATED_BY)
    values = _rows_with_lists(path, file, vertex, rows) if vertex.has_lists else read_rows(path, file, rows)
    line += vertex.count
    for element in header.elements[header.vertex + 1 :]:
        line += _pass_over(path, file, element)
    refuse_rest(path, file, STATED_BY, line)
    is_last = header.vertex == len(header.elements) - 1
    return RawScan(values, notes=end_notes(file, rows) if is_last else ())


def _pass_over(path: Path, file: BinaryIO, element: PlyElement) -> int:
    found = skip_lines(path, file, element.count)
    if found < element.count:
        raise InputError(
            f"{path}: needs the {element.count} lines of element {element.name!r} that {STATED_BY} states, "
            f"came {found}; the file is cut short or damaged, copy or export it again"
        )
    return found


def _rows_with_lists(
    path: Path, file: BinaryIO, vertex: PlyElement, rows: CountedRows
) -> NDArray[np.float64]:
    """Wanted columns (n, 3) of rows whose lists make them of different lengths; line by line, which is slow."""
    points: list[list[float]] = []
    for block in take_lines(path, file, rows.n_rows):
        for text in text_of(block).splitlines():
            fields = text.split()
            try:
                numbers = _first_numbers(vertex, fields)
                points.append([_number(numbers[column]) for column in rows.columns])
            except (ValueError, IndexError) as error:
                raise InputError(
                    f"{path}: needs the numbers and lists that {STATED_BY} states, came "
                    f"line {rows.first_line + len(points)} {text.strip()[:60]!r}; the file is cut short or damaged, "
                    "export it again"
                ) from error
    if len(points) != rows.n_rows:
        raise too_few(path, rows.n_rows, len(points), STATED_BY)
    return np.array(points)


def _number(field: str) -> float:
    if not is_number(field):
        raise ValueError(field)
    return float(field)


def _first_numbers(vertex: PlyElement, fields: list[str]) -> list[str]:
    """Field of each property of a row; of a list its length."""
    first, place = [], 0
    for known in vertex.properties:
        first.append(fields[place])
        if known.length_type is not None:
            length = count_in(fields[place])
            if length is None:
                raise ValueError(fields[place])
            place += length
        place += 1
    if place != len(fields):
        raise ValueError(place)
    return first
