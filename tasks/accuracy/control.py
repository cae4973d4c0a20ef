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


@dataclass(frozen=True, slots=True)
class Control:
    """The values that relative errors are counted from, named as in the tilt view.

    ``label`` is scheme/method, or the source of a reference measurement. A control is what one compares
    with, not a truth.
    """

    label: str
    beta_deg: float
    azimuth_deg: float | None
    tilt_deg: float
    verticality_permille: float
    deviation_m: float


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
            )
    known = ", ".join(label_of(row) for row in rows) or "none"
    return FitFailure(
        f"the control {scheme}/{method} has no axis in this epoch; those that have one: {known}"
    )


def control_of_lean(source: str, lean: NDArray[np.float64], height_m: float) -> Control:
    """Control values from a lean vector that was measured by other means.

    Parameters
    ----------
    source : str
        By what means, for the label.
    lean : (2,) array
        Lean vector (east, north), dimensionless.
    height_m : float
        Height H of the deviation.

    Returns
    -------
    Control
        Without azimuth where the lean is exactly zero.

    Raises
    ------
    ShapeError
        If the lean is not two finite numbers.
    """
    if np.shape(lean) != (2,) or not np.isfinite(lean).all():
        raise ShapeError(f"control_of_lean needs a finite lean vector (2,); got {lean!r}")
    east, north = float(lean[0]), float(lean[1])
    tangent = float(np.hypot(east, north))
    return Control(
        label=source,
        beta_deg=float(np.degrees(np.arctan2(np.hypot(north, 1.0), east))),
        # the modulo of a tiny negative angle rounds to 360 itself; a second one makes it 0
        azimuth_deg=azimuth_deg(east, north) if tangent > 0.0 else None,
        tilt_deg=float(np.degrees(np.arctan(tangent))),
        verticality_permille=1000.0 * tangent,
        deviation_m=height_m * tangent,
    )


def label_of(row: TiltRow) -> str:
    """Scheme/method of a row, as controls are labelled."""
    return f"{row.scheme}/{row.method}"
