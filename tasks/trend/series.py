"""The lean of a structure at its epochs, as movements with covariances."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError


def _nothing_common() -> NDArray[np.float64]:
    return np.zeros((2, 2))


@dataclass(frozen=True, slots=True)
class LeanSeries:
    """Movements of the axis at one height over the epochs of a structure.

    A movement is the lean vector times the height: how far the axis is off the vertical there, east and north. It is an
    absolute deviation; the rate of change is its slope over time. The epochs are taken as independent of each other but
    for ``common``.

    Parameters
    ----------
    times : (n,) array
        Years from any origin, ascending; equal times are allowed.
    movements : (n, 2) array
        East and north, metres.
    covariances : (n, 2, 2) array
        Of each epoch, positive definite, without ``common``, square metres.
    temperatures : (n,) array or None
        Of the structure at each epoch, degrees Celsius.
    common : (2, 2) array
        Covariance of the error that all epochs share (form of the wall, datum). It cancels in rates and steps, and
        enters the deviation.

    Raises
    ------
    ShapeError
        If shapes disagree, a value is not finite, times descend or a covariance is not positive definite.
    """

    times: NDArray[np.float64]
    movements: NDArray[np.float64]
    covariances: NDArray[np.float64]
    temperatures: NDArray[np.float64] | None = None
    common: NDArray[np.float64] = field(default_factory=_nothing_common)

    def __post_init__(self) -> None:
        """Refuse what no model can be laid through."""
        n = len(self.times)
        shapes = (self.times.shape, self.movements.shape, self.covariances.shape, self.common.shape)
        if n < 1 or shapes != ((n,), (n, 2), (n, 2, 2), (2, 2)):
            raise ShapeError(
                f"LeanSeries needs (n,), (n, 2), (n, 2, 2), (2, 2) with n >= 1; got {', '.join(map(str, shapes))}"
            )
        if self.temperatures is not None and self.temperatures.shape != (n,):
            raise ShapeError(f"LeanSeries needs {n} temperatures; got {self.temperatures.shape}")
        given = [self.times, self.movements, self.covariances, self.common]
        given += [] if self.temperatures is None else [self.temperatures]
        if not all(np.isfinite(values).all() for values in given):
            raise ShapeError("LeanSeries needs finite values; got NaN or infinity")
        if (np.diff(self.times) < 0.0).any():
            raise ShapeError(f"LeanSeries needs times that ascend; got {self.times.tolist()}")
        if (np.linalg.eigvalsh(self.covariances)[:, 0] <= 0.0).any():
            raise ShapeError("LeanSeries needs covariances that are positive definite")

    @property
    def n_epochs(self) -> int:
        """How many epochs there are."""
        return len(self.times)

    @property
    def n_times(self) -> int:
        """How many of them lie at different times: what terms can be told apart by."""
        return len(np.unique(self.times))

    @property
    def span(self) -> float:
        """Years from the first epoch to the last."""
        return float(self.times[-1] - self.times[0])
