"""Two axes of slices compared at the heights that both epochs have.

A lean from slices is that of the heights that gave a centre. If an epoch lacks some, a shaft that bends leans otherwise
without having moved. So the differences of centres and radii are fitted where both have them: what the axis and the radius
are in themselves then cancels.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.change.difference import ParameterChange

LEAST_COMMON: Final = 4
LEAST_FOR_BEND: Final = 6
LEAST_FOR_S_BEND: Final = 12
LEAST_FOR_PROFILE: Final = 12

SAME_HEIGHT_M: Final = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class SliceAxis:
    """Slices that gave a centre, bottom up.

    ``z_m`` (m,), ``east_north_radius_m`` (m, 3), ``variance_m2`` (m,) of one component of the centre from its points, weight
    in the axis (m,), and the ends of the part that is cut, metres.
    """

    z_m: NDArray[np.float64]
    east_north_radius_m: NDArray[np.float64]
    variance_m2: NDArray[np.float64]
    weight: NDArray[np.float64]
    ends_m: tuple[float, float]


def same_heights(before: SliceAxis, after: SliceAxis) -> bool:
    """Whether both epochs have a centre at the same heights."""
    return len(before.z_m) == len(after.z_m) and bool((np.abs(before.z_m - after.z_m) < SAME_HEIGHT_M).all())


def at_common_heights(free: ParameterChange, before: SliceAxis, after: SliceAxis) -> ParameterChange | None:
    """Count a change anew from the heights that both epochs have; None where they are too few to have a lean.

    Standard deviations grow by what is lost of the points; correlations stay as they are.
    """
    nearest = np.abs(before.z_m[:, None] - after.z_m[None, :])
    old, new = np.nonzero(nearest < SAME_HEIGHT_M)
    weight = np.sqrt(before.weight[old] * after.weight[new])
    # an axis may rest on few of its centres, and the other epoch on others
    if np.count_nonzero(weight) < LEAST_COMMON:
        return None
    z_m = after.z_m[new]
    low, high = after.ends_m
    d = after.east_north_radius_m[new] - before.east_north_radius_m[old]
    rows = _rows(z_m, weight, (low, high))
    names, places = [], []
    for place, name in enumerate(free.names):
        if name in rows:
            names.append(name)
            places.append(place)
    made = np.array([rows[name] @ d[:, _column(name)] for name in names])
    noise = before.variance_m2[old] + after.variance_m2[new]
    growth = np.array([_growth(name, rows[name], noise, (before, after)) for name in names])
    total = np.diag(free.covariance)[places]
    scale = np.sqrt(1.0 + np.maximum(growth, 0.0) / total)
    covariance = free.covariance[np.ix_(places, places)] * np.outer(scale, scale)
    return replace(free, names=tuple(names), difference=made, covariance=covariance)


def _column(name: str) -> int:
    return 2 if name.startswith("radius") else 0 if name.endswith("east") else 1


def _growth(
    name: str, row: NDArray[np.float64], noise_m2: NDArray[np.float64], both: tuple[SliceAxis, SliceAxis]
) -> float:
    """Variance by the points at the common heights less that at each epoch's own ones."""
    mine = float(row**2 @ noise_m2)
    for one in both:
        own = _rows(one.z_m, one.weight, one.ends_m).get(name)
        mine -= 0.0 if own is None else float(own**2 @ one.variance_m2)
    return mine


def _rows(
    z_m: NDArray[np.float64], weight: NDArray[np.float64], ends_m: tuple[float, float]
) -> dict[str, NDArray[np.float64]]:
    """Functions (m,) of the slices that give each parameter."""
    mean = weight @ z_m / weight.sum()
    lean = weight * (z_m - mean) / (weight @ (z_m - mean) ** 2)
    base = weight / weight.sum() - mean * lean
    rows = {
        f"{name}_{side}": row for name, row in (("base", base), ("lean", lean)) for side in ("east", "north")
    }
    share = (2.0 * z_m - sum(ends_m)) / (ends_m[1] - ends_m[0])
    if len(z_m) >= LEAST_FOR_BEND:
        bend = np.linalg.pinv(np.polynomial.legendre.legvander(share, 2))[2]
        rows |= {f"bend_{side}": bend for side in ("east", "north")}
    if len(z_m) >= LEAST_FOR_S_BEND:
        s_bend = np.linalg.pinv(np.polynomial.legendre.legvander(share, 3))[3]
        rows |= {f"s_bend_{side}": s_bend for side in ("east", "north")}
    if len(z_m) >= LEAST_FOR_PROFILE:
        profile = np.linalg.pinv(np.polynomial.legendre.legvander(share, 4))
        rows |= {f"radius_{order}": row for order, row in enumerate(profile)}
    return rows
