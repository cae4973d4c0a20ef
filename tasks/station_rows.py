"""The rows of an epoch's stations: how each was placed, or why it was not used."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from storage.records import REGISTERED, StationRow
from tasks.conventions import ARCSEC_RAD
from tasks.epoch_tables import Home, ScanInput
from tasks.level_check import LevelCheck
from tasks.registration import PoseDiagnosis, Registration, StationPose


def station_rows(
    home: Home, scans: Sequence[ScanInput], registration: Registration | None
) -> list[StationRow]:
    """One row a station of the campaign file, those that were refused or left out too."""
    placed: dict[str, tuple[StationPose, PoseDiagnosis]] = {}
    if registration is not None:
        pairs = zip(registration.poses, registration.diagnoses, strict=True)
        placed = {pose.station: (pose, diagnosis) for pose, diagnosis in pairs}
    return [
        _placed_row(home, scan, *placed[scan.station])
        if scan.station in placed and scan.refusal is None
        else _unplaced_row(home, scan)
        for scan in scans
    ]


def with_levels(
    rows: Sequence[StationRow], checks: Mapping[str, LevelCheck], suspects: Mapping[str, str]
) -> list[StationRow]:
    """Put the level checks of the stations into their rows; those that are suspect, with the reason, are marked."""
    return [
        _with_level(row, checks[row.station], suspects.get(row.station)) if row.station in checks else row
        for row in rows
    ]


def _with_level(row: StationRow, check: LevelCheck, suspicion: str | None) -> StationRow:
    if check.lean_east is None or check.lean_north is None:
        return row
    lean_arcsec = float(np.hypot(check.lean_east, check.lean_north) / ARCSEC_RAD)
    marked = replace(row, level_check_arcsec=lean_arcsec, level_check_chi2=check.chi2)
    if suspicion is None:
        return marked
    return replace(marked, state="suspect", reason="; ".join(filter(None, [row.reason, suspicion])))


def _placed_row(home: Home, scan: ScanInput, pose: StationPose, diagnosis: PoseDiagnosis) -> StationRow:
    east, north, up = (float(value) for value in pose.position_m)
    row = StationRow(
        structure=home.structure,
        epoch=home.epoch,
        station=scan.station,
        scan_digest=scan.digest,
        n_points=scan.n_points,
        position_east_m=east,
        position_north_m=north,
        position_up_m=up,
        heading_deg=float(np.degrees(diagnosis.heading_rad)),
        heading_correction_deg=_degrees(diagnosis.heading_correction_rad),
        level_east_deg=float(np.degrees(diagnosis.level_east_rad)),
        level_north_deg=float(np.degrees(diagnosis.level_north_rad)),
        overlap=diagnosis.overlap,
        rmse_m=diagnosis.rmse_m,
        sigma_heading_deg=float(np.degrees(diagnosis.sigma_heading_rad)),
        sigma_level_deg=float(np.degrees(diagnosis.sigma_level_rad)),
        sigma_position_m=diagnosis.sigma_position_m,
        weakest_direction=diagnosis.weakest_direction,
        state=diagnosis.state,
        reason=diagnosis.reason,
        notes="; ".join(scan.notes) or None,
        start=diagnosis.start,
        **_corrections(diagnosis),
    )
    return _without_pose(row) if diagnosis.start == REGISTERED else row


NO_POSE: Final[Mapping[str, Any]] = dict.fromkeys(
    (
        "position_east_m",
        "position_north_m",
        "position_up_m",
        "heading_deg",
        "heading_correction_deg",
        "level_east_deg",
        "level_north_deg",
    )
)
"""Columns of a station of which no pose was found."""


def _without_pose(row: StationRow) -> StationRow:
    """A cloud that came registered has no scanner of which anything was adjusted; its sigmas are those that are stated."""
    return replace(row, **NO_POSE)


CORRECTIONS = ("correction_east_m", "correction_north_m", "correction_up_m")

NORMALISED = (
    "normalised_level_east",
    "normalised_level_north",
    "normalised_heading",
    "normalised_east",
    "normalised_north",
    "normalised_up",
)
"""In the order of ``tasks.conventions``."""


def _corrections(diagnosis: PoseDiagnosis) -> dict[str, float | None]:
    """Columns of the correction of the stated position, and of all corrections by their standard deviations."""
    shift_m = [None] * 3 if diagnosis.correction_m is None else diagnosis.correction_m.tolist()
    return {
        **dict(zip(CORRECTIONS, shift_m, strict=True)),
        **dict(zip(NORMALISED, diagnosis.normalised, strict=True)),
    }


def _degrees(angle_rad: float | None) -> float | None:
    return None if angle_rad is None else float(np.degrees(angle_rad))


def _unplaced_row(home: Home, scan: ScanInput) -> StationRow:
    return StationRow(
        structure=home.structure,
        epoch=home.epoch,
        station=scan.station,
        scan_digest=scan.digest,
        n_points=scan.n_points,
        **NO_POSE,
        overlap=None,
        rmse_m=None,
        sigma_heading_deg=None,
        sigma_level_deg=None,
        sigma_position_m=None,
        weakest_direction=None,
        state="failed",
        reason=scan.refusal or "not placed, because the epoch failed",
        notes="; ".join(scan.notes) or None,
    )
