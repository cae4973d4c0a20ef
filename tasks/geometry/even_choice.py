"""One of every so many, in the same places on every machine but in no pattern.

Which one stays is drawn by a hash of the number of its group: a fixed place would follow the scan lines, of which a sample
of every tenth point may hold the same tenth only.
"""

import numpy as np
from numpy.typing import NDArray


def even_sample(n: int, most: int) -> NDArray[np.int64]:
    """Ascending indices of ``most`` of ``n`` points: one of each of as many equal rows; all where there are no more."""
    from tasks.geometry.choice_kernel import draw_of_rows  # noqa: PLC0415 (slow to import)

    return np.arange(n) if n <= most else draw_of_rows(n, most)


def one_of_every(step: int, first: int, n: int) -> NDArray[np.int64]:
    """Which of ``n`` things in a row stay, ascending from 0, where one of every ``step`` of the whole row does.

    ``first`` is how many of the row came before; so a row may come in parts of any length.
    """
    from tasks.geometry.choice_kernel import draw_of_steps  # noqa: PLC0415 (slow to import)

    return np.arange(n) if step <= 1 else draw_of_steps(step, first, n)
