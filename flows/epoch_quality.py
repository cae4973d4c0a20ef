"""Rate what the stations of an epoch saw of the shaft; nothing of the lean depends on it."""

from flows.epoch_work import EpochResult, EpochWork
from flows.placing_steps import registration_of
from flows.stage_calls import Pending, artifact_of
from storage.artifacts import get_rows
from storage.records import CoverageCell, CoverageRow, PairRow
from tasks.epoch_quality import Outlook
from tasks.epoch_tables import Home
from tasks.exchange import plain, rebuild
from tasks.plan import plan_sigmas
from tasks.quality_rows import coverage_rows, pair_rows
from tasks.stages import rate_coverage


def ask_for_coverage(work: EpochWork, result: EpochResult) -> Pending | None:
    """Count who saw which part of the shaft, and find where one more station would help most; beside the schemes."""
    if result.shaft is None or result.shaft.refusal is not None or result.registration is None:
        return None
    return work.calls.submit(
        rate_coverage,
        "coverage",
        shaft={name: artifact_of(result.shaft, name) for name in ("points", "stations", "model")},
        registration=artifact_of(result.registration, "registration"),
        sigmas=plain(plan_sigmas(work.campaign)),
        shaft_z_m=plain(work.campaign.structure.shaft_z_m),
    )


def take_coverage(work: EpochWork, result: EpochResult, asked: Pending | None) -> None:
    """Wait for the coverage that was asked for."""
    if asked is None:
        return
    result.coverage = work.calls.finish(asked)
    if result.coverage.refusal is not None:
        result.notes.append(f"coverage: {result.coverage.refusal}")


def outlook_of(result: EpochResult) -> Outlook | None:
    """The coverage as a whole and the next station; None where the shaft was not found."""
    if result.coverage is None or result.coverage.refusal is not None:
        return None
    return rebuild(Outlook, result.coverage.facts["outlook"])


def coverage_of(work: EpochWork, result: EpochResult, home: Home) -> list[CoverageRow]:
    """The rows of coverage; none where the shaft was not found."""
    if result.coverage is None or result.coverage.refusal is not None:
        return []
    cells = get_rows(work.workspace, result.coverage.artifacts["coverage"], CoverageCell)
    return coverage_rows(home, cells)


def pairs_of(work: EpochWork, result: EpochResult, home: Home) -> list[PairRow]:
    """The rows of pairs; none where no station was registered."""
    if result.registration is None or result.registration.refusal is not None:
        return []
    return pair_rows(home, registration_of(work, result.registration))
