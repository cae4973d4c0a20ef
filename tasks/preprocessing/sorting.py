"""Which points are the shaft's: by height and distance, by their place about its surface, and among each other."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.preprocessing.denoising import find_isolated
from tasks.preprocessing.finding import FoundSurface
from tasks.preprocessing.kinds import StructureKind
from tasks.preprocessing.prior import ShaftOptions, StructurePrior
from tasks.preprocessing.reasons import KEPT, REASONS
from tasks.preprocessing.redundancy import find_duplicates
from tasks.preprocessing.search import reach_m

HIGH: Final = REASONS.index("outside the height range")
FAR: Final = REASONS.index("far from the structure")
INSIDE: Final = REASONS.index("inside the shaft")
OFF: Final = REASONS.index("off the surface (ladder, platform, surroundings)")
ISOLATED: Final = REASONS.index("isolated")
DUPLICATE: Final = REASONS.index("duplicate")


def sort_by_gate(
    points_m: NDArray[np.float64], prior: StructurePrior, kind: StructureKind
) -> NDArray[np.uint8]:
    """Reasons (n,) of points (n, 3) after the gates of height and of distance from the prior's position."""
    from tasks.preprocessing.kernels import gate_points  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    reason = np.empty(len(points_m), dtype=np.uint8)
    low_m, high_m = prior.shaft_z_m
    east_m, north_m = prior.base_xy_m
    gate_points(
        points_m, low_m, high_m, east_m, north_m, reach_m(prior, kind) ** 2, (HIGH, FAR, KEPT), reason
    )
    return reason


def sort_by_surface(
    near_m: NDArray[np.float64], found: FoundSurface, options: ShaftOptions
) -> NDArray[np.uint8]:
    """Reasons (n,) of points (n, 3) by their distance from the surface."""
    away = found.distance(near_m)
    gate_m = options.gate_sigmas * found.model.noise_sigma_m + options.gate_radius_fraction * away.radius_m
    reason = np.full(len(near_m), KEPT, dtype=np.uint8)
    reason[away.off_m < -gate_m] = INSIDE
    reason[away.off_m > gate_m] = OFF
    return reason


def sort_among(
    points_m: NDArray[np.float64],
    around_m: NDArray[np.float64],
    edges_m: NDArray[np.float64],
    options: ShaftOptions,
) -> NDArray[np.uint8]:
    """Reasons (n,) of points (n, 3) on the surface: those that stand alone, and those that say what an earlier one says.

    ``around_m`` (n,) is the arc length around the axis, ``edges_m`` (k + 1,) are the height bands.
    """
    reason = np.full(len(points_m), KEPT, dtype=np.uint8)
    alone = find_isolated(around_m, points_m[:, 2], edges_m, options.min_neighbours)
    reason[alone] = ISOLATED
    reason[find_duplicates(points_m, ~alone, options.voxel_m)] = DUPLICATE
    return reason
