"""Rows of a small made-up campaign, consistent enough for the contract's checks."""

import math
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from typing import Final

from storage.digests import text_sha256
from storage.ledger import append_run, store_settings
from storage.publish import publish_epoch
from storage.records import (
    AccuracyRow,
    AlarmEventRow,
    AxisCovarianceRow,
    AxisParameterRow,
    CoverageRow,
    EpochRow,
    PairRow,
    ReferenceLeanRow,
    RemovalRow,
    SchemeComparisonRow,
    SchemeRow,
    SliceRow,
    StageRunRow,
    StationRow,
    SurfaceMapRow,
    TiltRow,
    VerdictRow,
)
from storage.workspace import Workspace
from tests.storage.samples import bare_row

STRUCTURE = "chimney-01"
SETTINGS = '{"structure": "chimney-01"}'
START = datetime(2025, 3, 14, 6, 0, 0, 123456, tzinfo=timezone(timedelta(hours=8)))
HEIGHT_M = 102.0
N_SLICES = 5


def epoch_time(number: int) -> datetime:
    return START + timedelta(days=365 * number)


def epoch_row(epoch: str, number: int = 0, **changed: object) -> EpochRow:
    row = EpochRow(
        structure=STRUCTURE,
        epoch=epoch,
        epoch_time=epoch_time(number),
        run="run-1",
        state="ok",
        reason=None,
        n_stations=2,
        n_stations_used=2,
        n_points_in=100_000,
        n_points_used=40_000,
        is_reference=number == 0,
        height_m=HEIGHT_M,
        campaign_digest=text_sha256(SETTINGS),
        code_version="c0de",
        schema_version=1,
    )
    return replace(row, **changed)


LEAN_COVARIANCE: Final = {"lean_cov_ee": 4e-10, "lean_cov_en": 1e-10, "lean_cov_nn": 9e-10}
POINT_COVARIANCE: Final = {"point_cov_ee": 1e-10, "point_cov_en": 0.0, "point_cov_nn": 1e-10}


def tilt_row(
    epoch: str, number: int = 0, lean: tuple[float, float] = (0.007, -0.0057), **changed: object
) -> TiltRow:
    lean_east, lean_north = lean
    size = math.hypot(lean_east, lean_north)
    d_up = 1.0 / math.hypot(lean_east, lean_north, 1.0)
    row = TiltRow(
        structure=STRUCTURE,
        epoch=epoch,
        epoch_time=epoch_time(number),
        scheme="A",
        method="paper",
        n_slices=N_SLICES,
        n_centres=N_SLICES,
        base_east_m=0.01,
        base_north_m=-0.02,
        d_east=lean_east * d_up,
        d_north=lean_north * d_up,
        d_up=d_up,
        lean_east=lean_east,
        lean_north=lean_north,
        **LEAN_COVARIANCE,
        **POINT_COVARIANCE,
        tilt_deg=math.degrees(math.atan(size)),
        tilt_sigma_deg=0.001,
        azimuth_deg=math.degrees(math.atan2(lean_east, lean_north)) % 360.0,
        azimuth_sigma_deg=0.1,
        beta_deg=math.degrees(math.acos(lean_east * d_up)),
        verticality_permille=1000.0 * size,
        height_m=HEIGHT_M,
        deviation_m=HEIGHT_M * size,
        deviation_sigma_m=0.002,
        allowable_m=None,
        verdict="no limit",
        verdict_reason="no table",
        iterations=7,
        update_weight_ratio_pct=0.0,
        n_effective=4.9,
        mean_deviation_m=0.001,
        rmse_m=0.0012,
        bending_m=None,
    )
    return replace(row, **changed)


def slice_row(epoch: str, index: int) -> SliceRow:
    return SliceRow(
        structure=STRUCTURE,
        epoch=epoch,
        scheme="A",
        method="paper",
        slice_index=index,
        z_m=2.0 + 25.0 * index,
        thickness_m=0.01,
        n_points=200,
        n_points_fit=None,
        center_east_m=0.007 * index / 3.0,
        center_north_m=-0.1,
        radius_m=4.0,
        sigma_center_m=0.0003,
        center_cov_ee=9e-8,
        center_cov_en=0.0,
        center_cov_nn=9e-8,
        rmse_m=0.004,
        arc_coverage_deg=360.0,
        state="ok",
        reason=None,
        weight=1.0,
        residual_m=0.001,
    )


