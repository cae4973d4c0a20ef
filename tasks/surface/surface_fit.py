"""What a whole-surface fit gives, and what it is asked with."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit
from tasks.geometry.axis_parameters import JointParts
from tasks.geometry.failure import FitFailure
from tasks.surface.cells import SurfacePoints
from tasks.surface.fit import SurfaceStart
from tasks.surface.poses import StationPoses

Sections = Literal["horizontal", "perpendicular"]
"""Which cut of the shaft is round."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceRequest:
    """A cloud to fit.

    ``poses`` are the stations with the covariance of their poses, or None where they are not known.
    """

    cloud: SurfacePoints
    start: SurfaceStart
    sections: Sections
    poses: StationPoses | None


@dataclass(frozen=True, slots=True, eq=False)
class AxisForm:
    """The form of the axis, bending and all.

    ``z_m`` (k,), ``east_m``, ``north_m`` (k,) are the curve in the site frame, ``base_lean`` (2,) the lean of its tangent at
    the foot with the sigma of one component, ``chord_lean`` (2,) that of the line from foot to top.
    """

    model: str
    reason: str
    z_m: NDArray[np.float64]
    east_m: NDArray[np.float64]
    north_m: NDArray[np.float64]
    base_lean: NDArray[np.float64]
    base_lean_sigma: float
    chord_lean: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceFit:
    """A surface that was fitted.

    Attributes
    ----------
    lean : (2,) array
        Lean vector of the line that fits the axis best, uniformly over the shaft.
    point_m : (3,) array
        That line at half height, site frame, metres.
    point_covariance, form_covariance : (2, 2) arrays
        Covariance of the lean vector from the noise of the points, and from the form of the wall: what the surface does
        not follow, and what the arc that was seen cannot tell.
    bootstrap_covariance : (2, 2) array or None
        Both again, by a bootstrap of pieces of the wall; without what the arc cannot tell.
    station_changes : (s, 2) array or None
        Change of the lean with each station that saw the shaft left out.
    pose_jacobian : (2, 6 s) array or None
        Change of the lean with the poses of the stations.
    bands : tuple of SectionFit
        The surface band by band.
    curve : AxisForm
        Bending.
    section_reason : str
        Why sections are taken for round or not.
    common_sigma_m : float
        What the points of a piece of the wall have in common, metres.
    n_used : int
        Points with a weight above zero.
    coverage_deg : float
        Circumference with points, mean over the height, degrees.
    passes : int
        Looks at all points.
    parameter_names : tuple of str
        Parameters of axis and radius (``tasks.geometry.axis_parameters``).
    parameter_values : (p,) array
        Their values, site frame.
    joint : JointParts
        Their joint covariance.
    """

    lean: NDArray[np.float64]
    point_m: NDArray[np.float64]
    point_covariance: NDArray[np.float64]
    form_covariance: NDArray[np.float64]
    bootstrap_covariance: NDArray[np.float64] | None
    station_changes: NDArray[np.float64] | None
    pose_jacobian: NDArray[np.float64] | None
    bands: tuple[SectionFit, ...]
    curve: AxisForm
    section_reason: str
    common_sigma_m: float
    n_used: int
    coverage_deg: float
    passes: int
    parameter_names: tuple[str, ...]
    parameter_values: NDArray[np.float64]
    joint: JointParts


@dataclass(frozen=True, slots=True)
class SurfaceModel:
    """A model of the whole surface of a shaft."""

    name: str
    description: str
    fit: Callable[[SurfaceRequest], SurfaceFit | FitFailure]
