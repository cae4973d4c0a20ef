"""Ways to read scans; `python -m benchmarks.ingest.ways WAY FOLDER SCAN ...` measures one in a process of its own."""

import json
import resource
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final

import laspy
import psutil

from storage.artifacts import put_array
from storage.digests import file_sha256
from storage.workspace import Workspace, open_workspace
from tasks.ingest import AS_STATED, read_scan
from tasks.stored_scan import store_scan

PIECE_POINTS: Final = 1_000_000


def decode(_: Workspace, scans: Sequence[Path]) -> int:
    """Decode all dimensions with laspy and the parallel decoder, keep nothing."""
    return sum(_decode(scan, laspy.DecompressionSelection.all()) for scan in scans)


def decode_xyz(_: Workspace, scans: Sequence[Path]) -> int:
    """The same with x, y and z alone."""
    return sum(_decode(scan, laspy.DecompressionSelection.base().decompress_z()) for scan in scans)


def as_arrays(workspace: Workspace, scans: Sequence[Path]) -> int:
    """Read every scan whole and store it as float64: what ingest was before it streamed."""
    return sum(put_array(workspace, "scan", read_scan(scan).points_m).size // 24 for scan in scans)


def in_stream(workspace: Workspace, scans: Sequence[Path]) -> int:
    """Ingest one scan after the other."""
    return sum(_ingest(workspace, scan) for scan in scans)


def at_once(workspace: Workspace, scans: Sequence[Path]) -> int:
    """Ingest all scans in threads, as the tasks of an epoch do."""
    with ThreadPoolExecutor(len(scans)) as pool:
        return sum(pool.map(lambda scan: _ingest(workspace, scan), scans))


def at_once_with_digests(workspace: Workspace, scans: Sequence[Path]) -> int:
    """The same with the SHA-256 of every file before, as a run does it."""
    with ThreadPoolExecutor(len(scans)) as pool:
        jobs = []
        for scan in scans:
            file_sha256(scan)
            jobs.append(pool.submit(_ingest, workspace, scan))
        return sum(job.result() for job in jobs)


REFERENCE: Final = "decode all"
WAYS: Final[Mapping[str, Callable[[Workspace, Sequence[Path]], int]]] = {
    REFERENCE: decode,
    "decode x, y, z": decode_xyz,
    "whole, as float64": as_arrays,
    "ingest": in_stream,
    "ingest at once": at_once,
    "hash and ingest at once": at_once_with_digests,
}


def _decode(scan: Path, wanted: laspy.DecompressionSelection) -> int:
    with laspy.open(
        scan, laz_backend=laspy.LazBackend.LazrsParallel, decompression_selection=wanted
    ) as reader:
        return sum(len(piece) for piece in reader.chunk_iterator(PIECE_POINTS))


def _ingest(workspace: Workspace, scan: Path) -> int:
    stored = store_scan(workspace, scan, AS_STATED)
    stored.cloud.fingerprint()
    return len(stored.cloud)


def main() -> None:
    """Measure one way and print its cost as JSON."""
    way, folder, *names = sys.argv[1:]
    workspace, process = open_workspace(Path(folder)), psutil.Process()
    before = process.memory_info().rss
    began, spent = time.perf_counter(), time.process_time()
    points = WAYS[way](workspace, [Path(name) for name in names])
    seconds, processor_s = time.perf_counter() - began, time.process_time() - spent
    # kilobytes on Linux; the decoder holds Python's lock, so no thread of ours could watch it
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    cost = {
        "points": points,
        "seconds": seconds,
        "processor_s": processor_s,
        "memory_mb": (peak - before) / 1e6,
    }
    print(json.dumps(cost))


if __name__ == "__main__":
    main()