def station_row(epoch: str, station: str = "ST01") -> StationRow:
    return StationRow(
        structure=STRUCTURE,
        epoch=epoch,
        station=station,
        scan_digest="5ca0",
        n_points=50_000,
        position_east_m=231.4,
        position_north_m=-12.9,
        position_up_m=1.61,
        heading_deg=271.3,
        heading_correction_deg=0.02,
        level_east_deg=0.0001,
        level_north_deg=-0.0001,
        overlap=0.6,
        rmse_m=0.004,
        sigma_heading_deg=0.001,
        sigma_level_deg=0.0005,
        sigma_position_m=0.002,
        weakest_direction=None,
        state="ok",
        reason=None,
    )


def pair_row(epoch: str) -> PairRow:
    return PairRow(STRUCTURE, epoch, "ST01", "ST02", 0.4, 1200, 0.006, 0.008, 0.006, None, None)


def coverage_row(epoch: str, azimuth_deg: float, station: str | None = None) -> CoverageRow:
    return CoverageRow(
        structure=STRUCTURE,
        epoch=epoch,
        z_low_m=2.0,
        z_high_m=7.0,
        azimuth_low_deg=azimuth_deg,
        azimuth_high_deg=azimuth_deg + 10.0,
        n_points=0 if station is None else 300,
        n_stations=0 if station is None else 1,
        station=station,
        off_surface_m=None if station is None else 0.001,
    )


def surface_map_row(epoch: str, azimuth_deg: float, deviation_m: float | None = None) -> SurfaceMapRow:
    seen = deviation_m is not None
    return SurfaceMapRow(
        structure=STRUCTURE,
        epoch=epoch,
        z_low_m=2.0,
        z_high_m=4.5,
        z_m=3.25,
        azimuth_deg=azimuth_deg,
        n_points=150 if seen else 0,
        radius_m=4.6,
        deviation_m=deviation_m,
        deviation_sigma_m=0.0003 if seen else None,
        placing_sigma_m=0.0004 if seen else None,
        design_deviation_m=None,
        design_sigma_m=None,
    )


def scheme_row(epoch: str) -> SchemeRow:
    return SchemeRow(
        STRUCTURE, epoch, "A", "paper", 1.0, 0.01, "kasa", "irls", N_SLICES, N_SLICES, "ok", None
    )


def accuracy_row(epoch: str) -> AccuracyRow:
    return AccuracyRow(STRUCTURE, epoch, "A", "paper", "F/paper", "tilt_deg", 0.5172, 0.5175, -0.0003, -0.058)


def reference_lean_row(epoch: str, number: int = 0, **changed: object) -> ReferenceLeanRow:
    row = ReferenceLeanRow(
        structure=STRUCTURE,
        epoch=epoch,
        epoch_time=epoch_time(number),
        source="total station",
        lean_east=0.00702,
        lean_north=-0.00571,
        sigma=0.00005,
        tilt_deg=0.5185,
        tilt_sigma_deg=0.0029,
        azimuth_deg=129.1,
        azimuth_sigma_deg=0.32,
        height_m=HEIGHT_M,
        deviation_m=0.923,
        deviation_sigma_m=0.0051,
    )
    return replace(row, **changed)


def scheme_comparison_row(epoch: str) -> SchemeComparisonRow:
    row = bare_row(SchemeComparisonRow)
    return replace(row, structure=STRUCTURE, epoch=epoch, compared="A/paper", against="A/robust")


def alarm_event_row(event: str, action: str = "raised", hours: int = 0) -> AlarmEventRow:
    return AlarmEventRow(
        event=event,
        structure=STRUCTURE,
        alarm="movement-e0",
        epoch="e0",
        rule="movement",
        severity="warning",
        action=action,
        happened_at=epoch_time(0) + timedelta(hours=hours),
        value=0.021,
        limit_value=0.02,
        person=None if action == "raised" else "A. Surveyor",
        note=None if action == "raised" else "seen",
    )


