"""The tests of what changed between two epochs, as rows."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from storage.records import ChangeTestRow, CoverageRow
from tasks.change import FrameOf, SeenSurface, likeness
from tasks.change_basis import AxisRecord, Kinship
from tasks.change_quantities import Quantity, changed_quantities
from tasks.epoch_record import EpochRecord, Way

FULL_ARC_DEG: Final = 270.0
"""With less of the circumference in one of the epochs an arc cannot tell a shift from a wider radius."""


def change_test_rows_of(
    before: EpochRecord, after: EpochRecord, code_version: str, reference: str | None
) -> list[ChangeTestRow]:
    """Test every quantity under every scheme and method that both epochs have.

    ``reference`` is the epoch whose frame others may be tied to by stable surroundings.
    """
    kinship = _kinship(before, after, reference)
    return [
        _row(before, after, way, found, code_version)
        for way in after.tilt
        if way in before.tilt
        for found in changed_quantities(_axis(before, way), _axis(after, way), kinship)
    ]


def _kinship(before: EpochRecord, after: EpochRecord, reference: str | None) -> Kinship:
    holders: dict[str | None, FrameOf] = {after.epoch.epoch: "after", before.epoch.epoch: "before"}
    arcs = [one.epoch.coverage_deg for one in (before, after)]
    return Kinship(
        alike=likeness(_seen(before.coverage), _seen(after.coverage)),
        frame_of=holders.get(reference),
        partial=any(arc is not None and arc < FULL_ARC_DEG for arc in arcs),
        fewest_stations=min(one.epoch.n_stations_used for one in (before, after)),
    )


def _seen(cells: Sequence[CoverageRow]) -> SeenSurface:
    return SeenSurface(
        z_m=np.array([(cell.z_low_m + cell.z_high_m) / 2.0 for cell in cells]),
        azimuth_rad=np.radians([(cell.azimuth_low_deg + cell.azimuth_high_deg) / 2.0 for cell in cells]),
        n_points=np.array([cell.n_points for cell in cells], dtype=np.float64),
    )


def _axis(record: EpochRecord, way: Way) -> AxisRecord:
    return AxisRecord(record.tilt[way], record.parameters.get(way), record.slices.get(way, ()))


def _row(
    before: EpochRecord, after: EpochRecord, way: Way, found: Quantity, code_version: str
) -> ChangeTestRow:
    d, C = found.difference, found.covariance
    return ChangeTestRow(
        structure=after.epoch.structure,
        epoch=after.epoch.epoch,
        epoch_time=after.epoch.epoch_time,
        reference_epoch=before.epoch.epoch,
        reference_time=before.epoch.epoch_time,
        scheme=way[0],
        method=way[1],
        quantity=found.quantity,
        basis=found.basis,
        d_east=None if d is None else float(d[0]),
        d_north=None if d is None else float(d[1]),
        d_cov_ee=None if C is None else float(C[0, 0]),
        d_cov_en=None if C is None else float(C[0, 1]),
        d_cov_nn=None if C is None else float(C[1, 1]),
        size_m=found.size_m,
        sigma_m=found.sigma_m,
        height_m=after.tilt[way].height_m,
        statistic=found.statistic,
        freedom=found.freedom,
        p_value=found.p_value,
        significant=found.significant,
        smallest_detectable_m=found.smallest_detectable_m,
        run=after.epoch.run,
        reference_run=before.epoch.run,
        code_version=code_version,
        z_low_m=found.z_low_m,
        z_high_m=found.z_high_m,
        reason=found.reason,
    )
