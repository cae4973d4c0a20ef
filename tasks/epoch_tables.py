"""The rows of an epoch's tables, from what its stages produced."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from storage.artifacts import ArtifactRef
from storage.records import (
    EpochRow,
    RemovalRow,
    SchemeRow,
    SectionFit,
    SliceRow,
    StationRow,
)
from tasks.conventions import ARCSEC_RAD
from tasks.lean import Lean
from tasks.level_check import LevelCheck, worst_suspect
from tasks.methods import Method
from tasks.preprocessing import Removal
from tasks.registration import PoseDiagnosis, Registration, StationPose
from tasks.slicing import SlicingScheme


@dataclass(frozen=True, slots=True)
class Home:
    """Structure and epoch that rows belong to."""

    structure: str
    epoch: str


@dataclass(frozen=True, slots=True)
class ScanInput:
    """What became of one scan file: its digest and count, or why it was refused."""

    station: str
    digest: str | None
    n_points: int | None
    refusal: str | None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SchemeOutcome:
    """What became of one scheme and method: its slices, and its axis or why there is none."""

    scheme: SlicingScheme
    method: Method
    sections: tuple[SectionFit, ...]
    lean: Lean | None
    reason: str | None
    lean_ref: ArtifactRef | None = None


def station_rows(
    home: Home, scans: Sequence[ScanInput], registration: Registration | None
) -> list[StationRow]:
    """One row a station of the campaign file, those that were refused too."""
    placed: dict[str, tuple[StationPose, PoseDiagnosis]] = {}
    if registration is not None:
        pairs = zip(registration.poses, registration.diagnoses, strict=True)
        placed = {pose.station: (pose, diagnosis) for pose, diagnosis in pairs}
    return [
        _placed_row(home, scan, *placed[scan.station])
        if scan.station in placed
        else _unplaced_row(home, scan)
        for scan in scans
    ]


def with_levels(
    rows: Sequence[StationRow], stations: Sequence[str], checks: Sequence[LevelCheck]
) -> list[StationRow]:
    """Put the level checks of the stations that saw the shaft into their rows; the worst becomes suspect."""
    found = dict(zip(stations, checks, strict=True))
    worst = worst_suspect(checks)
    bad = None if worst is None else stations[worst]
    return [
        _with_level(row, found[row.station], suspect=row.station == bad) if row.station in found else row
        for row in rows
    ]


def _with_level(row: StationRow, check: LevelCheck, *, suspect: bool) -> StationRow:
    if check.lean_east is None or check.lean_north is None:
        return row
    lean_arcsec = float(np.hypot(check.lean_east, check.lean_north) / ARCSEC_RAD)
    marked = replace(row, level_check_arcsec=lean_arcsec, level_check_chi2=check.chi2)
    if not suspect:
        return marked
    why = f"its side of the shaft leans {lean_arcsec:.0f} arc seconds against the common one"
    return replace(marked, state="suspect", reason="; ".join(filter(None, [row.reason, why])))


def removal_rows(home: Home, counts: Sequence[Removal]) -> list[RemovalRow]:
    """One row a reason for which points were removed, in order; the reason "kept" counts those that remained."""
    return [
        RemovalRow(home.structure, home.epoch, i, count.reason, count.n_points)
        for i, count in enumerate(counts)
    ]


def scheme_rows(home: Home, outcomes: Sequence[SchemeOutcome]) -> list[SchemeRow]:
    """One row a scheme and method, those without an axis too."""
    return [
        SchemeRow(
            structure=home.structure,
            epoch=home.epoch,
            scheme=outcome.scheme.name,
            method=outcome.method.name,
            interval_m=outcome.scheme.interval_m,
            thickness_m=outcome.method.thickness_m,
            contour=outcome.method.contour,
            axis=outcome.method.axis,
            n_slices=len(outcome.sections),
            n_centres=sum(section.state == "ok" for section in outcome.sections),
            state="ok" if outcome.lean is not None else "failed",
            reason=outcome.reason,
        )
        for outcome in outcomes
    ]


def slice_rows(home: Home, outcome: SchemeOutcome) -> list[SliceRow]:
    """One row a slice with its part in the axis, the failed ones too."""
    weights, residuals = iter(()), iter(())
    if outcome.lean is not None:
        axis = outcome.lean.axis
        weights = iter(axis.weights.tolist())
        residuals = iter(axis.residuals_m.tolist() if axis.residuals_m is not None else ())
    return [
        SliceRow(
            structure=home.structure,
            epoch=home.epoch,
            scheme=outcome.scheme.name,
            method=outcome.method.name,
            **{name: getattr(section, name) for name in SectionFit.__dataclass_fields__},
            weight=next(weights, None) if section.state == "ok" else None,
            residual_m=next(residuals, None) if section.state == "ok" else None,
        )
        for section in outcome.sections
    ]


@dataclass(frozen=True, slots=True)
class EpochFacts:
    """What is said of an epoch as a whole; ``reasons`` are those why its state is not ok."""

    epoch_time: datetime
    run: str
    is_reference: bool
    height_m: float
    n_points_used: int
    campaign_digest: str
    code_version: str
    schema_version: int
    reasons: tuple[str, ...]
    has_result: bool


def epoch_row(home: Home, facts: EpochFacts, scans: Sequence[ScanInput]) -> EpochRow:
    """The row of an epoch: ok, degraded where something failed and the rest was processed, or failed."""
    state = "failed" if not facts.has_result else "degraded" if facts.reasons else "ok"
    return EpochRow(
        structure=home.structure,
        epoch=home.epoch,
        epoch_time=facts.epoch_time,
        run=facts.run,
        state=state,
        reason="; ".join(facts.reasons) or None,
        n_stations=len(scans),
        n_stations_used=sum(scan.refusal is None for scan in scans),
        n_points_in=sum(scan.n_points or 0 for scan in scans),
        n_points_used=facts.n_points_used,
        is_reference=facts.is_reference,
        height_m=facts.height_m,
        campaign_digest=facts.campaign_digest,
        code_version=facts.code_version,
        schema_version=facts.schema_version,
    )


def _placed_row(home: Home, scan: ScanInput, pose: StationPose, diagnosis: PoseDiagnosis) -> StationRow:
    east, north, up = (float(value) for value in pose.position_m)
    return StationRow(
        structure=home.structure,
        epoch=home.epoch,
        station=scan.station,
        scan_digest=scan.digest,
        n_points=scan.n_points,
        position_east_m=east,
        position_north_m=north,
        position_up_m=up,
        heading_deg=float(np.degrees(diagnosis.heading_rad)),
        heading_correction_deg=None
        if diagnosis.heading_correction_rad is None
        else float(np.degrees(diagnosis.heading_correction_rad)),
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
    )


def _unplaced_row(home: Home, scan: ScanInput) -> StationRow:
    return StationRow(
        structure=home.structure,
        epoch=home.epoch,
        station=scan.station,
        scan_digest=scan.digest,
        n_points=scan.n_points,
        position_east_m=None,
        position_north_m=None,
        position_up_m=None,
        heading_deg=None,
        heading_correction_deg=None,
        level_east_deg=None,
        level_north_deg=None,
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
