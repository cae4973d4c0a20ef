"""What the schemes are compared with."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from storage.records import TiltRow
from tasks.conventions import azimuth_deg
from tasks.geometry.failure import FitFailure

QUANTITIES: Final = ("beta_deg", "azimuth_deg", "tilt_deg", "verticality_permille", "deviation_m")
"""The quantities that are compared, by their columns in the tilt view."""


SIGNIFICANT_SIGMAS: Final = 3.0
"""A lean below this many sigmas has no direction, as in the tilt table."""


@dataclass(frozen=True, slots=True)
class Control:
    """The values that relative errors are counted from, named as in the tilt view.

    ``label`` is scheme/method, or the source of a reference measurement. A control is what one compares
    with, not a truth. Sigmas are None where they are not known.
    """

    label: str
    beta_deg: float
    azimuth_deg: float | None
    tilt_deg: float
    verticality_permille: float
    deviation_m: float
    azimuth_sigma_deg: float | None = None
    tilt_sigma_deg: float | None = None
    verticality_sigma_permille: float | None = None
    deviation_sigma_m: float | None = None

    def sigma_of(self, quantity: str) -> float | None:
        """Standard deviation of a quantity, in its unit; eq. 19 has none."""
        return {
            "azimuth_deg": self.azimuth_sigma_deg,
            "tilt_deg": self.tilt_sigma_deg,
            "verticality_permille": self.verticality_sigma_permille,
            "deviation_m": self.deviation_sigma_m,
        }.get(quantity)


def control_of_scheme(rows: Sequence[TiltRow], scheme: str, method: str) -> Control | FitFailure:
    """Control values from a scheme and method of the same epoch, of which there may be none."""
    for row in rows:
        if (row.scheme, row.method) == (scheme, method):
            return Control(
                label=label_of(row),
                beta_deg=row.beta_deg,
                azimuth_deg=row.azimuth_deg,
                tilt_deg=row.tilt_deg,
                verticality_permille=row.verticality_permille,
                deviation_m=row.deviation_m,
                azimuth_sigma_deg=row.azimuth_sigma_deg,
                tilt_sigma_deg=row.tilt_sigma_deg,
                verticality_sigma_permille=_permille(row.deviation_sigma_m, row.height_m),
                deviation_sigma_m=row.deviation_sigma_m,
            )
    known = ", ".join(label_of(row) for row in rows) or "none"
    return FitFailure(
        f"the control {scheme}/{method} has no axis in this epoch; those that have one: {known}"
    )


def control_of_lean(
    source: str, lean: NDArray[np.float64], height_m: float, sigma: float | None = None
) -> Control:
    """Control values from a lean vector that was measured by other means.

    Parameters
    ----------
    source : str
        By what means, for the label.
    lean : (2,) array
        Lean vector (east, north), dimensionless.
    height_m : float
        Height H of the deviation.
    sigma : float, optional
        Standard deviation of each component; without it every lean that is not zero has an azimuth.

    Returns
    -------
    Control
        Without azimuth where the lean is exactly zero, or below three sigmas: such a lean has no direction.

    Raises
    ------
    ShapeError
        If the lean is not two finite numbers, or sigma not above 0.
    """
    if np.shape(lean) != (2,) or not np.isfinite(lean).all():
        raise ShapeError(f"control_of_lean needs a finite lean vector (2,); got {lean!r}")
    if sigma is not None and not sigma > 0.0:
        raise ShapeError(f"control_of_lean needs sigma above 0; got {sigma}")
    east, north = float(lean[0]), float(lean[1])
    tangent = float(np.hypot(east, north))
    has_direction = tangent > 0.0 and (sigma is None or tangent >= SIGNIFICANT_SIGMAS * sigma)
    return Control(
        label=source,
        beta_deg=float(np.degrees(np.arctan2(np.hypot(north, 1.0), east))),
        # the modulo of a tiny negative angle rounds to 360 itself; a second one makes it 0
        azimuth_deg=azimuth_deg(east, north) if has_direction else None,
        tilt_deg=float(np.degrees(np.arctan(tangent))),
        verticality_permille=1000.0 * tangent,
        deviation_m=height_m * tangent,
        azimuth_sigma_deg=float(np.degrees(sigma / tangent)) if sigma is not None and has_direction else None,
        tilt_sigma_deg=None if sigma is None else float(np.degrees(sigma / (1.0 + tangent**2))),
        verticality_sigma_permille=None if sigma is None else 1000.0 * sigma,
        deviation_sigma_m=None if sigma is None else height_m * sigma,
    )


def label_of(row: TiltRow) -> str:
    """Scheme/method of a row, as controls are labelled."""
    return f"{row.scheme}/{row.method}"


def _permille(sigma_m: float | None, height_m: float) -> float | None:
    return None if sigma_m is None else 1000.0 * sigma_m / height_m
