"""First circles: where the iterations begin."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle
from tasks.contours.straightening import StraightSection
from tasks.geometry.failure import FitFailure

CANDIDATE_POINTS: Final = 180
"""Points, evenly taken along the contour, from which circles through three points are tried."""


def taubin_circle(xy_m: NDArray[np.float64]) -> Circle | FitFailure:
    """Fit Taubin's algebraic circle to points (n, 2), n >= 3: nearly unbiased also on short arcs.

    References
    ----------
    Taubin 1991, IEEE PAMI 13; Al-Sharadqah & Chernov 2009, doi 10.1214/09-EJS419 (singular value form).
    """
    mean = xy_m.mean(axis=0)
    x, y = (xy_m - mean).T
    z = x * x + y * y
    root_z = np.sqrt(z.mean())
    # the triangle of QR has the singular vectors of the tall matrix at a fraction of the cost
    triangle = np.linalg.qr(np.column_stack([(z - z.mean()) / (2 * root_z), x, y]), mode="r")
    a1, a2, a3 = np.linalg.svd(triangle)[2][-1]
    a1 = a1 / (2 * root_z)
    if abs(a1) * root_z <= np.finfo(float).eps:
        return FitFailure(f"needs points around a contour, got {len(x)} on one line")
    a4 = -z.mean() * a1
    radius = np.sqrt(a2**2 + a3**2 - 4 * a1 * a4) / (2 * abs(a1))
    circle = Circle(float(mean[0] - a2 / (2 * a1)), float(mean[1] - a3 / (2 * a1)), float(radius))
    return circle if circle.finite else FitFailure("needs points around a contour, got no finite circle")


def resistant_circle(section: StraightSection) -> Circle | FitFailure:
    """Find the circle that half of the points lie closest to: least median of distances over some candidates.

    Candidates are Taubin's circle and circles through three points far apart along the contour. Up to a third of the
    points may lie anywhere, also on an arc and also in one heap, and one candidate in five is still clean.

    References
    ----------
    Rousseeuw 1984, Least median of squares regression, JASA 79.
    """
    from tasks.contours.circle_kernel import nearest_circle  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    taubin = taubin_circle(section.xy_m)
    order = order_along_contour(section, taubin)
    count = min(len(order), CANDIDATE_POINTS)
    sample = order[np.linspace(0, len(order) - 1, count).astype(np.intp)]
    xy, widening = section.xy_m[sample], section.widening_m[sample]
    centers = _centers_a_third_apart(xy)
    if isinstance(taubin, Circle):
        centers = np.vstack([[taubin.east_m, taubin.north_m], centers])
    if not len(centers):
        return FitFailure("needs points around a contour, got points on one line")
    points = (np.ascontiguousarray(xy[:, 0]), np.ascontiguousarray(xy[:, 1]), widening, np.empty(0))
    circle = Circle(*nearest_circle(points, centers))
    return circle if circle.finite else FitFailure("needs points around a contour, got no finite circle")


def order_along_contour(section: StraightSection, rough: Circle | FitFailure) -> NDArray[np.intp]:
    """Indices (n,) of the points as they follow each other about a rough circle, the widest gap between last and first."""
    middle = np.array([rough.east_m, rough.north_m]) if isinstance(rough, Circle) else np.zeros(2)
    east, north = (section.xy_m - middle).T
    angles = np.arctan2(north, east)
    order = np.argsort(angles)
    # cut the ring at its widest gap, so that an arc is one run from end to end
    gaps = np.diff(angles[order], append=angles[order[0]] + 2 * np.pi)
    return np.asarray(np.roll(order, -(int(np.argmax(gaps)) + 1)))


def centers_through_three(
    first: NDArray[np.float64], second: NDArray[np.float64], third: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Centres (k, 2) of the circles through points of three sets (n, 2), those on one line left out."""
    to_second, to_third = second - first, third - first
    double_area = to_second[:, 0] * to_third[:, 1] - to_second[:, 1] * to_third[:, 0]
    square_second, square_third = (to_second**2).sum(axis=1), (to_third**2).sum(axis=1)
    good = np.abs(double_area) > 1e-9 * (square_second + square_third)
    numerator = np.column_stack(
        [
            to_third[:, 1] * square_second - to_second[:, 1] * square_third,
            to_second[:, 0] * square_third - to_third[:, 0] * square_second,
        ]
    )
    return np.asarray(first[good] + numerator[good] / (2 * double_area[good, None]))


def _centers_a_third_apart(xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centres (k, 2) of the circles through point i and those a third and two thirds of the run further on."""
    n = len(xy)
    return centers_through_three(xy, np.roll(xy, -(n // 3), axis=0), np.roll(xy, -(2 * n // 3), axis=0))
