"""What is no point cloud at all, under the name of every format with a header of text."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from storage.errors import InputError
from tasks.ingest import ScanRequest, describe_scan, read_scan

SUFFIXES = (".ptx", ".pts", ".ply", ".pcd")
GARBAGE = {
    "noise": np.random.default_rng(5).bytes(200_000),
    "zeros": bytes(200_000),
    "one_line": b"1 2 3 " * 50_000,
    "empty_lines": b"\n" * 100_000,
    "a_count": b"999999999999999\n",
    "a_jpeg": b"\xff\xd8\xff\xe0\x00\x10JFIF\x00" + bytes(1000),
}
MANY = 10**15
LYING = {
    ".ptx": f"{MANY}\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n",
    ".pts": f"{MANY}\n1 2 3\n",
    ".ply": (
        f"ply\nformat ascii 1.0\nelement vertex {MANY}\n"
        "property int x\nproperty int y\nproperty int z\nend_header\n1 2 3\n"
    ),
    ".pcd": (
        f"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {MANY}\nHEIGHT 1\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {MANY}\nDATA ascii\n1 2 3\n"
    ),
}


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("kind", sorted(GARBAGE))
@pytest.mark.parametrize("ask", [read_scan, describe_scan])
def test_garbage_is_refused(tmp_path: Path, suffix: str, kind: str, ask: object) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_bytes(GARBAGE[kind])
    with pytest.raises(InputError, match="needs"):
        ask(path, ScanRequest(frame="file"))  # type: ignore[operator]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_nothing_is_allocated_for_points_that_are_not_there(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_text(LYING[suffix])
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=f"needs the {MANY} points .*, came 1"):
            read_scan(path)
        # a block of text, not the points: those would be 24 PB
        assert tracemalloc.get_traced_memory()[1] < 32e6
    finally:
        tracemalloc.stop()
