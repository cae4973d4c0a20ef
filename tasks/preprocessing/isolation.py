"""The shaft out of a cloud that is in memory: what is kept, what is removed, and why."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.geometry.variants import choose
from tasks.preprocessing.explaining import explain_failure
from tasks.preprocessing.finding import FoundSurface, find_surface
from tasks.preprocessing.kinds import KINDS
from tasks.preprocessing.model import ShaftModel
from tasks.preprocessing.prior import ShaftOptions, StructurePrior
from tasks.preprocessing.reasons import KEPT, Removal, count_reasons, removals
from tasks.preprocessing.sorting import sort_among, sort_by_gate, sort_by_surface


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
    symmetric gate of that surface, are not alone there and are the first of their voxel. All of them:
    ``options.most_points`` is of no account here.

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
    reason = sort_by_gate(points_m, prior, kind)
    near = np.flatnonzero(reason == KEPT)
    found = find_surface(points_m[near], prior, kind, options.seed)
    if isinstance(found, FitFailure):
        return explain_failure(found, points_m, prior, kind)
    reason[near] = _sort_near(points_m[near], found, options)
    return Shaft(np.flatnonzero(reason == KEPT), reason, found.model, removals(count_reasons(reason)))


def _sort_near(near_m: NDArray[np.float64], found: FoundSurface, options: ShaftOptions) -> NDArray[np.uint8]:
    """Reasons (n,) of points (n, 3) by their place about the surface and among each other."""
    reason = sort_by_surface(near_m, found, options)
    on = np.flatnonzero(reason == KEPT)
    on_m = near_m[on]
    reason[on] = sort_among(on_m, found.unroll(on_m), np.array(found.model.radius_z_m), options)
    return reason
