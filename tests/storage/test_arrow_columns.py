"""Columns that are made from buffers are those of pyarrow, and pandas is not imported for them."""

import subprocess
import sys
from datetime import UTC, datetime, timedelta, timezone

import pyarrow as pa
import pytest

from storage import arrow_columns
from storage.arrow_columns import MICROSECONDS, arrow_column
from storage.parquet import encode_table
from tests.flows.calls import ROOT

INSTANT = datetime(2025, 1, 14, 6, 0, 0, 123_457, tzinfo=timezone(timedelta(hours=8)))
CASES = [
    (pa.bool_(), [True, False, None, True, True, False, False, True, True, None]),
    (pa.int64(), [0, -1, None, 2**63 - 1, -(2**63)]),
    (pa.float64(), [0.0, -0.0, None, 1e-308, 0.1 + 0.2, -1.5e300]),
    (pa.string(), ["", "a", None, "towards 133.8\u00b0", "\U0001f5fc", "x" * 1000]),
    (MICROSECONDS, [INSTANT, None, datetime(1969, 12, 31, 23, 59, 59, 999_999, tzinfo=UTC)]),
]


@pytest.mark.parametrize(("kind", "values"), CASES, ids=[str(kind) for kind, _ in CASES])
@pytest.mark.parametrize("part", [slice(None), slice(0, 0), slice(0, 1), slice(2, 3)])
def test_columns_and_their_parquet_are_those_of_pyarrow(kind: pa.DataType, values: list, part: slice) -> None:  # type: ignore[type-arg]
    made, wanted = arrow_column(values[part], kind), pa.array(values[part], type=kind)
    made.validate(full=True)
    assert made.equals(wanted)
    assert encode_table(pa.table({"x": made})) == encode_table(pa.table({"x": wanted}))


def test_text_beyond_the_offsets_and_unknown_types_are_left_to_pyarrow(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(arrow_columns, "MOST_TEXT_BYTES", 3)
    assert arrow_column(["abcd"], pa.string()).equals(pa.array(["abcd"]))
    assert arrow_column([1], pa.int8()).equals(pa.array([1], pa.int8()))


def test_rows_are_encoded_without_pandas() -> None:
    code = (
        "import sys; from storage.parquet import encode_rows; from storage.records import StageRunRow; "
        "encode_rows('runs', StageRunRow, []); print('pandas' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "False"
