"""A scan whose bytes make its decoder crash, loop or fill the memory is refused; the next one is read."""

import errno
import signal
import subprocess
import sys
import time
from pathlib import Path

import laspy
import numpy as np
import psutil
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from storage.errors import InputError
from storage.workspace import open_workspace
from tasks.caching import lasting
from tasks.ingest import ScanRequest, laz_decoder, read_scan, stream_scan
from tasks.ingest.third_party import decoding
from tasks.stored_scan import store_scan
from tests.unit.decoders.doubles import PLACE, children_with, spoilt_pool
from tests.unit.ingest.clouds import wall_points, write_las

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="ends of processes have other names there")
ROOT = Path(__file__).resolve().parents[3]


def write(path: Path, n_points: int = 500) -> Path:
    points_m = wall_points(n_points)
    if path.suffix == ".laz":
        return write_las(path, points_m)
    pq.write_table(pa.table(dict(zip("xyz", points_m.T, strict=True))), path)
    return path


@pytest.mark.parametrize("suffix", [".laz", ".parquet"])
@pytest.mark.parametrize(
    ("deed", "came"),
    [
        ("segfault", "SIGSEGV"),
        ("abort", "SIGABRT"),
        ("loop", "computes for over 0.5 s"),
        ("hunger", "wants more than 256 MiB"),
        ("panic", "PanicException"),
    ],
)
def test_what_its_decoder_does_costs_a_scan_and_no_other(
    tmp_path: Path, suffix: str, deed: str, came: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if deed == "loop":
        monkeypatch.setattr(f"{PLACE[suffix]}.COMPUTING_S", 0.5 - 500 * 20e-6 if suffix == ".laz" else 0.5)
        monkeypatch.setattr("storage.decoders.parquet_points.PIECE_RECORDS", 1 << 10)
        monkeypatch.setattr("storage.decoders.parquet_points.RECORD_S", 0.0)
    pool = spoilt_pool(tmp_path, suffix, deed)
    monkeypatch.setattr(f"{PLACE[suffix]}.DECODERS", pool)
    bad, good = write(tmp_path / f"bad{suffix}"), write(tmp_path / f"good{suffix}")
    expected = wall_points()
    with pytest.raises(InputError, match=rf"bad\{suffix}: needs points .*{came}.* copy or export") as refused:
        read_scan(bad)
    # it lies in the file: a stage may remember it
    assert lasting(refused.value) is refused.value
    assert read_scan(good).points_m == pytest.approx(expected, abs=1e-9)
    pool.end_idle()
    assert children_with(deed) == []


def test_a_decoder_that_the_system_ended_is_not_remembered_as_a_fault_of_the_scan(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tasks.ingest.laz_decoder.DECODERS", spoilt_pool(tmp_path, ".laz", "be_killed"))
    with pytest.raises(InputError, match=r"ended from outside \(SIGKILL\); free memory") as refused:
        read_scan(write(tmp_path / "bad.laz"))
    with pytest.raises(InputError):
        lasting(refused.value)


@pytest.mark.parametrize("suffix", [".laz", ".parquet"])
def test_a_drive_that_fails_under_a_decoder_is_no_damage_of_the_scan(
    tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(f"{PLACE[suffix]}.DECODERS", spoilt_pool(tmp_path, suffix, "be_refused"))
    with pytest.raises(InputError, match=r"needs a readable file, came Input/output error$") as refused:
        read_scan(write(tmp_path / f"bad{suffix}"))
    with pytest.raises(InputError, match="Input/output error"):
        lasting(refused.value)


@pytest.mark.parametrize("fault", [OSError("Corrupt snappy data"), OSError(errno.EINVAL, "Invalid argument")])
def test_what_a_decoder_says_of_its_input_by_a_fault_of_the_system_is_damage(fault: OSError) -> None:
    with pytest.raises(InputError, match="damaged, copy or export it again"), decoding(Path("a.pq")):
        raise fault


def test_nothing_of_a_scan_whose_decoder_crashes_midway_is_stored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pool = spoilt_pool(tmp_path, ".laz", "segfault")
    monkeypatch.setattr("tasks.ingest.laz_decoder.DECODERS", pool)
    ws = open_workspace(tmp_path / "ws")
    with pytest.raises(InputError, match="SIGSEGV"):
        store_scan(ws, write(tmp_path / "bad.laz"), ScanRequest())
    assert [path for path in ws.artifacts.rglob("*") if path.is_file()] == []
    assert store_scan(ws, write(tmp_path / "good.laz"), ScanRequest()).facts.n_in_file == 500
    pool.end_idle()


def test_layers_that_lie_end_the_real_decoder_and_not_this_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without our own check before: lazrs believes the size of a layer, and Rust aborts where memory is refused."""
    path = write(tmp_path / "a.laz")
    with laspy.open(path) as source:
        at = source.header.offset_to_point_data + 8
    content = bytearray(path.read_bytes())
    # behind the first point (30 bytes) and the count: the first layers of nine
    content[at + 34 : at + 46] = np.full(3, 0xFFFFFFF0, "<u4").tobytes()
    path.write_bytes(content)
    with pytest.raises(InputError, match="layers of"):
        read_scan(path)
    monkeypatch.setattr("tasks.ingest.laz_chunks._check_layers", lambda *_: None)
    with pytest.raises(InputError, match=r"needs points that can be decoded, came a decoder that .*SIGABRT"):
        read_scan(path)


def test_a_scan_that_is_not_read_to_its_end_leaves_no_decoder_at_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tasks.ingest.las_points.PIECE_BYTES", 30 * 50_000)
    pieces = stream_scan(write(tmp_path / "a.laz", 200_000)).pieces(lambda _: None)
    laz_decoder.DECODERS.end_idle()
    next(pieces)
    [decoder] = children_with("laz_program")
    del pieces
    assert not decoder.is_running()


PARENT = """
import sys
from pathlib import Path
from storage.decoders.pool import DecoderPool
from storage.decoders.process import DecoderProgram, Limits
decoder = DecoderPool(DecoderProgram("deeds", Path(sys.argv[1]), 1 << 28))._taken()
decoder.memory.grow(1 << 20)
if sys.argv[2] != "idle":
    decoder.send(sys.argv[2], Limits(1.0, 2.0))
print(decoder.pid, flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize("deed", ["idle", "loop", "wait"])
def test_a_decoder_is_gone_soon_after_its_parent_was_killed(tmp_path: Path, deed: str) -> None:
    from tests.unit.decoders.doubles import pool_of_deeds  # noqa: PLC0415 - writes the file, no more

    program = pool_of_deeds(tmp_path).program.file
    with subprocess.Popen(
        [sys.executable, "-c", PARENT, str(program), deed],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as parent:
        assert parent.stdout is not None
        decoder = psutil.Process(int(parent.stdout.readline()))
        parent.send_signal(signal.SIGKILL)
    until = time.monotonic() + 60.0
    while decoder.is_running() and decoder.status() != psutil.STATUS_ZOMBIE and time.monotonic() < until:
        time.sleep(0.05)
    assert not decoder.is_running() or decoder.status() == psutil.STATUS_ZOMBIE
