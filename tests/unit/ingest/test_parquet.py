"""Parquet files that are whole, cut, damaged and hostile."""

import struct
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest import READERS, ScanRequest, describe_scan, read_scan
from tests.unit.ingest.clouds import wall_points
from tests.unit.ingest.compact import footer_of, page_of, whole_file

FLOAT32_AT_50_M = 4e-6
"""Half the distance of neighbouring float32 below 64 m, with room."""

STREET_M = np.array([4_412_345.0, 39_500_123.0, 78.0])
"""A Gauss-Krueger coordinate with its zone in front: float32 resolves 4 m there."""


def columns_of(points_m: NDArray[np.float64], kind: pa.DataType | None = None) -> dict[str, pa.Array]:
    names = ("x", "y", "z")
    return {
        name: pa.array(values).cast(kind or pa.float64(), safe=False)
        for name, values in zip(names, points_m.T, strict=True)
    }


def write(path: Path, columns: dict[str, pa.Array], **options: object) -> Path:
    pq.write_table(pa.table(columns), path, **{"row_group_size": 150, **options})
    return path


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"compression": "none", "use_dictionary": False},
        {"compression": "zstd", "data_page_version": "2.0"},
        {"compression": "gzip", "data_page_size": 256, "write_page_checksum": True},
        {"use_dictionary": False, "column_encoding": {"x": "BYTE_STREAM_SPLIT"}},
    ],
)
@pytest.mark.parametrize("suffix", [".parquet", ".pq"])
def test_every_record_of_every_row_group_comes_back_exactly(
    tmp_path: Path, suffix: str, options: dict[str, object]
) -> None:
    points_m = wall_points()
    scan = read_scan(write(tmp_path / f"a{suffix}", columns_of(points_m), **options))
    assert np.array_equal(scan.points_m, points_m)
    assert (scan.n_in_file, scan.notes) == (500, ())


def test_a_row_group_longer_than_a_piece_comes_back(tmp_path: Path) -> None:
    points_m = wall_points(150_000)
    path = write(tmp_path / "a.parquet", columns_of(points_m), row_group_size=140_000)
    assert np.array_equal(read_scan(path).points_m, points_m)


def test_columns_are_found_by_name_and_others_are_ignored(tmp_path: Path) -> None:
    points_m = wall_points()
    columns = columns_of(points_m)
    others = {
        "tag": pa.array([{"x": 1.0, "y": [2.0]}] * 500),
        "Z (m)": columns["z"],
        "intensity": pa.array(np.arange(500)),
        "Y_m": columns["y"],
        "name": pa.array(["a"] * 500),
        "X": columns["x"],
    }
    assert np.array_equal(read_scan(write(tmp_path / "a.parquet", others)).points_m, points_m)


def test_polar_records_become_cartesian(tmp_path: Path) -> None:
    columns = {"omega": pa.array([0.0, 30.0]), "S": pa.array([10.0, 20.0]), "alpha": pa.array([90.0, 0.0])}
    scan = read_scan(write(tmp_path / "a.parquet", columns), ScanRequest(coordinates="polar"))
    expected = [[0.0, 10.0, 0.0], [20.0 * np.cos(np.pi / 6.0), 0.0, 10.0]]
    # rounding of the sines of right angles
    assert scan.points_m == pytest.approx(np.array(expected), abs=1e-12)


def test_single_precision_near_the_scanner_is_read_without_a_note(tmp_path: Path) -> None:
    points_m = wall_points()
    scan = read_scan(write(tmp_path / "a.parquet", columns_of(points_m, pa.float32())))
    assert scan.points_m == pytest.approx(points_m, abs=FLOAT32_AT_50_M)
    assert scan.notes == ()


def test_single_precision_on_a_grid_is_refused_however_few_the_points(tmp_path: Path) -> None:
    path = write(tmp_path / "a.parquet", columns_of(wall_points(20) + STREET_M, pa.float32()))
    with pytest.raises(InputError, match="needs coordinates finer than 50 mm, came steps of 4e\\+03 mm"):
        read_scan(path)


def test_single_precision_some_kilometres_off_is_told(tmp_path: Path) -> None:
    points_m = wall_points(20) + np.array([40_000.0, 0.0, 0.0])
    scan = read_scan(
        write(tmp_path / "a.parquet", columns_of(points_m, pa.float32())),
        ScanRequest(origin_m=(40_000.0, 0.0, 0.0)),
    )
    assert "coordinates come in steps of 3.91 mm" in " ".join(scan.notes)


