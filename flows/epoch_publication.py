"""Publish an epoch: its tables whole, then the catalog that people read."""

from typing import cast

from flows.epoch_steps import registration_of
from flows.epoch_work import EpochResult, EpochWork
from flows.outcome import EpochOutcome
from storage.digests import text_sha256
from storage.ledger import store_settings
from storage.records import RemovalRow, StationRow
from storage.workspace import SCHEMA_VERSION
from tasks.epoch_tables import (
    EpochFacts,
    Home,
    ScanInput,
    epoch_row,
    removal_rows,
    scheme_rows,
    slice_rows,
    station_rows,
)
from tasks.exchange import rebuild
from tasks.preprocessing import Removal
from tasks.produced import Json
from tasks.publishing import EpochTables, publish, with_other_schemes


def publish_result(work: EpochWork, result: EpochResult) -> EpochOutcome:
    """Publish what the steps made; a failed scheme or station leaves the epoch degraded, not lost."""
    campaign = work.campaign
    store_settings(work.workspace, campaign.digest, campaign.filled_in_json())
    tables = _tables(work, result)
    if work.partial:
        tables = with_other_schemes(work.workspace, tables)
    publication = publish(work.workspace, tables)
    notes = [*result.notes, *([publication.kept_because] if publication.kept_because else [])]
    return EpochOutcome(
        work.epoch.id, tables.epoch.state, tuple(result.reasons), result.bad_input, notes=tuple(notes)
    )


def _tables(work: EpochWork, result: EpochResult) -> EpochTables:
    home = Home(work.campaign.structure.id, work.epoch.id)
    scans = [scan.input for scan in result.scans]
    return EpochTables(
        epoch=epoch_row(home, _facts(work, result), scans),
        stations=_stations(work, result, home, scans),
        removals=_removals(result, home),
        slices=[row for outcome in result.outcomes for row in slice_rows(home, outcome)],
        tilt=result.tilt,
        schemes=scheme_rows(home, result.outcomes),
        accuracy=result.accuracy,
    )


def _facts(work: EpochWork, result: EpochResult) -> EpochFacts:
    campaign = work.campaign
    versions = sorted({row.code_version for row in work.calls.ledger.rows if row.epoch == work.epoch.id})
    used = result.shaft.facts.get("n_points_used") if result.shaft is not None else None
    return EpochFacts(
        epoch_time=work.epoch.time,
        run=work.calls.ledger.run,
        is_reference=campaign.reference_epoch.id == work.epoch.id,
        height_m=campaign.structure.height_m,
        n_points_used=used if isinstance(used, int) else 0,
        campaign_digest=campaign.digest,
        code_version=text_sha256("\n".join(versions)),
        schema_version=SCHEMA_VERSION,
        reasons=tuple(result.reasons),
        has_result=bool(result.tilt),
    )


def _stations(work: EpochWork, result: EpochResult, home: Home, scans: list[ScanInput]) -> list[StationRow]:
    registration = None
    if result.registration is not None and result.registration.refusal is None:
        registration = registration_of(work, result.registration)
    return station_rows(home, scans, registration)


def _removals(result: EpochResult, home: Home) -> list[RemovalRow]:
    if result.shaft is None or result.shaft.refusal is not None:
        return []
    counts = cast("list[Json]", result.shaft.facts["removed"])
    return removal_rows(home, [rebuild(Removal, count) for count in counts])
