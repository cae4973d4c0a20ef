"""The tilt parameters of a lean vector, with their standard deviations."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.conventions import azimuth_deg
from tasks.tilt.paper import beta_deg

SIGNIFICANT_SIGMAS: Final = 3.0
"""A lean below this many sigmas has no direction that one could sign (docs/estimators.md)."""


@dataclass(frozen=True, slots=True)
class TiltParameters:
    """What follows from a lean vector; the names are those of the tilt view.

    A sigma is None where the lean vector came without covariance. ``azimuth_deg`` and its sigma are None
    where the lean is exactly zero, or below three sigmas of its least certain direction.
    """

    d_east: float
    d_north: float
    d_up: float
    tilt_deg: float
    tilt_sigma_deg: float | None
    azimuth_deg: float | None
    azimuth_sigma_deg: float | None
    beta_deg: float
    verticality_permille: float
    deviation_m: float
    deviation_sigma_m: float | None


@dataclass(frozen=True, slots=True)
class _LeanSigmas:
    along: float
    across: float
    worst: float


def tilt_parameters(
    lean: NDArray[np.float64], covariance: NDArray[np.float64] | None, height_m: float
) -> TiltParameters:
    """Derive tilt, azimuth, verticality and deviation from the lean vector, to first order.

    With u along and n across the lean t and C its covariance: sigma of the tilt is cos^2(tilt) sqrt(u'Cu),
    of the azimuth sqrt(n'Cn)/|t|, of the deviation H sqrt(u'Cu). ``height_m`` is taken as exact.

    Below three sigmas the direction u is not known, so u'Cu has no meaning: the sigmas of tilt and
    deviation are then those of one component of the lean in its least certain direction, the azimuth is
    None, and the length of the lean is biased upward (Rice distribution): work with the two components.

    Parameters
    ----------
    lean : (2,) array
        Lean vector (east, north), dimensionless.
    covariance : (2, 2) array or None
        Covariance of the lean vector, or None where none is known.
    height_m : float
        Height H at which the deviation is stated, above 0.

    Returns
    -------
    TiltParameters
        Degrees, permille and metres.

    Raises
    ------
    ShapeError
        If shapes are wrong, values not finite, the covariance not symmetric or not positive
        semi-definite, or the height not above 0.

    References
    ----------
    Zhou et al. 2025, eq. 19 to 22; JCGM 100 for the propagation.
    """
    lean = _checked_lean(lean)
    if not (np.isfinite(height_m) and height_m > 0.0):
        raise ShapeError(f"tilt_parameters needs height_m above 0; got {height_m}")
    tangent = float(np.hypot(lean[0], lean[1]))
    sigmas = None if covariance is None else _lean_sigmas(lean, tangent, _checked_covariance(covariance))
    has_direction = tangent > 0.0 and (sigmas is None or tangent >= SIGNIFICANT_SIGMAS * sigmas.worst)
    length_sigma = None if sigmas is None else (sigmas.along if has_direction else sigmas.worst)
    direction = np.array([lean[0], lean[1], 1.0]) / np.sqrt(1.0 + tangent**2)
    return TiltParameters(
        d_east=float(direction[0]),
        d_north=float(direction[1]),
        d_up=float(direction[2]),
        tilt_deg=float(np.degrees(np.arctan(tangent))),
        # cos^2 of the tilt is 1 / (1 + tan^2)
        tilt_sigma_deg=None if length_sigma is None else float(np.degrees(length_sigma / (1.0 + tangent**2))),
        # the modulo of a tiny negative angle rounds to 360 itself; a second one makes it 0
        azimuth_deg=azimuth_deg(float(lean[0]), float(lean[1])) if has_direction else None,
        azimuth_sigma_deg=_azimuth_sigma_deg(sigmas, tangent) if has_direction else None,
        beta_deg=beta_deg(direction),
        verticality_permille=1000.0 * tangent,
        deviation_m=height_m * tangent,
        deviation_sigma_m=None if length_sigma is None else height_m * length_sigma,
    )


def lean_of_direction(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lean vector (2,) of a direction (3,) of any length and sense; the sense is fixed by up above 0.

    Raises
    ------
    ShapeError
        If the direction is not three finite numbers, or lies flat.
    """
    d = np.asarray(direction, dtype=np.float64)
    if d.shape != (3,) or not np.isfinite(d).all() or d[2] == 0.0:
        raise ShapeError(
            f"lean_of_direction needs a finite direction (3,) that is not flat; got {direction!r}"
        )
    return np.asarray(d[:2] / d[2])


def _lean_sigmas(lean: NDArray[np.float64], tangent: float, C: NDArray[np.float64]) -> _LeanSigmas:
    worst = float(np.sqrt(np.maximum(np.linalg.eigvalsh(C)[-1], 0.0)))
    if tangent == 0.0:
        return _LeanSigmas(along=worst, across=worst, worst=worst)
    u = lean / tangent
    n = np.array([-u[1], u[0]])
    return _LeanSigmas(along=_sigma_along(u, C), across=_sigma_along(n, C), worst=worst)


def _sigma_along(unit: NDArray[np.float64], C: NDArray[np.float64]) -> float:
    # rounding may take the variance of a rank-one covariance below zero
    return float(np.sqrt(np.maximum(unit @ C @ unit, 0.0)))


def _azimuth_sigma_deg(sigmas: _LeanSigmas | None, tangent: float) -> float | None:
    return None if sigmas is None else float(np.degrees(sigmas.across / tangent))


def _checked_lean(lean: NDArray[np.float64]) -> NDArray[np.float64]:
    checked = np.asarray(lean, dtype=np.float64)
    if checked.shape != (2,) or not np.isfinite(checked).all():
        raise ShapeError(f"tilt_parameters needs a finite lean vector (2,); got {lean!r}")
    return checked


def _checked_covariance(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    C = np.asarray(covariance, dtype=np.float64)
    if C.shape != (2, 2) or not np.isfinite(C).all():
        raise ShapeError(f"tilt_parameters needs a finite covariance (2, 2); got {covariance!r}")
    # rounding of a sum of outer products, far below any variance that matters
    slack = 1e-9 * float(np.abs(C).max())
    if abs(C[0, 1] - C[1, 0]) > slack or np.linalg.eigvalsh(C)[0] < -slack:
        raise ShapeError(
            f"tilt_parameters needs a symmetric positive semi-definite covariance; got {C.tolist()}"
        )
    return C