def test_whole_numbers_are_metres_in_steps_of_one(tmp_path: Path) -> None:
    path = write(tmp_path / "a.parquet", columns_of(wall_points() * 1000.0, pa.int32()))
    with pytest.raises(InputError, match="finer than 50 mm, came steps of 1e\\+03 mm"):
        read_scan(path)


def test_decimals_are_read_in_their_own_step(tmp_path: Path) -> None:
    points_m = np.round(wall_points(), 3)
    columns = columns_of(points_m)
    columns["x"] = columns["x"].cast(pa.decimal128(12, 3))
    scan = read_scan(write(tmp_path / "a.parquet", columns))
    # a decimal is rounded once to float64
    assert scan.points_m == pytest.approx(points_m, abs=1e-12)


def test_a_footer_is_described_without_its_records(tmp_path: Path) -> None:
    points_m = wall_points()
    path = write(tmp_path / "a.parquet", columns_of(points_m))
    header = describe_scan(path)
    assert (header.format, header.n_points, header.size_bytes) == ("Parquet", 500, path.stat().st_size)
    assert header.bounds is not None
    assert np.array_equal(header.bounds.low, points_m.min(axis=0))
    assert np.array_equal(header.bounds.high, points_m.max(axis=0))


def test_no_box_is_made_up_where_the_footer_states_none(tmp_path: Path) -> None:
    path = write(tmp_path / "a.parquet", columns_of(wall_points()), write_statistics=False)
    assert describe_scan(path).bounds is None


def test_nulls_are_refused_with_their_count(tmp_path: Path) -> None:
    columns = columns_of(wall_points(200))
    holes = [None if index in (3, 151, 180) else 1.5 * index for index in range(200)]
    path = write(tmp_path / "a.parquet", {**columns, "z": pa.array(holes)})
    with pytest.raises(InputError, match="came 3 of 200 records with a null in x, y, z; remove"):
        read_scan(path)


def test_nan_and_infinity_are_refused_with_their_count(tmp_path: Path) -> None:
    points_m = wall_points()
    points_m[4, 0], points_m[9, 1] = np.nan, np.inf
    for kind in (pa.float64(), pa.float32()):
        path = write(tmp_path / "a.parquet", columns_of(points_m, kind))
        with pytest.raises(InputError, match="came 2 of 500 points with NaN or infinity"):
            read_scan(path)


@pytest.mark.parametrize(
    ("column", "kind"),
    [
        (pa.array(["1.0"] * 20), "string"),
        (pa.array([True] * 20), "bool"),
        (pa.array([{"x": 1.0}] * 20), "struct"),
        (pa.array([[1.0]] * 20), "list"),
        (pa.array(["1.0", "2.0"] * 10).dictionary_encode(), "dictionary"),
        (pa.nulls(20), "null"),
    ],
)
def test_a_coordinate_that_is_no_number_is_refused(tmp_path: Path, column: pa.Array, kind: str) -> None:
    path = write(tmp_path / "a.parquet", {**columns_of(wall_points(20)), "x": column})
    for ask in (read_scan, describe_scan):
        with pytest.raises(InputError, match=f"needs numbers in column 'x', came {kind}.*double"):
            ask(path)


def test_a_missing_column_is_named_with_those_that_are_there(tmp_path: Path) -> None:
    columns = {"easting": pa.array([1.0]), "northing": pa.array([1.0])}
    with pytest.raises(InputError, match="needs one column 'x', came 0 among easting, northing"):
        read_scan(write(tmp_path / "a.parquet", columns))


def test_an_empty_table_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "a.parquet", columns_of(np.empty((0, 3))))
    with pytest.raises(InputError, match="holds no records"):
        read_scan(path)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.1, 0.5, 0.99])
def test_a_file_that_is_cut_is_refused(tmp_path: Path, share: float) -> None:
    path = write(tmp_path / "a.parquet", columns_of(wall_points()))
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])
    with pytest.raises(InputError, match=r"cut short|begins with 'PAR1'"):
        read_scan(path)


def test_a_flipped_bit_is_seen_where_pages_have_a_checksum(tmp_path: Path) -> None:
    options = {"write_page_checksum": True, "compression": "none", "use_dictionary": False}
    path = write(tmp_path / "a.parquet", columns_of(wall_points()), **options)
    content = bytearray(path.read_bytes())
    content[400] ^= 1
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"could not verify page integrity|CRC"):
        read_scan(path)


