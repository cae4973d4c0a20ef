"""What trends and charts of a structure cost, once for each number of epochs.

.venv/bin/python -m benchmarks.change trend_speed [--seed 1]
"""

import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta

import numpy as np

from benchmarks.change.simulated_series import asked_of, print_rows
from storage.records import TiltRow
from tasks.trend_rows import chart_rows, trend_rows

HEIGHT_M = 100.0
SIGMA = 1e-5
FIRST = datetime(2015, 3, 1, tzinfo=UTC)
WAYS = [(name, method) for name in "ABCDEFS" for method in ("paper", "robust")]


def main(arguments: Sequence[str]) -> None:
    """Print seconds of the processor for 14 schemes and methods, still and with a change in the middle."""
    asked = asked_of("trend_speed", __doc__, arguments, 1)
    rows = []
    for n in (12, 100):
        for rate in (0.0, 0.010):
            tilt = _tilt(np.random.default_rng(asked.seed), n, rate)
            primary = _seconds(lambda tilt=tilt: trend_rows(tilt, primary=WAYS[-1]))
            every = _seconds(lambda tilt=tilt: trend_rows(tilt))
            chart = _seconds(lambda tilt=tilt: chart_rows(tilt))
            rows.append(f"{n} | {1000 * rate:g} | {primary:.2f} | {every:.2f} | {chart:.2f}")
    print("Seconds of the processor, 14 schemes and methods\n")
    print_rows(
        "epochs | rate after a change (mm/a) | trends, change under primary | under each | chart", rows
    )


def _seconds(call: Callable[[], object]) -> float:
    begun = time.process_time()
    call()
    return time.process_time() - begun


def _tilt(rng: np.random.Generator, n: int, rate: float) -> list[TiltRow]:
    days = np.cumsum(rng.integers(100, 200, n))
    moved = 0.15 + rate * np.maximum(days - days[n // 2], 0) / 365.25
    return [
        _row(
            way, k, float(day), (moved[k] + 1e-3 * rng.standard_normal(), 0.05 + 1e-3 * rng.standard_normal())
        )
        for way in WAYS
        for k, day in enumerate(days)
    ]


def _row(way: tuple[str, str], k: int, day: float, moved_m: tuple[float, float]) -> TiltRow:
    known = {
        "structure": "chimney-01",
        "epoch": f"e{k}",
        "epoch_time": FIRST + timedelta(days=day),
        "scheme": way[0],
        "method": way[1],
        "lean_east": moved_m[0] / HEIGHT_M,
        "lean_north": moved_m[1] / HEIGHT_M,
        "lean_cov_ee": SIGMA**2,
        "lean_cov_en": 0.0,
        "lean_cov_nn": SIGMA**2,
        "height_m": HEIGHT_M,
        "allowable_m": 0.5,
        "verdict": "pass",
    }
    names = [name for name in TiltRow.__dataclass_fields__ if name not in known]
    return TiltRow(**known, **dict.fromkeys(names))  # what a trend does not read is left empty
