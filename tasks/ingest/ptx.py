"""PTX: scans with their poses, each a grid of rows ``x y z intensity [r g b]`` in the frame of its scanner.

A row ``0 0 0 ...`` stands for a beam without a return. Every row is read or the file is refused.
"""

import io
from pathlib import Path
from typing import Final

import numpy as np

from storage.errors import InputError
from tasks.ingest.file_pose import place_points
from tasks.ingest.ptx_header import PtxScan, index_scans, pose_notes, pose_of
from tasks.ingest.scan import FilePose, RawScan, Reader, ScanHeader, ScanPart, ScanRequest
from tasks.ingest.scan_parts import choose_parts
from tasks.ingest.text_rows import end_notes, fill_rows, refuse_polar


def describe_ptx(path: Path, request: ScanRequest) -> ScanHeader:
    """What the headers of a PTX file say; the lines between them are counted, not read.

    The pose of a scan that was not asked for is None, too, where its matrix is none.
    """
    refuse_polar(path, request, "PTX")
    with path.open("rb") as file:
        scans = index_scans(path, file)
        size_bytes = file.seek(0, io.SEEK_END)
    chosen = choose_parts(path, [None] * len(scans), request)
    for place in chosen:
        pose_of(path, scans[place])
    parts = tuple(ScanPart(None, scan.rows.n_rows, _pose_or_none(path, scan)) for scan in scans)
    return ScanHeader("PTX", sum(parts[place].n_points for place in chosen), size_bytes, None, parts)


def read_ptx(path: Path, request: ScanRequest) -> RawScan:
    """All points of one scan in its own frame, or of all scans in the frame of the file."""
    refuse_polar(path, request, "PTX")
    with path.open("rb") as file:
        scans = index_scans(path, file)
        chosen = [scans[place] for place in choose_parts(path, [None] * len(scans), request)]
        poses = [pose_of(path, scan) for scan in chosen]
        # the lines were counted: the file is long enough for what is allocated here
        values = np.empty((sum(scan.rows.n_rows for scan in chosen), 3))
        done = 0
        for scan, pose in zip(chosen, poses, strict=True):
            part = values[done : done + scan.rows.n_rows]
            file.seek(scan.rows_at)
            fill_rows(path, file, scan.rows, part)
            if request.frame == "file":
                place_points(pose, part)
            done += len(part)
        notes = end_notes(file, scans[-1].rows)
    notes += tuple(note for scan, pose in zip(chosen, poses, strict=True) for note in pose_notes(scan, pose))
    return RawScan(values, notes=notes, pose=poses[0] if request.frame == "scanner" else None)


def _pose_or_none(path: Path, scan: PtxScan) -> FilePose | None:
    try:
        return pose_of(path, scan)
    except InputError:
        return None


READER: Final = Reader("ptx", (".ptx",), describe_ptx, read_ptx)