def axis_parameter_rows(tilt: TiltRow) -> list[AxisParameterRow]:
    """The straight axis of a row of tilt, its base known to 3 mm."""
    names = ("base_east", "base_north", "lean_east", "lean_north")
    values = (tilt.base_east_m, tilt.base_north_m, tilt.lean_east, tilt.lean_north)
    sigmas = (0.003, 0.003, math.sqrt(tilt.lean_cov_ee or 0.0), math.sqrt(tilt.lean_cov_nn or 0.0))
    return [
        AxisParameterRow(STRUCTURE, tilt.epoch, tilt.scheme, tilt.method, name, place, value, sigma)
        for place, (name, value, sigma) in enumerate(zip(names, values, sigmas, strict=True))
    ]


def axis_covariance_rows(tilt: TiltRow) -> list[AxisCovarianceRow]:
    """Covariances of these parameters; the base and the lean are independent."""
    covariances = {
        (0, 0): 9e-6,
        (1, 1): 9e-6,
        (2, 2): tilt.lean_cov_ee or 0.0,
        (2, 3): tilt.lean_cov_en or 0.0,
        (3, 3): tilt.lean_cov_nn or 0.0,
    }
    home = (STRUCTURE, tilt.epoch, tilt.scheme, tilt.method)
    return [
        AxisCovarianceRow(*home, i, j, covariances.get((i, j), 0.0), 0.0, 0.0)
        for i in range(4)
        for j in range(i, 4)
    ]


def verdict_row(epoch: str) -> VerdictRow:
    row = bare_row(VerdictRow)
    return replace(
        row,
        structure=STRUCTURE,
        epoch=epoch,
        scheme="A",
        method="paper",
        limit_name="own points",
        is_primary=True,
    )


def stage_run_row(run: str, epoch: str) -> StageRunRow:
    return StageRunRow(
        run=run,
        structure=STRUCTURE,
        epoch=epoch,
        stage="slicing A/paper",
        state="cached",
        outcome="ok",
        reason=None,
        started_at=epoch_time(0),
        seconds=None,
        points=40_000,
        peak_rss_mb=None,
        code_version="c0de",
        cache_key="slicing-sha256",
    )


def epoch_tables(
    epoch: str, number: int = 0, lean: tuple[float, float] = (0.007, -0.0057), **changed: object
) -> dict[str, list[object]]:
    """All tables of an epoch; ``changed`` goes to its row in ``epochs``."""
    return {
        "epochs": [epoch_row(epoch, number, **changed)],
        "stations": [station_row(epoch, "ST01"), station_row(epoch, "ST02")],
        "pairs": [pair_row(epoch)],
        "removals": [RemovalRow(STRUCTURE, epoch, 0, "ground", 60_000)],
        "coverage": [coverage_row(epoch, 0.0, "ST01"), coverage_row(epoch, 10.0)],
        "surface_map": [surface_map_row(epoch, 5.0, 0.001 + 0.02 * number), surface_map_row(epoch, 15.0)],
        "slices": [slice_row(epoch, index) for index in range(N_SLICES)],
        "tilt": [tilt_row(epoch, number, lean)],
        "schemes": [scheme_row(epoch)],
        "accuracy": [accuracy_row(epoch)],
        "reference_leans": [reference_lean_row(epoch, number)],
        "scheme_comparison": [scheme_comparison_row(epoch)],
        "axis_parameters": axis_parameter_rows(tilt_row(epoch, number, lean)),
        "axis_covariances": axis_covariance_rows(tilt_row(epoch, number, lean)),
        "verdicts": [verdict_row(epoch)],
    }


def fill(ws: Workspace, n_epochs: int = 2) -> None:
    """Publish a campaign of some epochs with its ledger and settings."""
    store_settings(ws, text_sha256(SETTINGS), SETTINGS)
    for number in range(n_epochs):
        epoch = f"e{number}"
        publish_epoch(ws, STRUCTURE, epoch, epoch_tables(epoch, number, (0.007 + 1e-4 * number, -0.0057)))
    append_run(ws, "run-1", STRUCTURE, [stage_run_row("run-1", f"e{number}") for number in range(n_epochs)])
