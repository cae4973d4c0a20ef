"""A slice as one looks at it: what its points show, beside what was fitted to them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from dashboard.content.harmonics import Harmonic, harmonics_of, middle_of
from dashboard.content.ring import Polar, Ring, SeenFrom, polar_of, ring_of, sector_width_deg
from storage.records import SliceRow, TiltRow
from storage.views.shaft_points import ShaftPoints

ROSE_DEG: Final = 10.0
"""Width of the sectors that out-of-roundness is told for."""

MOST_SHOWN: Final = 3000
"""Points that are drawn one by one."""

FLAT: Final = ("polygon", "faces")
"""Contours that are no curve: a circle says nothing of them."""

EXAGGERATIONS: Final = (1, 10, 50, 100, 200)
"""How many times larger than the radius deviations may be drawn."""

NEIGHBOURS: Final = 2
"""Slices above and below that tell how the radius changes with height."""


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """A slice seen from its centre.

    Attributes
    ----------
    row : SliceRow
        What was fitted.
    centre_m : (2,) array
        East and north that everything is seen from: the fitted centre, else the axis at this height.
    has_centre : bool
        Whether it is the fitted one.
    contour : Ring
        In sectors as fine as the points allow.
    rose : Ring
        In sectors of ``ROSE_DEG``.
    harmonics : tuple of Harmonic
        Waves of the contour about its own middle; of flat faces none.
    points : Polar
        An even sample of the points.
    axis_m : (2,) array or None
        East and north of the straight axis minus the centre; None without an axis.
    """

    row: SliceRow
    centre_m: NDArray[np.float64]
    has_centre: bool
    contour: Ring
    rose: Ring
    harmonics: tuple[Harmonic, ...]
    points: Polar
    axis_m: NDArray[np.float64] | None

    @property
    def is_flat(self) -> bool:
        """Whether the wall is made of flat faces."""
        return self.row.contour in FLAT


@dataclass(frozen=True, slots=True)
class NoSection:
    """Why a slice cannot be shown."""

    reason: str


def section_of(
    row: SliceRow, slices: Sequence[SliceRow], points: ShaftPoints, tilt: TiltRow | None
) -> Section | NoSection:
    """Look at a slice.

    Parameters
    ----------
    row : SliceRow
        The slice; one that failed is seen from the axis.
    slices : sequence of SliceRow
        All slices of its scheme and method, from the bottom.
    points : ShaftPoints
        All points of the shaft.
    tilt : TiltRow or None
        The axis of the same scheme and method.
    """
    own = points.of_slice(row.z_m, row.thickness_m)
    axis_m = None if tilt is None else _axis_at(tilt, row.z_m)
    centre_m = _centre_of(row)
    seen_from = axis_m if centre_m is None else centre_m
    if len(own) == 0:
        return NoSection(f"no point of the shaft lies between the ends of this slice at {row.z_m:.2f} m")
    if seen_from is None:
        return NoSection(f"the slice has no centre ({row.reason}), and there is no axis to see it from")
    lean = np.zeros(2) if tilt is None else np.array([tilt.lean_east, tilt.lean_north])
    seen = SeenFrom(seen_from, row.z_m, lean, taper_at(row, slices))
    polar = polar_of(own.points_m, seen)
    contour = ring_of(polar, row.radius_m, sector_width_deg(len(own)))
    return Section(
        row=row,
        centre_m=seen_from,
        has_centre=centre_m is not None,
        contour=contour,
        rose=ring_of(polar, contour.radius_m, ROSE_DEG),
        harmonics=() if row.contour in FLAT else _waves(own, seen, contour),
        points=polar.thinned(MOST_SHOWN),
        axis_m=None if axis_m is None else axis_m - seen_from,
    )


def _waves(points: ShaftPoints, seen: SeenFrom, contour: Ring) -> tuple[Harmonic, ...]:
    """Waves about the middle of the contour itself: seen from a centre that is far off, a circle looks oval."""
    middle = replace(seen, centre_m=seen.centre_m + middle_of(contour))
    return harmonics_of(ring_of(polar_of(points.points_m, middle), None, contour.sector_deg))


def taper_at(row: SliceRow, slices: Sequence[SliceRow]) -> float:
    """Change of the radius per metre of height about a slice; the middle one of those between its neighbours.

    A step in the wall is then none of it. Where there are no two slices with a radius the wall is taken as upright.
    """
    known = [(s.z_m, s.radius_m, s.slice_index) for s in slices if s.radius_m is not None]
    rates = [
        (above - below) / (high - low)
        for (low, below, first), (high, above, last) in pairwise(known)
        if high > low and last > row.slice_index - NEIGHBOURS - 1 and first < row.slice_index + NEIGHBOURS + 1
    ]
    return float(np.median(rates)) if rates else 0.0


def exaggeration_for(section: Section) -> int:
    """The largest of ``EXAGGERATIONS`` that leaves 19 of 20 sectors within a fifth of the radius from the circle."""
    if section.is_flat:
        return EXAGGERATIONS[0]
    usual_m = float(np.nanquantile(np.abs(section.contour.deviation_m), 0.95))
    fitting = [times for times in EXAGGERATIONS if times * usual_m <= 0.2 * section.contour.radius_m]
    return fitting[-1] if fitting else EXAGGERATIONS[0]


def _centre_of(row: SliceRow) -> NDArray[np.float64] | None:
    if row.center_east_m is None or row.center_north_m is None:
        return None
    return np.array([row.center_east_m, row.center_north_m])


def _axis_at(tilt: TiltRow, z_m: float) -> NDArray[np.float64]:
    return np.array([tilt.base_east_m + z_m * tilt.lean_east, tilt.base_north_m + z_m * tilt.lean_north])
