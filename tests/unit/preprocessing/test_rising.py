"""Points from the bottom up are those of a stable sort of all."""

import numpy as np
import pytest

from tasks.preprocessing.rising import from_bottom_up


@pytest.mark.parametrize("layer_points", [1 << 17, 100])
def test_it_is_a_stable_sort_by_height(layer_points: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tasks.preprocessing.rising.LAYER_POINTS", layer_points)
    rng = np.random.default_rng(1)
    # heights of 1 cm: many are equal
    points_m = np.round(rng.uniform(-3.0, 40.0, (20_000, 3)), 2)
    scan_index, stay = rng.integers(0, 8, 20_000).astype(np.uint16), rng.random(20_000) < 0.8
    rows = np.flatnonzero(stay)
    rising = rows[np.argsort(points_m[rows, 2], kind="stable")]
    sorted_m, of_scan = from_bottom_up(points_m, scan_index, stay)
    assert np.array_equal(sorted_m, points_m[rising])
    assert np.array_equal(of_scan, scan_index[rising])


def test_points_of_one_height_and_no_points_at_all() -> None:
    level_m, index = (
        np.column_stack([np.arange(5.0), np.arange(5.0), np.ones(5)]),
        np.arange(5, dtype=np.uint16),
    )
    sorted_m, of_scan = from_bottom_up(level_m, index, np.ones(5, dtype=np.bool_))
    assert np.array_equal(sorted_m, level_m)
    assert np.array_equal(of_scan, index)
    assert len(from_bottom_up(level_m, index, np.zeros(5, dtype=np.bool_))[0]) == 0
