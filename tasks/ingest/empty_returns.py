"""Records at (0, 0, 0) among integers on a grid: beams without a return."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.integer_grid import IntegerGrid
from tasks.ingest.scan import Bounds

ALL_INTEGERS: Final = range(-(2**31), 2**31)


@dataclass(frozen=True, slots=True)
class ZeroCell:
    """The integers of which a grid makes exactly 0.0: from ``low`` to ``high``, (3,) each; none where high < low."""

    low: tuple[int, ...]
    high: tuple[int, ...]

    def without(self, integers: NDArray[np.int32], box: Bounds) -> NDArray[np.int32]:
        """Take records that are zero in all three out of ``integers`` (m, 3), whose box in integers is known."""
        if any(box.high < self.low) or any(box.low > self.high):
            return integers
        is_empty = np.ones(len(integers), dtype=bool)
        for axis, (low, high) in enumerate(zip(self.low, self.high, strict=True)):
            is_empty &= integers[:, axis] >= low
            is_empty &= integers[:, axis] <= high
            if not is_empty.any():
                return integers
        return integers[~is_empty]


def zero_cell(grid: IntegerGrid) -> ZeroCell:
    """Find the integers that are zero, in the unit of the file: scaling is monotone, so they lie side by side."""
    spans = [_span(scale, shift) for scale, shift in zip(grid.scale, grid.shift, strict=True)]
    return ZeroCell(tuple(span[0] for span in spans), tuple(span[1] for span in spans))


def _span(scale: float, shift: float) -> tuple[int, int]:
    first = bisect_left(ALL_INTEGERS, 0.0, key=lambda integer: integer * scale + shift)
    last = bisect_right(ALL_INTEGERS, 0.0, key=lambda integer: integer * scale + shift)
    return first + ALL_INTEGERS.start, last - 1 + ALL_INTEGERS.start
