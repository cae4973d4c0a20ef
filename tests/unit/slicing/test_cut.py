import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.slicing import SCHEMES, cut_between, cut_slices, rows_between_edges, rows_of_slices, slice_heights


def test_each_slice_holds_the_points_of_equation_2() -> None:
    rng = np.random.default_rng(1)
    z = rng.uniform(-1.0, 12.0, 20_000)
    heights = slice_heights(SCHEMES["A"], (0.0, 10.01))
    for height, found in zip(heights, cut_slices(z, heights, 0.01), strict=True):
        expected = np.flatnonzero((z >= height - 0.005) & (z <= height + 0.005))
        np.testing.assert_array_equal(found, expected)


def test_overlapping_slices_share_points() -> None:
    z = np.array([0.0, 0.9, 1.1, 2.0])
    lower, upper = cut_slices(z, np.array([0.5, 1.5]), 1.5)
    assert lower.tolist() == [0, 1, 2]
    assert upper.tolist() == [1, 2, 3]


def test_both_ends_are_closed_for_decimal_heights() -> None:
    z = np.array([1.0, 1.005, 1.01, 1.0101, 0.9999])
    assert cut_slices(z, np.array([1.005]), 0.01)[0].tolist() == [0, 1, 2]


def test_heights_need_not_be_sorted() -> None:
    z = np.array([5.0, 1.0, 3.0])
    assert [found.tolist() for found in cut_slices(z, np.array([3.0, 1.0, 5.0]), 0.1)] == [[2], [1], [0]]


def test_points_that_are_not_numbers_lie_in_no_slice() -> None:
    z = np.array([np.nan, 1.0, np.inf])
    assert cut_slices(z, np.array([1.0]), 0.1)[0].tolist() == [1]


def test_no_points_or_no_heights_give_empty_slices() -> None:
    assert [len(found) for found in cut_slices(np.empty(0), np.array([1.0, 2.0]), 0.1)] == [0, 0]
    assert cut_slices(np.array([1.0]), np.empty(0), 0.1) == []


def test_points_of_the_wrong_shape_are_misuse() -> None:
    with pytest.raises(ShapeError, match=r"heights \(n,\)"):
        cut_slices(np.zeros((4, 3)), np.array([1.0]), 0.1)


@pytest.mark.parametrize("seed", range(5))
def test_points_from_the_bottom_up_are_cut_as_any_others(seed: int) -> None:
    rng = np.random.default_rng(seed)
    # rounded, so that many lie on the ends
    z_m = np.round(rng.uniform(0.0, 12.0, 4_000), 1)
    rising = np.argsort(z_m, kind="stable")
    heights_m, edges_m = np.arange(1.0, 12.0, 0.5), np.arange(0.5, 11.1, 0.25)
    for cut in (lambda z: cut_slices(z, heights_m, 0.2), lambda z: cut_between(z, edges_m)):
        plain, sorted_first = cut(z_m), cut(z_m[rising])
        assert sum(map(len, plain)) > 1_000
        for rows, runs in zip(plain, sorted_first, strict=True):
            assert rows.tolist() == np.sort(rising[runs]).tolist()


def test_rows_of_heights_that_ascend_are_those_of_their_indices() -> None:
    z_m = np.sort(np.random.default_rng(4).uniform(0.0, 10.0, 2_000))
    heights_m, edges_m = np.arange(0.5, 10.0, 0.25), np.linspace(1.0, 9.0, 17)
    for rising in (True, False):
        order = np.arange(2_000) if rising else np.random.default_rng(5).permutation(2_000)
        z, number = z_m[order], np.arange(2_000)
        for rows, indices in (
            (rows_of_slices(z, heights_m, 1.0), cut_slices(z, heights_m, 1.0)),
            (rows_between_edges(z, edges_m), cut_between(z, edges_m)),
        ):
            assert all(isinstance(run, slice) == rising for run in rows)
            assert all(np.array_equal(number[run], index) for run, index in zip(rows, indices, strict=True))
