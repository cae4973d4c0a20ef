"""E57 (ASTM E2807): several scans a file, each with its pose.

Memory is bounded by the (n, 3) result and one piece of decoded records. The result is allocated only after the count
that a scan states agreed with the section that holds it. What the file says of itself is read and checked here; the
points are decoded by libE57Format.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from storage.errors import InputError
from tasks.ingest.crs import StatedSystem, check_horizontal, note_grid_of_scanner, system_of_wkt
from tasks.ingest.e57_header import E57Scan, read_e57_header
from tasks.ingest.e57_points import ScanFigures, fill_points, find_layout, open_image
from tasks.ingest.scan import Bounds, RawScan, Reader, ScanHeader, ScanPart, ScanRequest
from tasks.ingest.scan_parts import choose_parts


@dataclass(frozen=True, slots=True)
class _Chosen:
    """The scans that are asked for, of all that the file holds."""

    all_scans: tuple[E57Scan, ...]
    scans: tuple[E57Scan, ...]
    size_bytes: int
    systems: tuple[StatedSystem, ...]
    notes: tuple[str, ...]

    @property
    def n_points(self) -> int:
        return sum(scan.n_points for scan in self.scans)


def describe_e57(path: Path, request: ScanRequest) -> ScanHeader:
    """What the scans of an E57 file state; points and box are those of the scans that are asked for."""
    chosen = _choose(path, request)
    return ScanHeader(
        "E57 1.0",
        chosen.n_points,
        chosen.size_bytes,
        _bounds(chosen.scans),
        tuple(ScanPart(scan.name, scan.n_points, scan.pose) for scan in chosen.all_scans),
        chosen.systems[0].label if chosen.systems else None,
    )


def read_e57(path: Path, request: ScanRequest) -> RawScan:
    """The points of one scan in its own frame, or of all scans joined in that of the file."""
    chosen = _choose(path, request)
    values = np.empty((chosen.n_points, 3))
    figures: list[ScanFigures] = []
    done = 0
    with open_image(path) as image:
        for scan in chosen.scans:
            pose = scan.pose if request.frame == "file" else None
            figures.append(fill_points(path, image, scan, pose, values[done : done + scan.n_points]))
            done += scan.n_points
    steps = [figure.step for figure in figures if figure.step is not None]
    return RawScan(
        values,
        max(steps, default=None),
        chosen.notes
        + tuple(_reading_notes(path, chosen.scans, figures))
        + note_grid_of_scanner(chosen.systems, values, request),
        chosen.scans[0].pose if request.frame == "scanner" else None,
    )


def _choose(path: Path, request: ScanRequest) -> _Chosen:
    _check_request(path, request)
    with path.open("rb") as file:
        header = read_e57_header(path, file)
    if not header.scans:
        raise InputError(f"{path}: needs a scan, came a file that holds none; export the scan again")
    named = tuple(
        header.scans[place] for place in choose_parts(path, [s.name for s in header.scans], request)
    )
    scans = tuple(scan for scan in named if scan.n_points)
    if not scans:
        raise InputError(
            f"{path}: needs points, came {named[0].place} that holds no points; export the scan again"
        )
    for scan in scans:
        find_layout(path, scan)
    system = system_of_wkt(header.coordinate_system)
    systems = () if system is None else (system,)
    notes = (*_pose_notes(named, request), *check_horizontal(path, systems, request.horizontal))
    return _Chosen(header.scans, scans, header.size_bytes, systems, notes)


def _check_request(path: Path, request: ScanRequest) -> None:
    """Refuse statements of the campaign that contradict the format itself."""
    if request.coordinates == "polar":
        raise InputError(
            f'{path}: needs coordinates = "cartesian", came "polar"; an E57 file says itself which it holds and both are '
            "read: leave coordinates out"
        )
    if request.unit != "metre":
        raise InputError(
            f"{path}: needs the unit metre, in which E57 files are by their standard, came {request.unit}; "
            "leave the unit out, or export LAZ"
        )


def _pose_notes(named: Sequence[E57Scan], request: ScanRequest) -> Iterator[str]:
    for scan in named:
        if scan.n_points == 0:
            yield f"{scan.place} holds no points"
        if scan.stated_pose is not None:
            yield from scan.stated_pose.notes()
    without = [scan for scan in named if scan.pose is None]
    if request.frame == "file" and len(named) > 1 and without:
        yield (
            f"{len(without)} of {len(named)} scans state no pose and are taken as they stand: "
            "is the file an export in one common frame"
        )


def _reading_notes(path: Path, scans: Sequence[E57Scan], figures: Sequence[ScanFigures]) -> Iterator[str]:
    """Notes on records that the file marks as invalid, and on angles.

    Raises
    ------
    InputError
        If these are all.
    """
    n_points = sum(scan.n_points for scan in scans)
    n_invalid = sum(figure.n_invalid for figure in figures)
    if n_invalid == n_points:
        raise InputError(
            f"{path}: needs points, came {n_points} records that the file itself marks as invalid; export the scan again"
        )
    if n_invalid:
        yield f"{n_invalid} of {n_points} records are marked as invalid in the file: taken as beams without a return"
    for scan, figure in zip(scans, figures, strict=True):
        yield from figure.notes(scan)


def _bounds(scans: Sequence[E57Scan]) -> Bounds | None:
    """Box of the scans as the file states it.

    Programs disagree whether that of a scan with a pose is in its own frame, as the standard says, or in the file's.
    """
    boxes = [scan.bounds for scan in scans if scan.bounds is not None and _stands_as_it_is(scan)]
    if len(boxes) != len(scans):
        return None
    return Bounds(np.min([box.low for box in boxes], axis=0), np.max([box.high for box in boxes], axis=0))


def _stands_as_it_is(scan: E57Scan) -> bool:
    pose = scan.pose
    return pose is None or (np.array_equal(pose.rotation, np.eye(3)) and not pose.translation.any())


READER: Final = Reader("e57", (".e57",), describe_e57, read_e57)
