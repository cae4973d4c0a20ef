"""Contour model ``polygon``: a line for every face, the centre on the mid-lines of opposite faces."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle, arc_coverage_deg
from tasks.contours.circle_fit import LOOSEST_CENTRE
from tasks.contours.model import ContourModel
from tasks.contours.outline import Outline
from tasks.contours.polygon_lines import FaceLinesFit, FacePoints, fit_face_lines
from tasks.contours.polygon_start import rough_outline
from tasks.contours.section import Contour, Section
from tasks.geometry.faces import normals_of, opposite_pairs
from tasks.geometry.failure import FitFailure

MIN_POINTS: Final = 20
"""Fewer leave no face with enough points."""


@dataclass(frozen=True, slots=True, eq=False)
class _Centre:
    """Centre (2,) about the rough one, its covariance (2, 2), and what sides were taken from elsewhere."""

    place_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64]
    reason: str | None


@dataclass(frozen=True, slots=True, eq=False)
class _Measured:
    fit: FaceLinesFit
    centre: _Centre


def fit_polygon(section: Section) -> Contour | FitFailure:
    """Fit a straight line to every face that has points, and put the centre on the mid-lines of opposite faces.

    Lean and the taper of every face are taken out first. The faces keep the angles of ``Section.outline``; without one
    they are four at right angles. Where one of two opposite faces has no points, the outline must know the side between
    them: its standard deviation then goes into the covariance of the centre, and the reason says so. That error is
    common to all sections that take the side from there.

    The radius is the mean distance of the faces with points from the centre. The covariance is that of the robust
    offsets; it takes the points as independent.

    References
    ----------
    Huber 1981, Robust Statistics, section 7.6 (covariance).
    """
    rise = section.points_m[:, 2] - section.z_m
    lean = np.array([section.lean_east, section.lean_north])
    origin = section.points_m[:, :2].mean(axis=0) if section.outline is None else section.outline.center_m
    xy = section.points_m[:, :2] - origin - rise[:, None] * lean
    start = rough_outline(xy, section.taper) if section.outline is None else section.outline
    if isinstance(start, FitFailure):
        return start
    if section.outline is None:
        origin, xy = origin + start.center_m, xy - start.center_m
    first = _measure(FacePoints(xy, rise), start, start)
    if isinstance(first, FitFailure):
        return first
    # about a rough centre the rotation would leak into the offsets: go to the one that was found, and repeat
    moved = FacePoints(xy - first.centre.place_m, rise)
    final = _measure(moved, _about(first.fit.outline, first.centre.place_m), start)
    if isinstance(final, FitFailure):
        return final
    place = final.centre.place_m
    return _contour(final, origin + first.centre.place_m + place, moved.xy_m - place)


def _measure(points: FacePoints, start: Outline, known: Outline) -> _Measured | FitFailure:
    fit = fit_face_lines(points, start)
    if isinstance(fit, FitFailure):
        return fit
    centre = _centre_of(fit, known)
    return centre if isinstance(centre, FitFailure) else _Measured(fit, centre)


def _about(outline: Outline, place_m: NDArray[np.float64]) -> Outline:
    return Outline(
        center_m=outline.center_m + place_m,
        azimuth_rad=outline.azimuth_rad,
        half_m=outline.half_m - normals_of(outline.azimuth_rad) @ place_m,
        taper=outline.taper,
        sigma_m=outline.sigma_m,
    )


def _centre_of(fit: FaceLinesFit, known: Outline) -> _Centre | FitFailure:
    """Centre of the faces, with sides that ``known`` has where opposite faces were not both seen."""
    normal, distance, m = normals_of(fit.outline.azimuth_rad), fit.outline.half_m, len(fit.seen)
    pairs = opposite_pairs(m)
    lines, rows, lone = np.zeros((len(pairs), 2)), np.zeros((len(pairs), m)), np.zeros(len(pairs))
    taken = np.zeros(len(pairs))
    for k, (i, j) in enumerate(pairs):
        if fit.seen[i] and fit.seen[j]:
            lines[k], rows[k, [i, j]] = normal[i] - normal[j], (1.0, -1.0)
        elif fit.seen[i] or fit.seen[j]:
            face = i if fit.seen[i] else j
            if not np.isfinite(known.sigma_m[face]):
                return _undetermined(fit)
            lines[k], rows[k, face] = normal[face], 1.0
            taken[k], lone[k] = (known.half_m[i] + known.half_m[j]) / 2.0, known.sigma_m[face]
    if np.linalg.matrix_rank(lines) < 2:
        return _undetermined(fit)
    solve = np.linalg.pinv(lines)
    covariance = solve @ (rows @ fit.covariance_m2 @ rows.T + np.diag(lone**2)) @ solve.T
    return _Centre(solve @ (rows @ distance - taken), np.asarray(covariance), _reason(taken, lone))


def _reason(taken_m: NDArray[np.float64], sigma_m: NDArray[np.float64]) -> str | None:
    used = [f"{2e3 * half:.0f} mm" for half in taken_m if half > 0.0]
    if not used:
        return None
    return (
        f"opposite faces not both seen: {' and '.join(used)} of side taken from the model of the shaft, "
        f"good to {2e3 * sigma_m.max():.1f} mm"
    )


def _undetermined(fit: FaceLinesFit) -> FitFailure:
    azimuths = np.degrees(fit.outline.azimuth_rad[fit.seen]) % 360.0
    listed = ", ".join(f"{azimuth:.0f}" for azimuth in sorted(azimuths))
    return FitFailure(
        f"centre not determined: needs opposite faces both ways, or sides that were measured at other heights; "
        f"got faces at azimuths {listed} deg"
    )


def _contour(
    measured: _Measured, center_m: NDArray[np.float64], xy_m: NDArray[np.float64]
) -> Contour | FitFailure:
    """Put together what was found; points (n, 2) about the centre."""
    fit, centre = measured.fit, measured.centre
    half = fit.outline.half_m - normals_of(fit.outline.azimuth_rad) @ centre.place_m
    radius = float(half[fit.seen].mean())
    sigma = float(np.sqrt(np.linalg.eigvalsh(centre.covariance_m2)[-1]))
    if sigma > LOOSEST_CENTRE * radius:
        return FitFailure(f"faces fix the centre to {sigma:.3g} m only, at half a side of {radius:.3g} m")
    used_off = fit.split.off[fit.used]
    return Contour(
        center_east_m=float(center_m[0]),
        center_north_m=float(center_m[1]),
        radius_m=radius,
        covariance_m2=centre.covariance_m2,
        rmse_m=float(np.sqrt(np.mean(used_off**2))),
        n_used=int(fit.used.sum()),
        arc_coverage_deg=arc_coverage_deg(xy_m[fit.used], Circle(0.0, 0.0, radius)),
        noise_m=fit.sigma_m,
        reason=centre.reason,
    )


CONTOUR: Final = ContourModel(
    "polygon",
    "a line with Tukey weights for every face of a square or rectangular section",
    min_points=MIN_POINTS,
    fit=fit_polygon,
)
