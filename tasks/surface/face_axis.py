"""The axis between opposite faces, with its covariance."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.polynomial.legendre import legval
from numpy.typing import NDArray

from tasks.geometry.faces import normals_of, opposite_pairs
from tasks.geometry.failure import FitFailure
from tasks.surface.face_equations import FaceEquations, FaceState

TAPER_SIGMA: Final = 5e-4
"""How much the tapers of the two directions of a tower differ, where one was not measured: half a millimetre a metre, a
common tolerance of form work, not a measured value. It is 50 mm in the lean of 100 m; between two epochs it cancels."""


@dataclass(frozen=True, slots=True, eq=False)
class AxisOfFaces:
    """The straight line between the faces.

    ``middle_m`` (2,) at the middle height, ``lean`` (2,) with its covariance (2, 2) and what takes it
    out of the unknowns of the equations (2, p), distances ``half_m`` (m,) of the
    faces from it and their ``taper`` (m,); ``bending_m`` and ``assumption`` as in ``FacesFit``.
    """

    middle_m: NDArray[np.float64]
    lean: NDArray[np.float64]
    lean_covariance: NDArray[np.float64]
    lean_of: NDArray[np.float64]
    half_m: NDArray[np.float64]
    taper: NDArray[np.float64]
    bending_m: float | None
    assumption: str | None


@dataclass(frozen=True, slots=True, eq=False)
class _MidPlanes:
    """What the faces say of the axis: ``directions`` (p, 2) times it are ``rows`` (p, m) times the faces.

    ``tapers`` (p, m) takes off the taper of the other directions where only one of two opposite faces is ``lone`` (p,).
    """

    directions: NDArray[np.float64]
    rows: NDArray[np.float64]
    tapers: NDArray[np.float64]
    lone: NDArray[np.bool_]


def axis_of_faces(state: FaceState, equations: FaceEquations) -> AxisOfFaces | FitFailure:
    """Put the axis on the mid-planes of opposite faces."""
    normal = normals_of(state.azimuth_rad)
    planes = _mid_planes(normal, equations.seen)
    if isinstance(planes, FitFailure):
        return planes
    solve = np.linalg.pinv(planes.directions)
    slope = state.distance_m[:, 1] / state.half_height_m
    from_slopes = solve @ (planes.rows - planes.tapers)
    lean = from_slopes @ slope
    places = np.arange(len(slope)) * (equations.n_terms + 1) + 1
    spread = equations.covariance()[np.ix_(places, places)] / state.half_height_m**2
    lean_of = np.zeros((2, len(equations.right)))
    lean_of[:, places] = from_slopes / state.half_height_m
    assumed = np.diag(np.where(planes.lone, TAPER_SIGMA**2, 0.0))
    # across a direction of which one face is seen the place stays: only the lean can be told
    across = np.where(planes.lone[:, None], 0.0, planes.rows)
    shift = solve @ across @ state.distance_m[:, 0]
    return AxisOfFaces(
        middle_m=state.middle_m + shift,
        lean=state.lean + lean,
        lean_covariance=np.asarray(from_slopes @ spread @ from_slopes.T + solve @ assumed @ solve.T),
        lean_of=lean_of,
        half_m=state.distance_m[:, 0] - normal @ shift,
        taper=slope - normal @ lean,
        bending_m=None if planes.lone.any() else _bending_m(solve @ planes.rows @ state.distance_m),
        assumption=_assumption(planes.lone),
    )


def about(state: FaceState, axis: AxisOfFaces) -> FaceState:
    """The same faces about the axis that was found."""
    distance = state.distance_m.copy()
    distance[:, 0], distance[:, 1] = axis.half_m, axis.taper * state.half_height_m
    return replace(state, middle_m=axis.middle_m, lean=axis.lean, distance_m=distance)


def _mid_planes(normal: NDArray[np.float64], seen: NDArray[np.bool_]) -> _MidPlanes | FitFailure:
    m = len(seen)
    pairs = opposite_pairs(m)
    whole = [pair for pair in pairs if seen[pair].all()]
    directions, rows, tapers = np.zeros((len(pairs), 2)), np.zeros((len(pairs), m)), np.zeros((len(pairs), m))
    lone = np.zeros(len(pairs), dtype=np.bool_)
    for k, (i, j) in enumerate(pairs):
        if seen[i] and seen[j]:
            directions[k], rows[k, [i, j]] = normal[i] - normal[j], (1.0, -1.0)
        elif seen[i] or seen[j]:
            face = i if seen[i] else j
            directions[k], rows[k, face], lone[k] = normal[face], 1.0, True
            for pair in whole:
                tapers[k, pair] = 0.5 / len(whole)
    if not whole or np.linalg.matrix_rank(directions) < 2:
        return FitFailure(
            f"needs two opposite faces and one between them, got {np.count_nonzero(seen)} of {m}: "
            "lean and taper cannot be told apart"
        )
    return _MidPlanes(directions, rows, tapers, lone)


def _bending_m(axis_terms_m: NDArray[np.float64]) -> float | None:
    """Largest distance from the straight line of an axis with coefficients (2, t), metres."""
    if axis_terms_m.shape[1] <= 2:
        return None
    bend = axis_terms_m.copy()
    bend[:, :2] = 0.0
    return float(np.hypot(*legval(np.linspace(-1.0, 1.0, 101), bend.T)).max())


def _assumption(lone: NDArray[np.bool_]) -> str | None:
    if not lone.any():
        return None
    return (
        f"of two opposite faces one was not seen: its direction is taken to taper as the other, "
        f"to {1e3 * TAPER_SIGMA:g} mm a metre"
    )
