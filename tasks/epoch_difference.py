"""The difference of any two epochs of a structure, by scheme and by reference measurement, with its significance."""

import math
from dataclasses import dataclass

from storage.errors import StorageError
from storage.records import ChangeTestRow, ReferenceLeanRow
from storage.views import epoch_rows, reference_lean_rows
from storage.workspace import Workspace
from tasks.accuracy import SIGNIFICANT_P
from tasks.change_rows import change_test_rows_of
from tasks.code_version import code_version
from tasks.epoch_record import load_epoch_record, reference_epoch
from tasks.geometry.plane_vectors import DETECTABLE_FACTOR


def epoch_tests(workspace: Workspace, structure: str, epoch: str, reference: str) -> list[ChangeTestRow]:
    """Compare two epochs, quantity by quantity, under every scheme and method that both have.

    What the epochs have in common is cancelled: the form of the wall as far as both saw the same of it, and the frame that
    stable surroundings brought along.

    Raises
    ------
    StorageError
        If the catalog cannot be read, or one of the epochs is not stored.
    """
    rows = {row.epoch: row for row in epoch_rows(workspace, structure)}
    for name in (epoch, reference):
        if name not in rows:
            raise StorageError(f"epoch {name} of {structure} is not stored yet; `tiltwatch run` processes it")
    counted_from = reference_epoch(list(rows.values()))
    return change_test_rows_of(
        load_epoch_record(workspace, rows[reference]),
        load_epoch_record(workspace, rows[epoch]),
        code_version(change_test_rows_of),
        None if counted_from is None else counted_from.epoch,
    )


@dataclass(frozen=True, slots=True)
class ReferenceChange:
    """Difference of the leans that one source measured in two epochs; as in the view ``changes``, metres at height_m."""

    source: str
    height_m: float
    d_lean_east: float
    d_lean_north: float
    d_cov: float
    d_top_m: float
    sigma_top_m: float
    p_value: float
    significant: bool
    smallest_detectable_m: float


def reference_differences(
    workspace: Workspace, structure: str, epoch: str, reference: str
) -> list[ReferenceChange]:
    """Compare two epochs as others measured them, by every source that measured both.

    The measurements of two epochs are taken as independent: their covariances add up.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    before = {row.source: row for row in reference_lean_rows(workspace, structure, reference)}
    after = reference_lean_rows(workspace, structure, epoch)
    return [_reference_change(row, base) for row in after if (base := before.get(row.source))]


def _reference_change(later: ReferenceLeanRow, base: ReferenceLeanRow) -> ReferenceChange:
    variance, height_m = later.sigma**2 + base.sigma**2, later.height_m
    east, north = later.lean_east - base.lean_east, later.lean_north - base.lean_north
    sigma = math.sqrt(variance)
    p_value = math.exp(-(east**2 + north**2) / variance / 2.0)
    return ReferenceChange(
        source=later.source,
        height_m=height_m,
        d_lean_east=east,
        d_lean_north=north,
        d_cov=variance,
        d_top_m=height_m * math.hypot(east, north),
        sigma_top_m=height_m * sigma,
        p_value=p_value,
        significant=p_value < SIGNIFICANT_P,
        smallest_detectable_m=height_m * DETECTABLE_FACTOR * sigma,
    )
