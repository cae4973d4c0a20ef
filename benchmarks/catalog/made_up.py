"""Tables of a made-up epoch with as many rows as a real one has: 8 stations, 14 schemes and methods, 100 slices each."""

from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from itertools import combinations, product
from typing import Final

import numpy as np
import pyarrow as pa

from storage.digests import text_sha256
from storage.parquet import schema_of
from storage.records import TABLES, columns_of
from storage.tables import EPOCH_TABLES

STRUCTURE: Final = "chimney-01"
SETTINGS: Final = '{"structure": "chimney-01"}'
START: Final = datetime(2020, 1, 6, 6, tzinfo=UTC)
AXES: Final = (*product("ABCDEF", ("paper", "robust")), ("G", "robust"), ("S", "surface"))
N_SLICES: Final = 100
N_STATIONS: Final = 8
BANDS: Final = 20
SECTORS: Final = 36
N_PARAMETERS: Final = 10
QUANTITIES: Final = ("lean", "base", "bending", "radius", "centres")

Columns = Mapping[str, Sequence[object]]


def epoch_name(number: int) -> str:
    """Id of an epoch; sorts by time."""
    return f"e{number:04d}"


def epoch_content(number: int) -> dict[str, pa.Table]:
    """All tables that are published together for an epoch, by name."""
    rng = np.random.default_rng(number)
    return {table: _filled(table, _KEYS.get(table, _axes)(number), rng, number) for table in EPOCH_TABLES}


def run_content(number: int) -> pa.Table:
    """The ledger of the run that made an epoch."""
    stages = [f"{stage} {scheme}/{method}" for stage in ("slicing", "axis") for scheme, method in AXES]
    stages += [f"reading ST{station:02d}" for station in range(N_STATIONS)] * 2
    keys = {"stage": stages, "run": [run_name(number)] * len(stages)}
    return _filled("runs", keys, np.random.default_rng(number), number)


def run_name(number: int) -> str:
    """Id of the run that made an epoch."""
    return f"run-{epoch_name(number)}"


def series_content(n_epochs: int) -> dict[str, pa.Table]:
    """The tables that follow from all epochs, by name."""
    rng = np.random.default_rng(n_epochs)
    each = [(epoch_name(number), *axis) for number in range(n_epochs) for axis in AXES]
    tests = [(*key, quantity) for key in each for quantity in QUANTITIES]
    return {
        "control_chart": _filled("control_chart", _split(("epoch", "scheme", "method"), each), rng),
        "change_tests": _filled(
            "change_tests", _split(("epoch", "scheme", "method", "quantity"), tests), rng
        ),
        "trends": _filled("trends", _split(("scheme", "method"), AXES), rng),
    }


def _filled(table: str, keys: Columns, rng: np.random.Generator, number: int | None = None) -> pa.Table:
    """Rows with these keys; what is no key is random."""
    schema = schema_of(table, TABLES[table])
    n_rows = len(next(iter(keys.values())))
    known: dict[str, Sequence[object]] = {"structure": [STRUCTURE] * n_rows, **keys}
    if number is not None:
        known = {"epoch": [epoch_name(number)] * n_rows, **known}
        known["epoch_time"] = [START + timedelta(days=7 * number)] * n_rows
    columns = [
        pa.array(known[field.name] if field.name in known else _RANDOM[field.python_type](rng, n_rows), kind)
        for field, kind in zip(columns_of(TABLES[table]), schema.types, strict=True)
    ]
    return pa.Table.from_arrays(columns, schema=schema)


def _split(names: Sequence[str], keys: Sequence[tuple[object, ...]]) -> Columns:
    return dict(zip(names, zip(*keys, strict=True), strict=True))


def _texts(rng: np.random.Generator, n_rows: int) -> Sequence[object]:
    return [f"text {k}" for k in rng.integers(0, 10, n_rows)]


def _times(_rng: np.random.Generator, n_rows: int) -> Sequence[object]:
    return [START] * n_rows


_RANDOM: Final[Mapping[type, Callable[[np.random.Generator, int], Sequence[object]]]] = {
    bool: lambda rng, n_rows: list(rng.random(n_rows) < 0.5),
    int: lambda rng, n_rows: list(rng.integers(0, 1000, n_rows)),
    float: lambda rng, n_rows: list(rng.normal(size=n_rows)),
    str: _texts,
    datetime: _times,
}


def _epochs(number: int) -> Columns:
    digest = text_sha256(SETTINGS)
    return {
        "run": [run_name(number)],
        "state": ["ok"],
        "is_reference": [number == 0],
        "campaign_digest": [digest],
        "schema_version": [1],
        "code_version": ["c0de"],
    }


def _stations(_number: int) -> Columns:
    return {"station": [f"ST{station:02d}" for station in range(N_STATIONS)]}


def _pairs(_number: int) -> Columns:
    return _split(("station", "other"), list(combinations(_stations(0)["station"], 2)))


def _coverage(_number: int) -> Columns:
    cells = product(5.0 * np.arange(BANDS), 10.0 * np.arange(SECTORS))
    return _split(("z_low_m", "azimuth_low_deg"), list(cells))


def _surface_map(_number: int) -> Columns:
    cells = [(low_m, low_m + 5.0, azimuth) for low_m, azimuth in zip(*_coverage(0).values(), strict=True)]
    return _split(("z_low_m", "z_high_m", "azimuth_deg"), cells)


def _slices(_number: int) -> Columns:
    return _split(("scheme", "method", "slice_index"), [(*axis, k) for axis in AXES for k in range(N_SLICES)])


def _axes(_number: int) -> Columns:
    return _split(("scheme", "method"), AXES)


def _accuracy(_number: int) -> Columns:
    keys = [(*axis, f"quantity {k}") for axis in AXES for k in range(8)]
    return _split(("scheme", "method", "quantity"), keys)


def _parameters(_number: int) -> Columns:
    return _split(("scheme", "method", "place"), [(*axis, k) for axis in AXES for k in range(N_PARAMETERS)])


def _covariances(_number: int) -> Columns:
    pairs = [(i, k) for i in range(N_PARAMETERS) for k in range(i, N_PARAMETERS)]
    return _split(
        ("scheme", "method", "place_1", "place_2"), [(*axis, *pair) for axis in AXES for pair in pairs]
    )


_KEYS: Final[Mapping[str, Callable[[int], Columns]]] = {
    "epochs": _epochs,
    "stations": _stations,
    "pairs": _pairs,
    "removals": lambda _number: {"step": range(5)},
    "coverage": _coverage,
    "surface_map": _surface_map,
    "slices": _slices,
    "accuracy": _accuracy,
    "reference_leans": lambda _number: {"source": ["total station"]},
    "scheme_comparison": lambda _number: {"compared": [f"{scheme}/{method}" for scheme, method in AXES]},
    "axis_parameters": _parameters,
    "axis_covariances": _covariances,
}
"""What is in no row twice, by table; a table that is not here has a row a scheme and method."""
