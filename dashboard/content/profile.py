"""The axis from foot to top, along the lean and across it, with residuals and bending."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from dashboard.content.direction import Direction
from storage.records import AxisParameterRow, CoverageRow, SliceRow, TiltRow

SURFACE: Final = "surface"
"""Method of the scheme that fits the whole surface."""


@dataclass(frozen=True, slots=True)
class Profile:
    """Centres of slices against the plumb line through the foot of the axis, and against the straight axis.

    Of n slices that gave a centre, the lowest first. Columns of (n, 2) arrays are along and across, metres.
    ``residuals_m`` is NaN where a slice has no offset; ``sigmas_m`` where its covariance is unknown.
    ``curve_m`` is the bent axis at ``line_z_m`` where the epoch has one, ``line_m`` the straight one.
    """

    direction: Direction
    index: NDArray[np.int64]
    z_m: NDArray[np.float64]
    centres_m: NDArray[np.float64]
    sigmas_m: NDArray[np.float64]
    residuals_m: NDArray[np.float64]
    weights: NDArray[np.float64]
    line_z_m: NDArray[np.float64]
    line_m: NDArray[np.float64]
    curve_m: NDArray[np.float64] | None


def profile_of(
    tilt: TiltRow,
    slices: Sequence[SliceRow],
    parameters: Sequence[AxisParameterRow],
    direction: Direction,
    shaft_z_m: tuple[float, float] | None,
) -> Profile:
    """Lay the centres of an axis beside its plumb line.

    Parameters
    ----------
    tilt : TiltRow
        The axis.
    slices : sequence of SliceRow
        Its slices; those without a centre are left out.
    parameters : sequence of AxisParameterRow
        Its parameters; bends are taken from them, and a straight axis has none.
    direction : Direction
        What along means: that of the reference epoch, to lay two epochs over each other.
    shaft_z_m : (float, float) or None
        Part of the shaft that a whole surface was fitted to, over which its bends are stated; None of a scheme with
        slices, whose bends are over the heights of its centres. A surface without it is drawn straight.
    """
    kept = sorted((row for row in slices if row.center_east_m is not None), key=lambda row: row.z_m)
    z_m = np.array([row.z_m for row in kept])
    foot = np.array([tilt.base_east_m, tilt.base_north_m])
    centres = np.array([[row.center_east_m, row.center_north_m] for row in kept], dtype=float).reshape(-1, 2)
    offsets = np.array([[row.offset_east_m, row.offset_north_m] for row in kept], dtype=float).reshape(-1, 2)
    covariances = np.array(
        [[[r.center_cov_ee, r.center_cov_en], [r.center_cov_en, r.center_cov_nn]] for r in kept], dtype=float
    ).reshape(-1, 2, 2)
    turned = direction.turn_covariance(covariances)
    top = tilt.height_m if len(z_m) == 0 else max(tilt.height_m, float(z_m[-1]))
    line_z = np.linspace(0.0, top, 103)
    line = line_z[:, None] * np.array([tilt.lean_east, tilt.lean_north])
    bend = _bend(parameters, _span(tilt, z_m, shaft_z_m), line_z)
    return Profile(
        direction=direction,
        index=np.array([row.slice_index for row in kept], dtype=np.int64),
        z_m=z_m,
        centres_m=direction.turn(centres - foot),
        sigmas_m=np.sqrt(np.diagonal(turned, axis1=1, axis2=2)),
        residuals_m=direction.turn(offsets),
        weights=np.array([np.nan if row.weight is None else row.weight for row in kept]),
        line_z_m=line_z,
        line_m=direction.turn(line),
        curve_m=None if bend is None else direction.turn(line + bend),
    )


def _span(
    tilt: TiltRow, z_m: NDArray[np.float64], shaft_z_m: tuple[float, float] | None
) -> tuple[float, float] | None:
    """The heights between which the bends of an axis are stated."""
    if tilt.method == SURFACE:
        return shaft_z_m
    return None if len(z_m) < 3 else (float(z_m[0]), float(z_m[-1]))


def _bend(
    parameters: Sequence[AxisParameterRow], span: tuple[float, float] | None, line_z_m: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """The bent axis minus the straight one at the heights of the line; NaN beyond the span."""
    values = {row.parameter: row.value for row in parameters}
    if span is None or "bend_east" not in values or "bend_north" not in values:
        return None
    low, high = span
    place = (2.0 * line_z_m - low - high) / (high - low)
    second, third = 0.5 * (3.0 * place**2 - 1.0), 0.5 * (5.0 * place**3 - 3.0 * place)
    bend = np.column_stack(
        [
            values[f"bend_{side}"] * second + values.get(f"s_bend_{side}", 0.0) * third
            for side in ("east", "north")
        ]
    )
    bend[np.abs(place) > 1.0] = np.nan
    return bend


def shaft_of(coverage: Sequence[CoverageRow]) -> tuple[float, float] | None:
    """The part of the shaft that was looked at, from the height bands of its coverage; None without any."""
    if not coverage:
        return None
    return min(row.z_low_m for row in coverage), max(row.z_high_m for row in coverage)
