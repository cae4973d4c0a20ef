"""The loops that draw one of every so many points, in no pattern and the same on every machine, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

GOLDEN: Final = np.uint64(0x9E3779B97F4A7C15)
FIRST_SHIFT: Final = np.uint64(30)
FIRST_FACTOR: Final = np.uint64(0xBF58476D1CE4E5B9)
SECOND_SHIFT: Final = np.uint64(27)
SECOND_FACTOR: Final = np.uint64(0x94D049BB133111EB)
LAST_SHIFT: Final = np.uint64(31)


@compiled
def scrambled(number: int) -> np.uint64:
    """A number without pattern from one that counts, from 0 (splitmix64).

    References
    ----------
    Steele, Lea & Flood 2014, Fast splittable pseudorandom number generators, OOPSLA.
    """
    mixed = np.uint64(number + 1) * GOLDEN
    mixed = (mixed ^ (mixed >> FIRST_SHIFT)) * FIRST_FACTOR
    mixed = (mixed ^ (mixed >> SECOND_SHIFT)) * SECOND_FACTOR
    return mixed ^ (mixed >> LAST_SHIFT)


@compiled
def draw_of_rows(n: int, most: int) -> NDArray[np.int64]:
    """Ascending indices of ``most`` of ``n`` points, n >= most: one of each of as many equal rows."""
    taken, start = np.empty(most, np.int64), 0
    for row in range(most):
        stop = (row + 1) * n // most
        taken[row] = start + np.int64(scrambled(row) % np.uint64(stop - start))
        start = stop
    return taken


@compiled
def draw_of_steps(step: int, first: int, n: int) -> NDArray[np.int64]:
    """Which of ``n`` points stay, ascending from 0, where one of every ``step`` does of a row from ``first`` before on."""
    begin, end = first // step, (first + n - 1) // step + 1
    taken, count = np.empty(end - begin, np.int64), 0
    for group in range(begin, end):
        place = group * step + np.int64(scrambled(group) % np.uint64(step)) - first
        if 0 <= place < n:
            taken[count] = place
            count += 1
    return taken[:count]
