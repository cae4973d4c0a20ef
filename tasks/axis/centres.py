"""Centres of slices, as the axis estimators get them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure


@dataclass(frozen=True, slots=True, eq=False)
class Centres:
    """Centres (m, 3) in the site frame, metres, and covariances (m, 2, 2) of (east, north), square metres."""

    points_m: NDArray[np.float64]
    covariances_m2: NDArray[np.float64]

    def __post_init__(self) -> None:
        m = len(self.points_m)
        if self.points_m.shape != (m, 3) or self.covariances_m2.shape != (m, 2, 2):
            raise ShapeError(
                "an axis needs centres (m, 3) and covariances (m, 2, 2); "
                f"got {self.points_m.shape} and {self.covariances_m2.shape}"
            )

    @property
    def count(self) -> int:
        """Number of centres."""
        return len(self.points_m)

    @property
    def lowest_m(self) -> float:
        """Height of the lowest centre, metres."""
        return float(self.points_m[:, 2].min())

    @property
    def span_m(self) -> float:
        """Height of the highest centre above the lowest, metres."""
        return float(np.ptp(self.points_m[:, 2]))

    @property
    def heights(self) -> int:
        """Number of different heights."""
        return len(np.unique(self.points_m[:, 2]))

    def place(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Heights (k,) in the range of the centres, mapped to -1 ... 1."""
        return np.asarray(2.0 * (z_m - self.lowest_m) / self.span_m - 1.0)

    def unfit(self) -> FitFailure | None:
        """Say why no axis can be fitted, or None if one can be tried."""
        if self.count < 2:
            return FitFailure(f"needs at least 2 centres, got {self.count}")
        bad = int((~np.isfinite(self.points_m).all(axis=1)).sum())
        if bad:
            return FitFailure(f"needs finite centres, got {bad} of {self.count} that are not")
        if not self._covariances_valid():
            return FitFailure("needs a finite covariance without negative variances at every centre")
        resolution = 8 * np.finfo(float).eps * float(np.abs(self.points_m).max())
        if self.span_m <= resolution:
            return FitFailure(f"needs centres at different heights, got {self.count} at one height")
        return None

    def _covariances_valid(self) -> bool:
        if not np.isfinite(self.covariances_m2).all():
            return False
        smallest, largest = np.linalg.eigvalsh(self.covariances_m2).T
        return bool((smallest >= -1e-9 * np.abs(largest)).all())