def test_a_chunk_of_another_type_than_its_column_does_not_end_the_process(tmp_path: Path) -> None:
    """It does with pyarrow's own objects for statistics: an exception of C++ that nothing catches."""
    page = page_of(8, 64, bytes(64))
    path = tmp_path / "a.parquet"
    path.write_bytes(whole_file(page, footer_of(page, n_records=8, chunk_type=0)))
    assert describe_scan(path).n_points == 8
    with pytest.raises(InputError, match=r"does not match .* cut short or damaged"):
        read_scan(path)


def test_a_file_written_by_hand_is_read_so_that_the_hostile_ones_below_differ_in_one_thing(
    tmp_path: Path,
) -> None:
    values = np.arange(1.0, 9.0)
    page = page_of(8, 64, values.tobytes())
    path = tmp_path / "a.parquet"
    path.write_bytes(whole_file(page, footer_of(page, n_records=8)))
    assert np.array_equal(read_scan(path).points_m, np.column_stack([values] * 3))


def _bomb(n_records: int) -> tuple[bytes, int]:
    """A page of some KB that unpacks to 128 MiB of zeros."""
    full_bytes = 128 << 20
    packed = pa.Codec("zstd").compress(bytes(full_bytes), asbytes=True)
    return page_of(n_records, full_bytes, packed), len(packed)


def test_a_page_that_unpacks_to_more_than_its_records_is_refused(tmp_path: Path) -> None:
    page, n_bytes = _bomb(1000)
    path = tmp_path / "a.parquet"
    path.write_bytes(whole_file(page, footer_of(page, n_records=1000, codec=6)))
    assert n_bytes < 10_000
    with pytest.raises(InputError, match=r"pages of at most 64 MiB .* came a page of 134217728 bytes"):
        describe_scan(path)


def test_more_records_than_such_a_file_can_hold_are_refused(tmp_path: Path) -> None:
    page = page_of(10**9, 8000, bytes(8000))
    path = tmp_path / "a.parquet"
    path.write_bytes(whole_file(page, footer_of(page, n_records=10**9)))
    with pytest.raises(InputError, match="needs at most 16 records a byte, came 1000000000 in"):
        describe_scan(path)


def test_pages_with_fewer_records_than_the_footer_states_are_refused(tmp_path: Path) -> None:
    page = page_of(8, 64, bytes(64))
    path = tmp_path / "a.parquet"
    path.write_bytes(whole_file(page, footer_of(page, n_records=1000)))
    with pytest.raises(InputError, match="needs the 1000 values of a row group in each column, came 8"):
        describe_scan(path)


def test_a_dictionary_longer_than_its_page_is_refused(tmp_path: Path) -> None:
    page = page_of(2**31 - 1, 64, bytes(64), is_dictionary=True) + page_of(8, 64, bytes(64))
    path = tmp_path / "a.parquet"
    path.write_bytes(whole_file(page, footer_of(page, n_records=8)))
    with pytest.raises(InputError, match="a dictionary of 2147483647 values in 64 bytes"):
        describe_scan(path)


@pytest.mark.parametrize("footer", [b"\x1c" * 900_000, b"\x19\xf0\xff\xff\xff\x7f", b"\x15\x02\x00"])
def test_a_footer_that_is_none_is_refused(tmp_path: Path, footer: bytes) -> None:
    path = tmp_path / "a.parquet"
    path.write_bytes(whole_file(b"", footer))
    with pytest.raises(InputError, match="cut short or damaged"):
        describe_scan(path)


def test_a_footer_larger_than_any_scan_needs_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    path.write_bytes(b"PAR1" + bytes(2 << 20) + struct.pack("<I", 2 << 20) + b"PAR1")
    with pytest.raises(InputError, match="needs a footer of at most 1048576 bytes, came 2097152"):
        describe_scan(path)


def test_an_encrypted_file_is_told_apart_from_a_damaged_one(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    path.write_bytes(b"PARE" + bytes(100) + b"PARE")
    with pytest.raises(InputError, match="came an encrypted one"):
        read_scan(path)


def test_no_flipped_byte_gives_anything_but_points_or_a_refusal(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    path = write(tmp_path / "a.parquet", columns_of(wall_points(60)), row_group_size=30)
    whole = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    refused = 0
    for _ in range(300):
        damaged = whole.copy()
        damaged[rng.integers(len(whole), size=3)] = rng.integers(256, size=3)
        path.write_bytes(damaged.tobytes())
        try:
            assert read_scan(path).n_in_file == 60
        except InputError:
            refused += 1
    # most of such a small file is footer
    assert refused > 100


def test_the_reader_is_found_by_itself() -> None:
    assert READERS["parquet"].suffixes == (".parquet", ".pq")
