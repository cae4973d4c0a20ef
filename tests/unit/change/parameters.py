"""Parameters of axes with any covariance that one wants."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.axis_parameters import AXIS_NAMES, AxisParameters, radius_names

NAMES = AXIS_NAMES[:6] + radius_names(2)
SIGMAS = np.array([8e-3, 8e-3, 7e-6, 7e-6, 2e-4, 2e-4, 1e-3, 1e-3])


def correlated(seed: int, share: float = 1.0) -> NDArray[np.float64]:
    """A covariance with these sigmas times the root of ``share``, and correlations drawn at random."""
    rng = np.random.default_rng(seed)
    mixed = rng.normal(size=(len(SIGMAS), 2 * len(SIGMAS)))
    covariance = mixed @ mixed.T
    scale = np.sqrt(share / np.diag(covariance)) * SIGMAS
    return np.asarray(covariance * np.outer(scale, scale))


def parameters(
    values: NDArray[np.float64],
    own: NDArray[np.float64],
    form: float = 0.0,
    frame: float = 0.0,
    seed: int = 9,
) -> AxisParameters:
    """Parameters whose covariance is ``own`` and shares of form and frame on top of it."""
    form_part, frame_part = correlated(seed, form) if form else 0.0 * own, correlated(seed + 1, frame)
    frame_part = frame_part if frame else 0.0 * own
    return AxisParameters(NAMES, values, own + form_part + frame_part, form_part, frame_part)
