"""The rows of leans that were measured by other means."""

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from storage.errors import ShapeError
from storage.records import ReferenceLeanRow
from tasks.evaluation import Occasion, ReferenceLean
from tasks.tilt import tilt_parameters


def reference_rows(
    occasion: Occasion, references: Sequence[ReferenceLean], height_m: float
) -> list[ReferenceLeanRow]:
    """One row a reference measurement of an epoch, in the order of the file.

    Raises
    ------
    ShapeError
        If a sigma is not above 0.
    """
    return [_row(occasion, reference, height_m) for reference in references]


def _row(occasion: Occasion, reference: ReferenceLean, height_m: float) -> ReferenceLeanRow:
    if reference.sigma <= 0.0:
        raise ShapeError(f"reference {reference.source!r} needs sigma above 0; got {reference.sigma}")
    lean = np.array([reference.lean_east, reference.lean_north])
    figures = tilt_parameters(lean, reference.sigma**2 * np.eye(2), height_m)
    if figures.tilt_sigma_deg is None or figures.deviation_sigma_m is None:
        raise ShapeError(f"reference {reference.source!r} has a sigma, and its tilt has none")
    return ReferenceLeanRow(
        structure=occasion.structure,
        epoch=occasion.epoch,
        epoch_time=datetime.fromisoformat(occasion.epoch_time),
        source=reference.source,
        lean_east=reference.lean_east,
        lean_north=reference.lean_north,
        sigma=reference.sigma,
        tilt_deg=figures.tilt_deg,
        tilt_sigma_deg=figures.tilt_sigma_deg,
        azimuth_deg=figures.azimuth_deg,
        azimuth_sigma_deg=figures.azimuth_sigma_deg,
        height_m=height_m,
        deviation_m=figures.deviation_m,
        deviation_sigma_m=figures.deviation_sigma_m,
    )
