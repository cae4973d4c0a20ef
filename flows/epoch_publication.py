"""Publish an epoch: its tables whole, then the catalog that people read."""

from dataclasses import replace
from typing import Final, cast

from flows.epoch_quality import coverage_of, outlook_of, pairs_of
from flows.epoch_work import EpochResult, EpochWork
from flows.map_steps import surface_map_of
from flows.outcome import EpochOutcome
from flows.placing_steps import registration_of
from storage.digests import text_sha256
from storage.identity import SCHEMA_VERSION
from storage.ledger import store_settings
from storage.records import EpochRow, ReferenceLeanRow, RemovalRow, SchemeComparisonRow, StationRow
from tasks.code_version import code_version
from tasks.epoch_tables import (
    EpochFacts,
    Home,
    ScanInput,
    epoch_row,
    removal_rows,
    scheme_rows,
    slice_rows,
)
from tasks.evaluation import compare_with_control
from tasks.exchange import rebuild
from tasks.parameter_rows import rows_of_outcomes
from tasks.plan import plan_occasion, plan_references, plan_standard
from tasks.preprocessing import Removal
from tasks.produced import Json
from tasks.publishing import EpochTables, publish, with_other_schemes
from tasks.quality_rows import told_of_thinning, with_outlook
from tasks.reference_rows import reference_rows
from tasks.scheme_comparison import EpochAxes, compare_schemes
from tasks.stages import fit_scheme_axis, fit_whole_surface, map_whole_surface, slice_shaft
from tasks.station_rows import station_rows, with_levels
from tasks.verdict_rows import verdict_rows

STAGES_OF_SCHEMES: Final = (slice_shaft, fit_scheme_axis, fit_whole_surface, map_whole_surface)
"""Which of them run depends on the schemes that were asked for; the rows of the others stay in the epoch."""


def publish_result(work: EpochWork, result: EpochResult) -> EpochOutcome:
    """Publish what the steps made; a failed scheme or station leaves the epoch degraded, not lost."""
    campaign = work.campaign
    store_settings(work.workspace, campaign.digest, campaign.filled_in_json())
    tables = _tables(work, result)
    result.notes += told_of_thinning(tables.removals, work.campaign.preprocessing.most_points)
    left_out: tuple[str, ...] = ()
    if work.partial:
        merged = with_other_schemes(work.workspace, tables, plan_standard(campaign, work.epoch))
        tables, left_out = merged.tables, merged.left_out
    _judge(work, result, tables)
    tables = replace(tables, scheme_comparison=_compared(work, tables))
    tables = replace(tables, epoch=_epoch_row(work, result, has_result=bool(tables.tilt)))
    publication = publish(work.workspace, tables)
    if publication.kept_because is not None:
        result.notes.append(publication.kept_because)
    elif left_out:
        result.notes.append(
            f"schemes {', '.join(left_out)} rested on other scans, poses or points and are left out; "
            "run without --scheme"
        )
    return EpochOutcome(
        work.epoch.id,
        tables.epoch.state,
        tuple(result.reasons),
        result.bad_input,
        notes=tuple(result.notes),
        storage_fault=work.epoch.id in work.calls.ledger.passing,
    )


def _judge(work: EpochWork, result: EpochResult, tables: EpochTables) -> None:
    """Say what of the schemes leaves the epoch without a result, without the one that counts, or uncompared."""
    primary = tuple(work.campaign.report.primary)
    for row in tables.schemes:
        if (row.scheme, row.method) == primary and row.state != "ok":
            result.reasons.append(f"the primary {'/'.join(primary)} gave no axis: {row.reason}")
    result.notes += [
        f"{'/'.join(primary)}: {row.warning}"
        for row in tables.tilt
        if (row.scheme, row.method) == primary and row.warning is not None
    ]
    if tables.schemes and not tables.tilt:
        first = tables.schemes[0]
        result.refuse(f"no scheme gave an axis; {first.scheme}/{first.method}: {first.reason}")
    missing = compare_with_control(tables.tilt, plan_standard(work.campaign, work.epoch)).control_missing
    if tables.tilt and missing is not None:
        result.notes.append(f"no relative errors: {missing}")


def _tables(work: EpochWork, result: EpochResult) -> EpochTables:
    home = Home(work.campaign.structure.id, work.epoch.id)
    scans = [scan.input for scan in result.scans]
    parameters = rows_of_outcomes(home, result.outcomes)
    return EpochTables(
        epoch=_epoch_row(work, result, has_result=bool(result.tilt)),
        stations=_stations(work, result, home, scans),
        pairs=pairs_of(work, result, home),
        removals=_removals(result, home),
        coverage=coverage_of(work, result, home),
        slices=[row for outcome in result.outcomes for row in slice_rows(home, outcome)],
        tilt=result.tilt,
        schemes=scheme_rows(home, result.outcomes),
        accuracy=result.accuracy,
        verdicts=verdict_rows(result.tilt, plan_standard(work.campaign, work.epoch)),
        reference_leans=_references(work),
        axis_parameters=parameters.parameters,
        axis_covariances=parameters.covariances,
        surface_map=surface_map_of(work, result, home),
    )


def _references(work: EpochWork) -> list[ReferenceLeanRow]:
    occasion = plan_occasion(work.campaign, work.epoch)
    return reference_rows(occasion, plan_references(work.epoch), work.campaign.structure.height_m)


def _compared(work: EpochWork, tables: EpochTables) -> list[SchemeComparisonRow]:
    """The schemes and references beside the primary, with how many slices are enough."""
    axes = EpochAxes(
        work.campaign.structure.id, work.epoch.id, tables.tilt, tables.slices, tables.reference_leans
    )
    return compare_schemes(axes, "/".join(work.campaign.report.primary))


def _epoch_row(work: EpochWork, result: EpochResult, *, has_result: bool) -> EpochRow:
    home = Home(work.campaign.structure.id, work.epoch.id)
    facts = _facts(work, result, has_result=has_result)
    return with_outlook(epoch_row(home, facts, [scan.input for scan in result.scans]), outlook_of(result))


def _facts(work: EpochWork, result: EpochResult, *, has_result: bool) -> EpochFacts:
    campaign = work.campaign
    ran = {row.code_version for row in work.calls.ledger.rows if row.epoch == work.epoch.id}
    versions = sorted(ran | {code_version(stage.fn) for stage in STAGES_OF_SCHEMES})
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
        has_result=has_result,
    )


def _stations(work: EpochWork, result: EpochResult, home: Home, scans: list[ScanInput]) -> list[StationRow]:
    registration = None
    if result.registration is not None and result.registration.refusal is None:
        registration = registration_of(work, result.registration)
    return with_levels(station_rows(home, scans, registration), result.levels, result.suspects)


def _removals(result: EpochResult, home: Home) -> list[RemovalRow]:
    if result.shaft is None or result.shaft.refusal is not None:
        return []
    counts = cast("list[Json]", result.shaft.facts["removed"])
    return removal_rows(home, [rebuild(Removal, count) for count in counts])
