"""What an axis estimator is."""

from collections.abc import Callable
from dataclasses import dataclass

from tasks.axis.centres import Centres
from tasks.axis.line import Axis
from tasks.geometry.failure import FitFailure


@dataclass(frozen=True, slots=True)
class AxisEstimator:
    """A way from centres to an axis; ``fit`` gets at least two finite centres at different heights."""

    name: str
    description: str
    fit: Callable[[Centres], Axis | FitFailure]
