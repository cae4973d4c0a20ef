"""How the structure moves from epoch to epoch."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tasks.conventions import ARCSEC_RAD
from tasks.simulation.shape import Horizontal, ShaftShape


@dataclass(frozen=True, slots=True)
class Movement:
    """What is added to the first epoch's shape, all towards one azimuth.

    ``lean_arcsec`` and ``bend_top_m`` hold one amount an epoch, counted from the first shape (not from the epoch
    before). Beyond their end the last step goes on; an empty one means no movement.
    The default moves the line at 102 m by 0, 4.0, 7.9 and 19.8 mm.
    """

    azimuth_deg: float = 160.0
    lean_arcsec: tuple[float, ...] = (0.0, 8.0, 16.0, 40.0)
    bend_top_m: tuple[float, ...] = ()

    def shape_at(self, first: ShaftShape, epoch_index: int) -> ShaftShape:
        """Shape of the shaft in epoch ``epoch_index``, 0 for the first."""
        lean = ARCSEC_RAD * _amount_at(self.lean_arcsec, epoch_index)
        bend_m = _amount_at(self.bend_top_m, epoch_index)
        return replace(
            first, lean=self._added(first.lean, lean), bend_top_m=self._added(first.bend_top_m, bend_m)
        )

    def _added(self, vector: Horizontal, amount: float) -> Horizontal:
        azimuth_rad = np.radians(self.azimuth_deg)
        return Horizontal(
            float(vector.east + amount * np.sin(azimuth_rad)),
            float(vector.north + amount * np.cos(azimuth_rad)),
        )


def _amount_at(amounts: Sequence[float], index: int) -> float:
    if not amounts:
        return 0.0
    beyond = max(0, index - (len(amounts) - 1))
    step = amounts[-1] - amounts[-2] if len(amounts) > 1 else 0.0
    return amounts[min(index, len(amounts) - 1)] + beyond * step
