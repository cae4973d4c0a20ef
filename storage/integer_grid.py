"""Coordinates that a file holds as integers, and how metres are made of them: half the bytes of float64, the same bits."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

Triple = tuple[float, float, float]

BLOCK: Final = 1 << 13
"""Points, made at a time: they stay in the cache of a core."""


@dataclass(frozen=True, slots=True)
class IntegerGrid:
    """How integers become metres: ``(integer * scale + shift) * unit_m - origin_m``, then the axes.

    ``scale`` and ``shift`` are those of a LAS header, in the unit of the file and the order of its axes; ``unit_m`` is the
    length of that unit; ``origin_m`` is in the axes of the file, too; ``swap_axes`` turns north, east, up into east, north,
    up at last. Every step is one operation in float64, in this order, so that metres are the same bits wherever they are
    made.
    """

    scale: Triple
    shift: Triple
    unit_m: float = 1.0
    origin_m: Triple = (0.0, 0.0, 0.0)
    swap_axes: bool = False

    def metres(
        self, integers: NDArray[np.int32], out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """Make points (n, 3), metres, of integers (n, 3), in the array ``out`` (n, 3) if one is given.

        Raises
        ------
        ShapeError
            If the integers are not (n, 3), or ``out`` has another shape.
        """
        points_m = np.empty(integers.shape) if out is None else out
        if integers.ndim != 2 or integers.shape[1] != 3 or points_m.shape != integers.shape:
            raise ShapeError(f"needs integers and points (n, 3); got {integers.shape} and {points_m.shape}")
        for start in range(0, len(integers), BLOCK):
            self._block(integers[start : start + BLOCK], points_m[start : start + BLOCK])
        return points_m

    def _block(self, integers: NDArray[np.int32], points_m: NDArray[np.float64]) -> None:
        order = (1, 0, 2) if self.swap_axes else (0, 1, 2)
        for place, axis in enumerate(order):
            column = points_m[:, place]
            np.multiply(integers[:, axis], self.scale[axis], out=column)
            column += self.shift[axis]
            if self.unit_m != 1.0:
                column *= self.unit_m
            if any(self.origin_m):
                column -= self.origin_m[axis]
