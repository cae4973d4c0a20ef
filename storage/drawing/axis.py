"""The axis of an epoch as lines: where it stands, where it would stand plumb, and the lean between the two tops."""

from collections.abc import Iterator, Mapping
from math import sqrt
from typing import Final

from storage.drawing.content import DrawingFrame, Feature, Line, Point, Value
from storage.records import TiltRow

OF_THE_LEAN: Final = (
    "lean_east",
    "lean_north",
    "lean_cov_ee",
    "lean_cov_en",
    "lean_cov_nn",
    "tilt_deg",
    "tilt_sigma_deg",
    "azimuth_deg",
    "azimuth_sigma_deg",
    "height_m",
    "deviation_m",
    "deviation_sigma_m",
    "allowable_m",
    "verdict",
    "n_slices",
    "n_centres",
    "axis_model",
    "warning",
)


def axis_features(row: TiltRow, frame: DrawingFrame) -> Iterator[Feature]:
    """Draw an axis from z = 0 of the site frame to the height at which the deviation is stated.

    ``plumb`` is the vertical through its foot; ``lean`` goes from the top of that to the top of the axis. Each carries the
    lean vector with its covariance, the foot the sigma of its place, the top the deviation with its sigma.
    """
    east, north = row.base_east_m, row.base_north_m
    foot = frame.placed(east, north, 0.0)
    plumb = frame.placed(east, north, row.height_m)
    top = frame.placed(
        east + row.height_m * row.lean_east, north + row.height_m * row.lean_north, row.height_m
    )
    known = _attributes(row)
    name = f"{row.scheme}/{row.method}"
    yield Feature("axis", Line(foot, top), known)
    yield Feature("plumb", Line(foot, plumb), known)
    yield Feature("lean", Line(plumb, top), known)
    yield Feature("foot", Point(foot), {**known, "sigma_m": row.base_sigma_m}, f"foot {name}")
    label = f"top {name} {_millimetres(row)} at {row.height_m:g} m"
    yield Feature("top", Point(top), {**known, "sigma_m": row.deviation_sigma_m}, label)


def _attributes(row: TiltRow) -> Mapping[str, Value]:
    named: dict[str, Value] = {"scheme": row.scheme, "method": row.method}
    named |= {name: getattr(row, name) for name in OF_THE_LEAN}
    return {
        **named,
        "lean_sigma_east": _sigma(row.lean_cov_ee),
        "lean_sigma_north": _sigma(row.lean_cov_nn),
    }


def _sigma(variance: float | None) -> float | None:
    return None if variance is None else sqrt(variance)


def _millimetres(row: TiltRow) -> str:
    if row.deviation_sigma_m is None:
        return f"{1000 * row.deviation_m:.1f} mm (uncertainty unknown)"
    return f"{1000 * row.deviation_m:.1f} ± {2000 * row.deviation_sigma_m:.1f} mm (k=2)"
