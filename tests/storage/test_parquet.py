"""Rows survive Parquet, and rows that mean nothing never reach it."""

import math
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from storage.errors import StorageError
from storage.identity import SCHEMA_VERSION
from storage.parquet import encode_rows, encode_table, read_rows, schema_of, stored_row_count, table_from_rows
from storage.records import TABLES, SectionFit, TiltRow, columns_of
from tests.storage.campaign import epoch_row, tilt_row
from tests.storage.samples import bare_row, full_row

RECORDS = {**TABLES, "sections": SectionFit}
every_record = pytest.mark.parametrize("table", RECORDS)


@every_record
def test_rows_come_back_as_they_were(table: str, tmp_path: Path) -> None:
    record = RECORDS[table]
    rows = [full_row(record, 0), bare_row(record, 5), full_row(record, 11)]
    path = tmp_path / "rows.parquet"
    path.write_bytes(encode_rows(table, record, rows))
    assert read_rows(path, table, record) == rows


@every_record
def test_a_table_without_rows_keeps_its_columns(table: str, tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    path.write_bytes(encode_rows(table, RECORDS[table], []))
    assert read_rows(path, table, RECORDS[table]) == []
    assert pq.read_schema(path).equals(schema_of(table, RECORDS[table]))


@every_record
def test_the_file_says_unit_and_meaning_of_every_column(table: str, tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    path.write_bytes(encode_rows(table, RECORDS[table], []))
    schema = pq.read_schema(path)
    for field in columns_of(RECORDS[table]):
        stored = schema.field(field.name)
        assert stored.metadata[b"unit"].decode() == field.unit
        assert stored.metadata[b"meaning"].decode() == field.meaning
        assert stored.nullable == field.nullable
    assert schema.metadata[b"schema_version"] == str(SCHEMA_VERSION).encode()
    assert schema.metadata[b"table"] == table.encode()


@every_record
def test_equal_rows_are_equal_bytes(table: str) -> None:
    record = RECORDS[table]
    first, second = ([full_row(record, seed) for seed in range(20)] for _ in range(2))
    assert encode_rows(table, record, first) == encode_rows(table, record, second)


def test_a_time_of_another_zone_comes_back_as_the_same_instant(tmp_path: Path) -> None:
    row = epoch_row("e0")
    path = tmp_path / "rows.parquet"
    path.write_bytes(encode_rows("epochs", type(row), [row]))
    (found,) = read_rows(path, "epochs", type(row))
    assert found.epoch_time == row.epoch_time
    assert str(found.epoch_time.tzinfo) == "UTC"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, np.float64("nan")])
@pytest.mark.parametrize("column", ["tilt_deg", "rmse_m"])
def test_what_is_no_number_is_refused_by_table_column_and_row(column: str, value: float) -> None:
    rows = [tilt_row("e0"), tilt_row("e0", **{column: value})]
    with pytest.raises(StorageError, match=rf"table tilt, column {column}, row 1: .*never NaN"):
        table_from_rows("tilt", TiltRow, rows)


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("scheme", None, "column scheme, row 0: needed a value, got None"),
        ("scheme", 3, "column scheme, row 0: needed str, got int 3"),
        ("n_slices", 3.0, "column n_slices, row 0: needed int, got float 3.0"),
        ("n_slices", True, "column n_slices, row 0: needed int, got bool True"),
        ("n_slices", np.int64(3), "column n_slices, row 0: needed int, got int64"),
        ("n_slices", 2**63, "column n_slices, row 0: .*beyond 64 bits"),
        ("tilt_deg", "0.5", "column tilt_deg, row 0: needed float, got str '0.5'"),
        ("tilt_deg", True, "column tilt_deg, row 0: needed float, got bool True"),
        ("epoch_time", datetime(2025, 3, 14), "column epoch_time, row 0: .*no time zone"),
        ("epoch_time", "2025-03-14", "column epoch_time, row 0: needed datetime, got str"),
        ("verdict", "\ud800", "column verdict, row 0: .*Unicode"),
    ],
)
def test_a_value_of_the_wrong_kind_is_refused(column: str, value: object, message: str) -> None:
    with pytest.raises(StorageError, match=message):
        table_from_rows("tilt", TiltRow, [tilt_row("e0", **{column: value})])


def test_a_row_of_another_class_is_refused() -> None:
    with pytest.raises(StorageError, match="table tilt, row 0: needed a TiltRow, got a EpochRow"):
        table_from_rows("tilt", TiltRow, [epoch_row("e0")])  # type: ignore[list-item]


def test_a_whole_number_may_stand_for_a_float(tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    path.write_bytes(encode_rows("tilt", TiltRow, [tilt_row("e0", height_m=102)]))
    assert read_rows(path, "tilt", TiltRow) == [tilt_row("e0", height_m=102.0)]


def test_a_column_that_an_older_file_lacks_reads_as_null(tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    content = table_from_rows("tilt", TiltRow, [tilt_row("e0")])
    path.write_bytes(encode_table(content.drop_columns(["bending_m", "rmse_m"])))
    assert read_rows(path, "tilt", TiltRow) == [replace(tilt_row("e0"), bending_m=None, rmse_m=None)]


def test_a_file_without_a_column_that_must_have_values_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    path.write_bytes(
        encode_table(table_from_rows("tilt", TiltRow, [tilt_row("e0")]).drop_columns(["scheme"]))
    )
    with pytest.raises(StorageError, match="lacks column scheme"):
        read_rows(path, "tilt", TiltRow)


def test_a_column_that_a_newer_file_has_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    content = table_from_rows("tilt", TiltRow, [tilt_row("e0")])
    path.write_bytes(encode_table(content.append_column("colour", pa.array(["red"]))))
    assert read_rows(path, "tilt", TiltRow) == [tilt_row("e0")]


def test_a_file_of_a_newer_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    content = table_from_rows("tilt", TiltRow, [tilt_row("e0")])
    path.write_bytes(encode_table(content.replace_schema_metadata({"table": "tilt", "schema_version": "99"})))
    with pytest.raises(StorageError, match="schema version 99; this tiltwatch reads up to 2"):
        read_rows(path, "tilt", TiltRow)


def test_a_file_of_another_table_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    path.write_bytes(encode_rows("tilt", TiltRow, [tilt_row("e0")]))
    with pytest.raises(StorageError, match="needs table 'slices' of tiltwatch; it holds 'tilt'"):
        read_rows(path, "slices", TABLES["slices"])


def test_no_flipped_byte_goes_unseen_or_unchanged(tmp_path: Path) -> None:
    """Each byte of the pages is under a checksum; the rest either fails to parse or does not change a value."""
    rows = [tilt_row("e0", scheme=f"S{number}", tilt_deg=number / 7.0) for number in range(40)]
    whole = encode_rows("tilt", TiltRow, rows)
    path = tmp_path / "rows.parquet"
    end_of_pages = len(whole) - 8 - int.from_bytes(whole[-8:-4], "little")
    for place in range(4, end_of_pages, 97):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :])
        try:
            found = read_rows(path, "tilt", TiltRow)
        except StorageError:
            continue
        assert found == rows, place


def test_a_torn_file_is_told_by_its_path(tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    path.write_bytes(encode_rows("tilt", TiltRow, [tilt_row("e0")])[:-20])
    with pytest.raises(StorageError, match=r"rows\.parquet is damaged"):
        read_rows(path, "tilt", TiltRow)
    with pytest.raises(StorageError, match=r"rows\.parquet is damaged"):
        stored_row_count(path)
