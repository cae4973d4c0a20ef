"""The rows that say how good an epoch is: its pairs of stations, the coverage of the shaft, the outlook."""

from collections.abc import Sequence
from dataclasses import replace

from storage.records import (
    CoverageCell,
    CoverageRow,
    EpochRow,
    PairRow,
    RemovalRow,
    SurfaceMapCell,
    SurfaceMapRow,
)
from tasks.conventions import ARCSEC_RAD
from tasks.epoch_quality import Outlook
from tasks.epoch_tables import Home
from tasks.preprocessing import KEPT, NOT_NEEDED, REASONS
from tasks.registration import PairDiagnosis, Registration


def pair_rows(home: Home, registration: Registration) -> list[PairRow]:
    """One row a pair of stations that was compared, in the order of the registration."""
    return [_pair_row(home, pair) for pair in registration.pairs]


def coverage_rows(home: Home, cells: Sequence[CoverageCell]) -> list[CoverageRow]:
    """One row a band and sector of the shaft, those without points too."""
    names = tuple(CoverageCell.__dataclass_fields__)
    return [
        CoverageRow(
            structure=home.structure, epoch=home.epoch, **{name: getattr(cell, name) for name in names}
        )
        for cell in cells
    ]


def surface_map_rows(home: Home, cells: Sequence[SurfaceMapCell]) -> list[SurfaceMapRow]:
    """One row a band and sector of the shaft, those without points too."""
    names = tuple(SurfaceMapCell.__dataclass_fields__)
    return [
        SurfaceMapRow(
            structure=home.structure, epoch=home.epoch, **{name: getattr(cell, name) for name in names}
        )
        for cell in cells
    ]


def with_outlook(row: EpochRow, outlook: Outlook | None) -> EpochRow:
    """Put coverage and the next station into the row of an epoch; None where the shaft was not found."""
    if outlook is None:
        return row
    suggested = outlook.next_station
    if suggested is None:
        return replace(row, coverage_deg=outlook.covered_deg)
    return replace(
        row,
        coverage_deg=outlook.covered_deg,
        stations_sigma_arcsec=suggested.sigma_now_arcsec,
        next_station_azimuth_deg=suggested.azimuth_deg,
        next_station_sigma_arcsec=suggested.sigma_then_arcsec,
    )


def _pair_row(home: Home, pair: PairDiagnosis) -> PairRow:
    return PairRow(
        structure=home.structure,
        epoch=home.epoch,
        station=pair.station,
        other=pair.other,
        overlap=pair.overlap,
        n_matches=pair.n_matches,
        rmse_m=pair.rmse_m,
        rmse_shaft_m=pair.rmse_shaft_m,
        rmse_background_m=pair.rmse_background_m,
        closure_m=pair.closure_m,
        closure_arcsec=None if pair.closure_rad is None else pair.closure_rad / ARCSEC_RAD,
    )


def told_of_thinning(removals: Sequence[RemovalRow], most_points: int) -> list[str]:
    """Say in a line that not all points on the shaft are used, where it is so."""
    counts = {row.reason: row.n_points for row in removals}
    left_out, used = counts.get(NOT_NEEDED, 0), counts.get(REASONS[KEPT], 0)
    if not left_out:
        return []
    return [
        f"of some {left_out + used:,} points on the shaft an even sample of {used:,} is used "
        f"([preprocessing] most_points = {most_points})"
    ]
