"""What a slicing scheme is, and how a user states one."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Final

from storage.errors import InputError, ShapeError

THICKNESS_M: Final = 0.01
"""Thickness of a slice in the paper (section 3.3: 1 cm), metres."""


@dataclass(frozen=True, slots=True)
class AdaptiveCut:
    """Slices whose thickness and distance follow the points, so that every centre reaches a wanted sigma.

    Attributes
    ----------
    sigma_center_m : float
        Wanted standard deviation of the less certain component of a centre, metres.
    least_thickness_m, most_thickness_m : float
        Thickness of a slice, whatever the points, metres.
    """

    sigma_center_m: float
    least_thickness_m: float = 0.02
    most_thickness_m: float = 2.0


@dataclass(frozen=True, slots=True)
class SlicingScheme:
    """How a shaft is cut, and how the paper finds the axis from the slices.

    Exactly one of ``interval_m``, ``heights_m``, ``ends_only``, ``adaptive`` and ``surface`` says where the slices lie.

    Attributes
    ----------
    name : str
        A to F of the paper, or a user's own.
    description : str
        One clause for tables and help.
    interval_m : float or None
        Distance of neighbouring slices, metres.
    heights_m : tuple of float or None
        Mid-heights of the slices in the site frame, ascending, metres.
    ends_only : bool
        True for the first and the last slice that fit into the shaft.
    thickness_m : float
        Height of a slice, metres; of slices that follow the points the least.
    contour, axis : str
        Names of the contour model and the axis estimator of method ``paper``.
    robust_contour, robust_axis : str
        The same of method ``robust``.
    adaptive : AdaptiveCut or None
        Slices that follow the points.
    surface : str or None
        Model of the whole surface: nothing is sliced, all points are fitted at once (method ``surface``).
    """

    name: str
    description: str
    interval_m: float | None = None
    heights_m: tuple[float, ...] | None = None
    ends_only: bool = False
    thickness_m: float = THICKNESS_M
    contour: str = "kasa"
    axis: str = "irls"
    robust_contour: str = "robust_circle"
    robust_axis: str = "robust_line"
    adaptive: AdaptiveCut | None = None
    surface: str | None = None

    def __post_init__(self) -> None:
        ways = (self.interval_m, self.heights_m, self.adaptive, self.surface)
        stated = sum(way is not None for way in ways) + self.ends_only
        if stated != 1:
            raise ShapeError(
                f"scheme {self.name!r} needs exactly one of interval_m, heights_m, ends_only, adaptive and surface, "
                f"got {stated}"
            )


def user_scheme(
    name: str,
    interval_m: float | None = None,
    heights_m: Sequence[float] | None = None,
    thickness_m: float = THICKNESS_M,
    adaptive: AdaptiveCut | None = None,
    surface: str | None = None,
) -> SlicingScheme:
    """Make a scheme of a user's own: by interval, by a list of heights, following the points, or without slices.

    Heights may come in any order; whether they lie in the shaft is checked where the shaft is known, in
    ``slice_heights``.

    Parameters
    ----------
    name : str
        How tables call it.
    interval_m : float, optional
        Distance of neighbouring slices, metres, above 0.
    heights_m : sequence of float, optional
        Mid-heights of the slices in the site frame, metres, at least 2.
    thickness_m : float
        Height of a slice, metres, above 0; of slices at an interval or at listed heights.
    adaptive : AdaptiveCut, optional
        Slices that follow the points.
    surface : str, optional
        Name of a model of the whole surface.

    Raises
    ------
    InputError
        If not exactly one of the four ways to cut is given, or a value makes no sense.
    """
    _check_length(name, "thickness_m", thickness_m)
    ways = {"interval_m": interval_m, "heights_m": heights_m, "adaptive": adaptive, "surface": surface}
    stated = [way for way, value in ways.items() if value is not None]
    if len(stated) != 1:
        raise InputError(
            f"scheme {name!r} needs one of {', '.join(ways)}, got {' and '.join(stated) or 'none'}"
        )
    if adaptive is not None:
        return _following(name, adaptive)
    if surface is not None:
        return SlicingScheme(name, f"whole surface by {surface}", surface=surface)
    if interval_m is not None:
        _check_length(name, "interval_m", interval_m)
        return SlicingScheme(
            name, f"every {interval_m:g} m", interval_m=float(interval_m), thickness_m=thickness_m
        )
    heights = _checked_heights(name, heights_m or ())
    return SlicingScheme(
        name, f"at {len(heights)} listed heights", heights_m=heights, thickness_m=thickness_m
    )


def _following(name: str, cut: AdaptiveCut) -> SlicingScheme:
    for field in fields(cut):
        _check_length(name, f"adaptive.{field.name}", getattr(cut, field.name))
    if cut.least_thickness_m > cut.most_thickness_m:
        raise InputError(
            f"scheme {name!r} needs least_thickness_m up to most_thickness_m, "
            f"got {cut.least_thickness_m:g} and {cut.most_thickness_m:g} m"
        )
    return SlicingScheme(
        name,
        f"as thick as a centre of {1000.0 * cut.sigma_center_m:g} mm needs",
        thickness_m=cut.least_thickness_m,
        adaptive=cut,
    )


def _check_length(name: str, what: str, value_m: float) -> None:
    if not (math.isfinite(value_m) and value_m > 0.0):
        raise InputError(f"scheme {name!r} needs {what} above 0 m, got {value_m:g}")


def _checked_heights(name: str, heights_m: Sequence[float]) -> tuple[float, ...]:
    heights = tuple(sorted(float(height) for height in heights_m))
    if len(heights) < 2:
        raise InputError(f"scheme {name!r} needs at least 2 heights_m for an axis, got {len(heights)}")
    if not all(math.isfinite(height) for height in heights):
        raise InputError(f"scheme {name!r} needs finite heights_m, got {list(heights)}")
    if len(set(heights)) < len(heights):
        raise InputError(f"scheme {name!r} needs heights_m that differ, got {list(heights)}")
    return heights
