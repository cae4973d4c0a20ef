"""Which rows of a cloud lie between two heights."""

import numpy as np
from numpy.typing import NDArray


def rows_between(z_m: NDArray[np.float64], low_m: float, high_m: float) -> slice | NDArray[np.intp]:
    """Rows with heights (n,) from low to high, both included.

    A slice where they follow each other, as in a cloud that comes from the bottom up: what it takes is no copy.
    """
    inside = (z_m >= low_m) & (z_m <= high_m)
    count = int(np.count_nonzero(inside))
    if not count:
        return slice(0, 0)
    first, last = int(np.argmax(inside)), len(inside) - int(np.argmax(inside[::-1]))
    return slice(first, last) if count == last - first else np.flatnonzero(inside)
