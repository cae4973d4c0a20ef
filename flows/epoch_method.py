"""What is done for one epoch, from station scans to published rows, in the order of the paper's method section."""

from typing import Final

from flows.epoch_publication import publish_result
from flows.epoch_quality import ask_for_coverage, take_coverage
from flows.epoch_steps import evaluate_schemes, measure_schemes
from flows.epoch_work import EpochResult, EpochWork
from flows.level_steps import leave_out_unlevel
from flows.map_steps import map_surface_of
from flows.outcome import EpochOutcome
from flows.placing_steps import isolate_shaft_of, register_scans, tell_suspects
from flows.scan_steps import read_scans
from flows.stable_steps import take_stable
from storage.locks import epoch_lock

WAIT_FOR_OTHERS_S: Final = 4 * 3600.0
"""Another run of the same epoch is waited for: what it computes is then found in the cache."""


def process_epoch_of(work: EpochWork) -> EpochOutcome:
    """Measure an epoch and publish it.

    Raises
    ------
    StorageError
        If another run of the epoch lasts for hours, or the disk refuses.
    """
    with epoch_lock(work.workspace, work.campaign.structure.id, work.epoch.id, timeout_s=WAIT_FOR_OTHERS_S):
        return publish_result(work, measure_epoch(work))


def measure_epoch(work: EpochWork) -> EpochResult:
    """Measure the lean of a structure in one epoch under every scheme."""
    result = EpochResult()
    read_scans(work, result)
    take_stable(work, result)
    register_scans(work, result)
    isolate_shaft_of(work, result)
    leave_out_unlevel(work, result)
    tell_suspects(work, result)
    coverage = ask_for_coverage(work, result)
    measure_schemes(work, result)
    take_coverage(work, result, coverage)
    map_surface_of(work, result)
    evaluate_schemes(work, result)
    return result
