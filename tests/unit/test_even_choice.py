"""One of every so many: as many as asked, in no pattern, and the same however the row is cut."""

import numpy as np
import pytest

from tasks.geometry.choice_kernel import scrambled
from tasks.geometry.even_choice import one_of_every


@pytest.mark.parametrize("step", [2, 7, 24])
def test_every_group_gives_one(step: int) -> None:
    chosen = one_of_every(step, 0, 1_000 * step)
    assert np.array_equal(chosen // step, np.arange(1_000))


def test_all_stay_where_one_of_one_does() -> None:
    assert np.array_equal(one_of_every(1, 5, 3), [0, 1, 2])


@pytest.mark.parametrize("lengths", [[1] * 50, [3, 0, 4, 43], [17, 33]])
def test_a_row_may_come_in_parts(lengths: list[int]) -> None:
    begins = np.cumsum([0, *lengths])
    parts = [begin + one_of_every(6, begin, n) for begin, n in zip(begins, lengths, strict=False)]
    assert np.array_equal(np.concatenate(parts), one_of_every(6, 0, 50))


def test_places_within_groups_follow_no_pattern() -> None:
    within = one_of_every(8, 0, 80_000) % 8
    counts = np.bincount(within, minlength=8)
    # 10,000 draws of 8: 1250 +- 33 each; and neighbours do not tell of one another
    assert counts == pytest.approx(np.full(8, 1250), abs=150)
    assert abs(np.corrcoef(within[:-1], within[1:])[0, 1]) < 0.04


def test_numbers_are_those_of_splitmix64() -> None:
    # first outputs of the reference implementation for seed 0 (Vigna, prng.di.unimi.it/splitmix64.c)
    expected = [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]
    assert [int(scrambled(number)) for number in range(3)] == expected
