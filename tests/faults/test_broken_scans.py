"""Scans that are damaged, lie, or are something else: InputError, soon, and nothing but InputError."""

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from storage.errors import InputError
from tasks.ingest import AS_STATED, ScanRequest, describe_scan, read_scan
from tests.shared import SHARED, needs_shared
from tests.unit.ingest.clouds import rows_of, wall_points, write_las, write_text

pytestmark = pytest.mark.timeout(60)

MALFORMED = SHARED / "data" / "malformed"
SOUND_BUT_STRANGE = {
    "hextest.las": 8,
    # coordinate systems in metres with empty or padded records; the points are whole
    "1.2-empty-geotiff-vlrs.las": 43,
    "bad-geotiff-keys.las": 10,
}
"""Files of the folder whose points are whole, and how many they are."""

BROKEN = sorted(
    path
    for path in MALFORMED.rglob("*.*")
    if path.suffix not in {".md", ""} and path.name not in {*SOUND_BUT_STRANGE, "LICENSE"}
)
ONLY_ITS_POINTS_ARE_WRONG = {"read_error.e57"}
"""Its header is sound; that all its points lie in the scanner is seen when they are read."""

FUZZ = settings(
    max_examples=120,
    deadline=5000,  # milliseconds: a hang is a fault
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


@needs_shared
@pytest.mark.timeout(5)
@pytest.mark.parametrize("ask", [read_scan, describe_scan])
@pytest.mark.parametrize("path", BROKEN, ids=lambda path: path.name)
def test_a_malformed_file_is_refused_within_seconds(path: Path, ask: Callable[[Path], object]) -> None:
    if ask is describe_scan and path.name in ONLY_ITS_POINTS_ARE_WRONG:
        assert describe_scan(path).n_points
        return
    with pytest.raises(InputError, match=rf"{path.name}: needs .*, came .*"):
        ask(path)


@needs_shared
@pytest.mark.parametrize("name", sorted(SOUND_BUT_STRANGE))
def test_a_strange_file_with_sound_points_gives_them_all(name: str) -> None:
    assert read_scan(next(MALFORMED.rglob(name))).n_in_file == SOUND_BUT_STRANGE[name]


@pytest.fixture(params=["old.las", "old.laz", "new.las", "new.laz"])
def whole(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    version, point_format = ("1.2", 1) if request.param.startswith("old") else ("1.4", 7)
    return write_las(tmp_path / request.param, wall_points(300), version=version, point_format=point_format)


@pytest.mark.parametrize("cut", [0, 3, 100, 226, 300, 0.1, 0.5, 0.9, 0.99, -8, -1])
def test_a_file_cut_anywhere_is_refused(whole: Path, cut: float) -> None:
    content = whole.read_bytes()
    whole.write_bytes(content[: int(cut * len(content)) if isinstance(cut, float) else cut])
    with pytest.raises(InputError, match=r"cut short|begins with 'LASF'"):
        read_scan(whole)


def _overwrite(path: Path, at: int, kind: str, value: float) -> None:
    content = bytearray(path.read_bytes())
    struct.pack_into("<" + kind, content, at, value)
    path.write_bytes(content)


def _state_count(path: Path, n_points: int) -> None:
    is_new = path.name.startswith("new")
    if is_new:
        _overwrite(path, 107, "I", 0)
    _overwrite(path, 247 if is_new else 107, "Q" if is_new else "I", n_points)


@pytest.mark.parametrize("n_points", [1, 299, 301, 100_000, 4_000_000_000])
@pytest.mark.parametrize("name", ["new.las", "new.laz", "old.las"])
def test_a_count_that_disagrees_with_the_points_is_seen_in_the_header(
    tmp_path: Path, name: str, n_points: int
) -> None:
    version, point_format = ("1.2", 1) if name.startswith("old") else ("1.4", 7)
    path = write_las(tmp_path / name, wall_points(300), version=version, point_format=point_format)
    _state_count(path, n_points)
    for ask in (read_scan, describe_scan):
        with pytest.raises(InputError, match=rf"{n_points}.*, came .*300"):
            ask(path)


@pytest.mark.parametrize("n_points", [400, 50_000, 50_001, 4_000_000_000])
def test_too_large_a_count_over_the_old_compression_is_refused(tmp_path: Path, n_points: int) -> None:
    # its chunks do not say how many points they hold: within the last one only decoding tells
    path = write_las(tmp_path / "old.laz", wall_points(300), version="1.2", point_format=1)
    _state_count(path, n_points)
    with pytest.raises(InputError, match=rf"{n_points}|decoded"):
        read_scan(path)


def test_a_las_count_names_both_counts(tmp_path: Path) -> None:
    path = write_las(tmp_path / "old.las", wall_points(300), version="1.2", point_format=1)
    _state_count(path, 200)
    with pytest.raises(InputError, match="as many points as its header states, 200, came 300"):
        read_scan(path)
    _state_count(path, 400)
    with pytest.raises(InputError, match="the 400 points that its header states, came room for 300 points"):
        read_scan(path)


def test_a_file_without_points_is_refused(whole: Path) -> None:
    _state_count(whole, 0)
    with pytest.raises(InputError, match="holds no points"):
        read_scan(whole)


@pytest.mark.parametrize(
    ("at", "kind", "value", "message"),
    [
        (0, "B", 0, "begins with 'LASF'"),
        (24, "B", 2, r"needs LAS 1\.0 to 1\.4, came version 2\."),
        (25, "B", 5, r"came version 1\.5"),
        (94, "H", 10, "a header of at least"),
        (94, "H", 65535, "a header of at least"),
        (96, "I", 4_000_000_000, "points from byte 4000000000"),
        (96, "I", 0, "a header of at least"),
        (100, "I", 1_069_128_089, "the 1069128089 variable length records that its header states"),
        (104, "B", 11, "point format"),
        (105, "H", 3, "point records of at least"),
        (131, "d", 0.0, "positive scale factors"),
        (139, "d", np.nan, "positive scale factors"),
        (155, "d", np.inf, "finite offsets"),
        (147, "d", 1e300, "needs .*, came"),
    ],
)
def test_a_header_that_lies_is_refused(whole: Path, at: int, kind: str, value: float, message: str) -> None:
    _overwrite(whole, at, kind, value)
    with pytest.raises(InputError, match=message):
        read_scan(whole)


def test_a_chunk_size_beyond_memory_is_not_allocated(tmp_path: Path) -> None:
    path = write_las(tmp_path / "old.laz", wall_points(300), version="1.2", point_format=1)
    points_m = read_scan(path).points_m
    # the laszip record is the first; its chunk size is 12 bytes into it
    _overwrite(path, 227 + 54 + 12, "I", 4_000_000_000)
    assert np.array_equal(read_scan(path).points_m, points_m)


def test_billions_of_points_in_a_few_bytes_are_not_allocated(tmp_path: Path) -> None:
    """Its chunk size and its header agree on them; arithmetic coding knows no least size of a point."""
    path = write_las(tmp_path / "a.laz", wall_points(50), version="1.2", point_format=0)
    content = bytearray(path.read_bytes())
    struct.pack_into("<I", content, 107, 1_900_000_000)
    struct.pack_into("<I", content, content.index(b"laszip encoded") + 52 + 12, 2_000_000_000)
    path.write_bytes(content)
    with pytest.raises(
        InputError, match=r"needs the 1900000000 points that its header states, came \d+ bytes of points"
    ):
        read_scan(path)


def test_a_chunk_table_of_billions_is_not_allocated(tmp_path: Path) -> None:
    path = write_las(tmp_path / "new.laz", wall_points(300))
    content = path.read_bytes()
    (points_at,) = struct.unpack_from("<I", content, 96)
    (table_at,) = struct.unpack_from("<q", content, points_at)
    _overwrite(path, table_at + 4, "I", 4_000_000_000)
    with pytest.raises(InputError, match=r"needs at most .* chunks in .* bytes, came 4000000000"):
        read_scan(path)


def test_layers_beyond_their_chunk_are_not_allocated(tmp_path: Path) -> None:
    path = write_las(tmp_path / "new.laz", wall_points(300))
    (points_at,) = struct.unpack_from("<I", path.read_bytes(), 96)
    _overwrite(path, points_at + 8 + 30 + 4, "I", 4_000_000_000)
    with pytest.raises(InputError, match=r"needs .* bytes in chunk 0, came layers of 4"):
        read_scan(path)


@pytest.mark.parametrize("content", [b"PK\x03\x04" * 100, b"ASTM-E57" * 100, b"x y z\n1 2 3\n", b""])
@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_another_format_under_the_suffix_is_refused(tmp_path: Path, content: bytes, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError, match="needs a LAS or LAZ file, which begins with 'LASF'"):
        read_scan(path)


def test_a_laz_file_under_a_las_suffix_is_read(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.laz", wall_points(300)).rename(tmp_path / "a.las")
    assert read_scan(path).n_in_file == 300


def _read_or_refuse(
    path: Path, content: bytes, n_whole: int | None, request: ScanRequest = AS_STATED
) -> None:
    path.write_bytes(content)
    try:
        n_in_file = read_scan(path, request).n_in_file
    except InputError:
        return
    assert n_whole is None or n_in_file == n_whole


@FUZZ
@given(content=st.binary(max_size=2000), suffix=st.sampled_from([".las", ".laz", ".csv", ".xyz"]))
def test_random_bytes_are_refused(tmp_path: Path, content: bytes, suffix: str) -> None:
    _read_or_refuse(tmp_path / f"a{suffix}", content, None)


@FUZZ
@given(data=st.data())
def test_flipped_bytes_lose_no_points_silently(whole: Path, data: st.DataObject) -> None:
    if not (keep := whole.with_suffix(".keep")).exists():
        keep.write_bytes(whole.read_bytes())
    content = bytearray(keep.read_bytes())
    heads = st.integers(0, min(len(content), 700) - 1)
    flips = data.draw(
        st.lists(
            st.tuples(heads | st.integers(0, len(content) - 1), st.integers(0, 255)), min_size=1, max_size=6
        )
    )
    for at, value in flips:
        content[at] = value
    # the count of the header and the size of the file hold each other; in the old compression only roughly
    _read_or_refuse(whole, bytes(content), None if whole.name == "old.laz" else 300)


@FUZZ
@given(cut=st.floats(0.0, 1.0, exclude_max=True))
def test_random_cuts_are_refused(whole: Path, cut: float) -> None:
    if not (keep := whole.with_suffix(".keep")).exists():
        keep.write_bytes(whole.read_bytes())
    content = keep.read_bytes()
    whole.write_bytes(content[: int(cut * len(content))])
    with pytest.raises(InputError, match=r"needs .*, came .*"):
        read_scan(whole)


@FUZZ
@given(data=st.data())
def test_damaged_text_is_read_or_refused(tmp_path: Path, data: st.DataObject) -> None:
    content = bytearray(b"x,y,z,i\n" + rows_of(wall_points(30), ",").encode())
    for at, value in data.draw(
        st.lists(st.tuples(st.integers(0, len(content) - 1), st.integers(0, 255)), min_size=1, max_size=6)
    ):
        content[at] = value
    _read_or_refuse(tmp_path / "a.csv", bytes(content[: data.draw(st.integers(0, len(content)))]), None)


@FUZZ
@given(text=st.text(alphabet='0123456789.,;-+eE xyzXYZ\t\n\r#/naif"()', max_size=200), polar=st.booleans())
def test_text_that_is_nearly_a_scan_is_read_or_refused(tmp_path: Path, text: str, polar: bool) -> None:
    request = ScanRequest(coordinates="polar" if polar else "cartesian")
    write_text(tmp_path / "a.csv", text)
    _read_or_refuse(tmp_path / "a.csv", text.encode(), None, request)
