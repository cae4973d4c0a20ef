"""The shaft as a formula: its axis, its radius, and the line that is the truth of its lean."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

BendForm = Literal["parabola", "cantilever", "sweep"]
SectionPlane = Literal["horizontal", "perpendicular"]

_QUADRATURE_NODES: Final = 8
"""Gauss-Legendre nodes: exact up to degree 15, the bending lines have degree 4."""

_Profile = Callable[[NDArray[np.float64]], NDArray[np.float64]]

_BEND_SHARES: Final[dict[BendForm, _Profile]] = {
    "parabola": lambda s: s**2,
    "cantilever": lambda s: (6.0 * s**2 - 4.0 * s**3 + s**4) / 3.0,
    "sweep": lambda s: 3.0 * s**2 - 2.0 * s**3,
}
"""Part of the top's bending that a share of the height has; the second dictionary has their derivatives."""

_BEND_SLOPES: Final[dict[BendForm, _Profile]] = {
    "parabola": lambda s: 2.0 * s,
    "cantilever": lambda s: 4.0 * s - 4.0 * s**2 + 4.0 / 3.0 * s**3,
    "sweep": lambda s: 6.0 * s - 6.0 * s**2,
}


@dataclass(frozen=True, slots=True)
class Horizontal:
    """A horizontal vector of the site frame; its unit is in the name of what holds it."""

    east: float = 0.0
    north: float = 0.0

    def as_array(self) -> NDArray[np.float64]:
        """(2,) array: east, north."""
        return np.array([self.east, self.north])


@dataclass(frozen=True, slots=True)
class ShaftShape:
    """A tapered shaft that leans and may be bent and oval; site frame, z = 0 at its foot.

    ``lean`` (dimensionless) is the slope of the unbent axis. ``bend_top_m`` is how far bending moves the top:
    ``parabola`` grows as z squared (heat on one side), ``cantilever`` is the line of a uniform load (wind), ``sweep``
    that of a tree: bent in the middle, upright at both ends.
    ``taper_bow_m`` is the sagitta of the outline against a straight taper, positive outward. ``ovality`` is the
    relative amplitude of the second harmonic of the radius, largest towards ``ovality_azimuth_deg``.
    ``sections`` says which cut is round. With ``horizontal`` the centre of every level section is the axis itself;
    with ``perpendicular``, as of a shaft that was built plumb and then leaned as a body, the level section's centre
    is off by about R * taper * lean (0.8 mm for the default): the slope of the centres is larger by 1 + taper**2.
    """

    height_m: float = 110.0
    radius_foot_m: float = 4.6
    radius_top_m: float = 2.7
    taper_bow_m: float = 0.0
    base_m: Horizontal = field(default_factory=Horizontal)
    lean: Horizontal = field(default_factory=lambda: Horizontal(0.00725, -0.00695))
    bend_top_m: Horizontal = field(default_factory=Horizontal)
    bend_form: BendForm = "parabola"
    ovality: float = 0.0
    ovality_azimuth_deg: float = 40.0
    sections: SectionPlane = "horizontal"

    def __post_init__(self) -> None:
        if min(self.height_m, self.radius_foot_m, self.radius_top_m) <= 0.0:
            raise ShapeError(
                "a shaft needs a positive height and positive radii; "
                f"got {self.height_m}, {self.radius_foot_m} and {self.radius_top_m} m"
            )
        if self.bend_form not in get_args(BendForm) or self.sections not in get_args(SectionPlane):
            raise ShapeError(
                f"unknown bend form {self.bend_form!r} or section plane {self.sections!r}; "
                f"known: {', '.join(get_args(BendForm))}; {', '.join(get_args(SectionPlane))}"
            )

    def axis_at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """East and north (..., 2) of the axis at heights (...), metres."""
        straight = self.base_m.as_array() + z_m[..., None] * self.lean.as_array()
        return straight + self._bend_share(z_m / self.height_m)[..., None] * self.bend_top_m.as_array()

    def slope_at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Slope (..., 2) of the axis at heights (...): d(east, north)/dz."""
        s = z_m / self.height_m
        share = _BEND_SLOPES[self.bend_form](s)
        return self.lean.as_array() + (share / self.height_m)[..., None] * self.bend_top_m.as_array()

    def radius_at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean radius (...) at heights (...), metres."""
        s = z_m / self.height_m
        straight = self.radius_foot_m + (self.radius_top_m - self.radius_foot_m) * s
        return np.asarray(straight + 4.0 * self.taper_bow_m * s * (1.0 - s))

    def roundness_at(self, azimuth_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Radius over mean radius (...) towards azimuths (...)."""
        return np.asarray(
            1.0 + self.ovality * np.cos(2.0 * (azimuth_rad - np.radians(self.ovality_azimuth_deg)))
        )

    def _bend_share(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(_BEND_SHARES[self.bend_form](s))


@dataclass(frozen=True, slots=True)
class AxisTruth:
    """The straight line that fits the true axis best, uniformly over a range of heights.

    ``lean`` is its lean vector, ``base_m`` its place at z = 0, ``bending_m`` the largest horizontal distance of
    the true axis from it within that range.
    """

    lean: Horizontal
    base_m: Horizontal
    bending_m: float

    @property
    def tilt_rad(self) -> float:
        """Angle between the line and the plumb line."""
        return float(np.arctan(np.hypot(self.lean.east, self.lean.north)))


def axis_truth(shape: ShaftShape, z_lo_m: float, z_hi_m: float) -> AxisTruth:
    """Fit a straight line to the true axis by least squares, uniformly from ``z_lo_m`` to ``z_hi_m``.

    Raises
    ------
    ShapeError
        If the range of heights is empty.
    """
    if not z_lo_m < z_hi_m:
        raise ShapeError(f"axis_truth needs z_lo_m < z_hi_m; got {z_lo_m} and {z_hi_m}")
    nodes, weights = np.polynomial.legendre.leggauss(_QUADRATURE_NODES)
    middle_m, half_m = 0.5 * (z_lo_m + z_hi_m), 0.5 * (z_hi_m - z_lo_m)
    axis_m = shape.axis_at(middle_m + half_m * nodes)
    # on [-1, 1] the weights sum to 2 and the second moment is 2/3
    slope = 1.5 * (weights * nodes) @ axis_m / half_m
    base_m = 0.5 * weights @ axis_m - slope * middle_m
    z_m = np.linspace(z_lo_m, z_hi_m, 1001)
    off_m = shape.axis_at(z_m) - base_m - z_m[:, None] * slope
    return AxisTruth(
        Horizontal(*slope.tolist()), Horizontal(*base_m.tolist()), float(np.hypot(*off_m.T).max())
    )
