"""How two axes are to be compared: with what cancelled, at which heights, the radius held or free, and what to mind."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from storage.records import SliceRow, TiltRow
from tasks.change import (
    FrameOf,
    ParameterChange,
    SliceAxis,
    at_common_heights,
    chi_square_test,
    hold_radius,
    parameter_change,
    same_heights,
)
from tasks.geometry.axis_parameters import AxisParameters

LEAST_STATIONS: Final = 5
"""With fewer the scans cannot contradict a stated level: the jackknife needs them."""

LEAST_ALIKE: Final = 0.9
"""Slices that saw other sides of the wall than this are fitted to another form."""

ENDS_M: Final = 0.5
"""Ends of the cut part that differ by more are those of another part."""


@dataclass(frozen=True, slots=True, eq=False)
class AxisRecord:
    """An axis of an epoch: its row, its parameters where the method states them, and its slices."""

    tilt: TiltRow
    parameters: AxisParameters | None
    slices: Sequence[SliceRow]


@dataclass(frozen=True, slots=True)
class Kinship:
    """What two epochs have in common.

    ``alike`` is the correlation of what the wall does to their leans, ``frame_of`` which of them is the one whose frame the
    other may be tied to, ``partial`` whether one of them saw an arc only, ``fewest_stations`` those of the epoch with fewer.
    """

    alike: float
    frame_of: FrameOf
    partial: bool
    fewest_stations: int


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """The change to be tested, and what to mind about it; ``ends_m`` are the ends of the part that was measured."""

    change: ParameterChange
    free: ParameterChange
    ends_m: tuple[float, float]
    reasons: tuple[str, ...]


def basis_of(before: AxisRecord, after: AxisRecord, kinship: Kinship) -> Basis | str:
    """Take the difference of two axes with parameters; or say why they cannot be compared."""
    if before.parameters is None or after.parameters is None:
        return "the method states no joint parameters"
    first, second = _slice_axis(before.slices), _slice_axis(after.slices)
    moved_ends = max(abs(a - b) for a, b in zip(first.ends_m, second.ends_m, strict=True))
    if moved_ends > ENDS_M:
        return (
            f"another part of the shaft was measured: {first.ends_m[0]:.1f} m to {first.ends_m[1]:.1f} m, then"
            f" {second.ends_m[0]:.1f} m to {second.ends_m[1]:.1f} m; run all epochs with one shaft_z_m"
        )
    free = parameter_change(before.parameters, after.parameters, kinship.alike, kinship.frame_of)
    reasons = []
    if after.tilt.method != "surface" and not same_heights(first, second):
        found = at_common_heights(free, first, second)
        if found is None:
            return "the axes of the epochs rest on fewer than 4 centres at the same heights"
        free = found
        reasons.append("counted from the heights that both epochs have")
    change, held = _hold(free, kinship)
    if held:
        reasons.append(held)
    return Basis(change, free, second.ends_m, (*reasons, *_warnings(after.tilt.method, kinship)))


def _hold(free: ParameterChange, kinship: Kinship) -> tuple[ParameterChange, str | None]:
    """Hold the radius where an arc could not tell it from a shift; a radius that seems to have changed is told."""
    if not kinship.partial:
        return free, None
    d, covariance = free.of("radius_")
    test = chi_square_test(d, covariance) if len(d) else None
    if test is None:
        return free, "only an arc was seen, and the method states no radius to hold"
    said = "only an arc was seen, so the radius profile was taken for unchanged"
    if test.significant:
        said += f", although it seems to have changed (p = {test.p_value:.2g})"
    return hold_radius(free), said


def _warnings(method: str, kinship: Kinship) -> list[str]:
    said = []
    if method != "surface" and kinship.alike < LEAST_ALIKE:
        said.append(
            "the epochs saw other sides of the wall, whose form does not cancel between slices: mind scheme S"
        )
    if kinship.fewest_stations < LEAST_STATIONS:
        said.append(f"{kinship.fewest_stations} stations cannot check their stated levels")
    return said


def _slice_axis(slices: Sequence[SliceRow]) -> SliceAxis:
    good = [row for row in slices if row.state == "ok" and row.radius_m is not None]
    low = min(row.z_m - row.thickness_m / 2.0 for row in slices)
    high = max(row.z_m + row.thickness_m / 2.0 for row in slices)
    return SliceAxis(
        z_m=np.array([row.z_m for row in good]),
        east_north_radius_m=np.array(
            [[row.center_east_m, row.center_north_m, row.radius_m] for row in good], dtype=np.float64
        ).reshape(-1, 3),
        variance_m2=np.array([row.sigma_center_m or 0.0 for row in good]) ** 2,
        weight=np.array([1.0 if row.weight is None else row.weight for row in good]),
        ends_m=(low, high),
    )
