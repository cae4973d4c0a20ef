"""Points are sorted into layers of equal height as a stable sort of the layers would."""

import numpy as np
import pytest

from tasks.geometry.layer_kernel import rows_of_cube_layers, rows_of_layers


@pytest.mark.parametrize("n", [0, 1, 20_000])
def test_rows_come_layer_by_layer_and_as_they_came(n: int) -> None:
    z_m = np.random.default_rng(1).uniform(-5.0, 40.0, n)
    layer = np.clip((z_m - 1.5) * 0.7, 0, 12).astype(int)
    rows, begins = rows_of_layers(z_m, 1.5, 0.7, 12)
    assert rows.tolist() == np.argsort(layer, kind="stable").tolist()
    assert begins.tolist() == [0, *np.cumsum(np.bincount(layer, minlength=13))]


def test_heights_may_lie_apart_in_memory() -> None:
    points_m = np.random.default_rng(2).uniform(0.0, 9.0, (500, 3))
    apart, _ = rows_of_layers(points_m[:, 2], 0.0, 1.0, 8)
    together, _ = rows_of_layers(points_m[:, 2].copy(), 0.0, 1.0, 8)
    assert np.array_equal(apart, together)


def test_layers_of_cubes_leave_out_what_does_not_count() -> None:
    rng = np.random.default_rng(3)
    z_m, among = rng.uniform(2.0, 30.0, 5_000), rng.random(5_000) < 0.7
    layer = (np.floor((z_m - 2.0) / 0.05) / 40.0).astype(int)
    rows, begins = rows_of_cube_layers(z_m, among, 2.0, 0.05, 40.0, 14)
    assert rows.tolist() == [row for row in np.argsort(layer, kind="stable").tolist() if among[row]]
    assert begins.tolist() == [0, *np.cumsum(np.bincount(layer[among], minlength=14))]
