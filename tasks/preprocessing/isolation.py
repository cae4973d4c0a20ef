"""The shaft out of the cloud: what is kept, what is removed, and why."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.geometry.variants import choose
from tasks.preprocessing.denoising import find_isolated
from tasks.preprocessing.finding import FoundSurface, find_surface
from tasks.preprocessing.kinds import KINDS, StructureKind
from tasks.preprocessing.model import ShaftModel
from tasks.preprocessing.prior import ShaftOptions, StructurePrior
from tasks.preprocessing.redundancy import find_duplicates
from tasks.preprocessing.search import reach_m
from tasks.preprocessing.units import likely_unit

REASONS: Final = (
    "outside the height range",
    "far from the structure",
    "inside the shaft",
    "off the surface (ladder, platform, surroundings)",
    "isolated",
    "duplicate",
    "kept",
)
"""Why a point goes, in the order in which it is asked; the last one stays."""

KEPT: Final = len(REASONS) - 1


@dataclass(frozen=True, slots=True)
class Removal:
    """How many points went for one reason; the reason 'kept' counts those that stayed."""

    reason: str
    n_points: int


@dataclass(frozen=True, slots=True)
class Shaft:
    """The isolated shaft.

    ``keep`` (m,) are the indices of the kept points in the order of input, ``reason_index`` (n,) the place in
    ``REASONS`` of every point's fate, ``removed`` their counts in that order, which add up to n.
    """

    keep: NDArray[np.int64]
    reason_index: NDArray[np.uint8]
    model: ShaftModel
    removed: tuple[Removal, ...]


def isolate_shaft(
    points_m: NDArray[np.float64], prior: StructurePrior, options: ShaftOptions | None = None
) -> Shaft | FitFailure:
    """Separate the shaft of a structure from everything else in a cloud.

    Circles (of a kind with faces: planes) found by consensus in height bands are linked into a rough shaft, a surface
    that may bend, taper and be oval (with faces: turn) is fitted to it robustly, and points stay that are within a
    symmetric gate of that surface, are not alone there and are the first of their voxel.

    Parameters
    ----------
    points_m : (n, 3) array
        The merged cloud in the site frame, metres.
    prior : StructurePrior
        Rough place, size and kind.
    options : ShaftOptions, optional
        Gates and voxel; the defaults suit scans with 2 to 20 mm of noise.

    Raises
    ------
    ShapeError
        If the points are not (n, 3).
    InputError
        If the kind is unknown.
    """
    options = ShaftOptions() if options is None else options
    if points_m.ndim != 2 or points_m.shape[1] != 3:
        raise ShapeError(f"isolate_shaft needs points (n, 3), got {points_m.shape}")
    kind = choose(KINDS, prior.kind, "kind of structure")
    reason = _gate(points_m, prior, reach_m(prior, kind))
    near = np.flatnonzero(reason == KEPT)
    found = find_surface(points_m[near], prior, kind, options.seed)
    if isinstance(found, FitFailure):
        return _explain(found, points_m, prior, kind, reason)
    reason[near] = _sort_by_surface(points_m[near], found, options)
    return _shaft(found, reason)


def _gate(points_m: NDArray[np.float64], prior: StructurePrior, within_m: float) -> NDArray[np.uint8]:
    """Reasons (n,) after the gates of height and of distance from the prior's position."""
    reason = np.zeros(len(points_m), dtype=np.uint8)
    high = np.flatnonzero((points_m[:, 2] >= prior.shaft_z_m[0]) & (points_m[:, 2] <= prior.shaft_z_m[1]))
    off_m = np.hypot(points_m[high, 0] - prior.base_xy_m[0], points_m[high, 1] - prior.base_xy_m[1])
    reason[high] = np.where(off_m <= within_m, KEPT, REASONS.index("far from the structure"))
    return reason


def _sort_by_surface(
    near_m: NDArray[np.float64], found: FoundSurface, options: ShaftOptions
) -> NDArray[np.uint8]:
    """Reasons (n,) of points (n, 3) by their place about the surface and among each other."""
    place = found.place(near_m)
    gate_m = options.gate_sigmas * found.model.noise_sigma_m + options.gate_radius_fraction * place.radius_m
    reason = np.full(len(near_m), KEPT, dtype=np.uint8)
    reason[place.off_m < -gate_m] = REASONS.index("inside the shaft")
    reason[place.off_m > gate_m] = REASONS.index("off the surface (ladder, platform, surroundings)")
    on = np.flatnonzero(reason == KEPT)
    edges_m = np.array(found.model.radius_z_m)
    alone = find_isolated(place.around_m[on], near_m[on, 2], edges_m, options.min_neighbours)
    reason[on[alone]] = REASONS.index("isolated")
    on = np.flatnonzero(reason == KEPT)
    reason[on[find_duplicates(near_m[on], options.voxel_m)]] = REASONS.index("duplicate")
    return reason


def _shaft(found: FoundSurface, reason: NDArray[np.uint8]) -> Shaft:
    counts = np.bincount(reason, minlength=len(REASONS))
    removed = tuple(Removal(name, int(n)) for name, n in zip(REASONS, counts, strict=True))
    return Shaft(np.flatnonzero(reason == KEPT), reason, found.model, removed)


def _explain(
    failure: FitFailure,
    points_m: NDArray[np.float64],
    prior: StructurePrior,
    kind: StructureKind,
    reason: NDArray[np.uint8],
) -> FitFailure:
    """Say what a failed search has most likely met."""
    if not len(points_m):
        return FitFailure("needed points, the cloud is empty")
    unit = likely_unit(points_m, prior, kind)
    if unit is not None:
        return FitFailure(
            f"looks like {unit.name}: the shaft is found after scaling by {unit.in_m:g}, needed metres; "
            "export it in metres"
        )
    if not reason.any():
        lo_m, hi_m = points_m[:, 2].min(), points_m[:, 2].max()
        return FitFailure(
            f"no points in the height range {prior.shaft_z_m} m; the {len(points_m)} points reach "
            f"from {lo_m:.2f} to {hi_m:.2f} m"
        )
    return failure
