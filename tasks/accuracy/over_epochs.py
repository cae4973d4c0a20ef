"""Whether two schemes agree epoch after epoch."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from storage.errors import ShapeError
from tasks.accuracy.significance import LeanDifference


@dataclass(frozen=True, slots=True)
class Agreement:
    """Differences of two schemes over several epochs, of one component each, dimensionless.

    ``scatter`` is their standard deviation about their own mean, ``sigma`` the root mean square of the stated ones,
    None where an epoch states none.
    """

    n_epochs: int
    mean_east: float
    mean_north: float
    scatter: float
    sigma: float | None


def agreement(differences: Sequence[LeanDifference]) -> Agreement:
    """Mean and scatter of the differences of two schemes over at least two epochs.

    A mean that does not vanish is a bias that movements between epochs do not see; the scatter is what they see.

    Raises
    ------
    ShapeError
        If there are fewer than two.
    """
    n = len(differences)
    if n < 2:
        raise ShapeError(f"agreement needs the differences of at least 2 epochs; got {n}")
    all_d = np.array([one.difference for one in differences])
    mean = all_d.mean(axis=0)
    traces = [None if one.covariance is None else float(np.trace(one.covariance)) for one in differences]
    known = [trace for trace in traces if trace is not None]
    return Agreement(
        n_epochs=n,
        mean_east=float(mean[0]),
        mean_north=float(mean[1]),
        scatter=float(np.sqrt(np.sum((all_d - mean) ** 2) / (2 * (n - 1)))),
        sigma=float(np.sqrt(np.mean(known) / 2.0)) if len(known) == n else None,
    )
