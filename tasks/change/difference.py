"""The difference of two axes with what both epochs have in common cancelled."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.axis_parameters import AxisParameters, root

FREE = "free"
RADIUS_HELD = "radius held"
SUM_OF_BOTH = "sum of both"

FrameOf = Literal["before", "after"] | None


@dataclass(frozen=True, slots=True, eq=False)
class ParameterChange:
    """Later less earlier parameters (p,) that both epochs have, with the covariance (p, p) of the difference.

    ``basis`` is "free", or "radius held" where the radius profile was taken for the same in both epochs.
    """

    names: tuple[str, ...]
    difference: NDArray[np.float64]
    covariance: NDArray[np.float64]
    basis: str = FREE

    def of(self, prefix: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Difference and covariance of the parameters whose names begin so; empty where there are none."""
        places = [place for place, name in enumerate(self.names) if name.startswith(prefix)]
        return self.difference[places], self.covariance[np.ix_(places, places)]


def parameter_change(
    before: AxisParameters, after: AxisParameters, alike: float, frame_of: FrameOf = None
) -> ParameterChange:
    """Take the difference of two axes.

    Points, levels and positions of two epochs err independently. The form of the wall errs alike as far as both saw the
    same of it. Where stable surroundings tie epochs to the frame of the reference epoch, its errors are in both.

    Parameters
    ----------
    before, after : AxisParameters
        Of the same scheme and method.
    alike : float
        Correlation of what the wall does to the two, 0 to 1 (``likeness``).
    frame_of : "before", "after" or None
        Which of the two is the epoch whose frame the other may be tied to; None where neither is.

    Raises
    ------
    ShapeError
        If ``alike`` is not from 0 to 1.
    """
    if not 0.0 <= alike <= 1.0:
        raise ShapeError(f"parameter_change needs a likeness from 0 to 1, got {alike}")
    names = tuple(name for name in after.names if name in before.names)
    old, new = (one.places(names) for one in (before, after))
    form_1, form_2 = before.form_covariance[np.ix_(old, old)], after.form_covariance[np.ix_(new, new)]
    frame_1, frame_2 = before.frame_covariance[np.ix_(old, old)], after.frame_covariance[np.ix_(new, new)]
    both = before.covariance[np.ix_(old, old)] + after.covariance[np.ix_(new, new)]
    scale = np.sqrt(np.diag(both))
    frame = {"before": frame_2, "after": frame_1}.get(frame_of or "", _shared(frame_1, frame_2, scale))
    common = alike * _shared(form_1, form_2, scale) + frame
    total = both - common - common.T
    return ParameterChange(names, after.values[new] - before.values[old], (total + total.T) / 2.0)


def _shared(
    first: NDArray[np.float64], second: NDArray[np.float64], scale: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Covariance (p, p) of errors that are the same ones in both; units do not matter, because roots are taken of ratios."""
    units = np.outer(scale, scale)
    return np.asarray(root(first / units) @ root(second / units) * units)


def hold_radius(free: ParameterChange) -> ParameterChange:
    """Take the radius profile for the same in both epochs: what an arc cannot tell from a shift is then told apart.

    The differences of the other parameters given that those of the radius are zero, for normal errors.
    """
    radius = [place for place, name in enumerate(free.names) if name.startswith("radius_")]
    axis = [place for place in range(len(free.names)) if place not in radius]
    if not radius:
        return free
    across = free.covariance[np.ix_(axis, radius)]
    gain = np.linalg.solve(free.covariance[np.ix_(radius, radius)], across.T).T
    covariance = free.covariance[np.ix_(axis, axis)] - gain @ across.T
    return ParameterChange(
        tuple(free.names[place] for place in axis),
        free.difference[axis] - gain @ free.difference[radius],
        (covariance + covariance.T) / 2.0,
        RADIUS_HELD,
    )
