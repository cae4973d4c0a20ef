"""The first step of an epoch: every scan that the campaign names is read, or refused with a reason."""

import stat
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final, cast

from flows.epoch_work import EpochResult, EpochWork, ReadScan
from flows.ledger import RunLedger
from flows.stage_calls import Pending
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.presence import may_be_unmounted
from storage.scan_files import offer_scan
from storage.verified import stamp_of, would_show_change
from tasks.epoch_tables import ScanInput
from tasks.exchange import plain
from tasks.plan import PlannedScan, plan_scans
from tasks.produced import Json, Produced
from tasks.stages import ingest_scan
from tasks.stated_pose import refuse_far_pose

HASHED_AT_ONCE: Final = 2
"""Files of scans, while others are decoded: of files that are not compressed to hash takes as long as to read."""


def read_scans(work: EpochWork, result: EpochResult) -> None:
    """Read every scan of the epoch; one that is refused is named, and the others go on."""
    asked = list(_asked_for(work, plan_scans(work.campaign, work.epoch)))
    first_with: dict[str, str] = {}
    scans = [_finish_scan(work, plan, digest, pending, first_with) for plan, digest, pending in asked]
    result.scans = tuple(scans)
    for scan in scans:
        if scan.input.refusal is not None:
            result.refuse(f"station {scan.input.station}: {scan.input.refusal}")
        result.notes += [f"station {scan.input.station}: {note}" for note in scan.input.notes]
        result.notes += _seen_before(work, scan)


def _seen_before(work: EpochWork, scan: ReadScan) -> list[str]:
    """Tell of a scan that another epoch of this run has, too: copied, it would say that nothing moved."""
    if scan.input.digest is None or scan.input.refusal is not None:
        return []
    here = f"station {scan.input.station} of epoch {work.epoch.id}"
    first = work.calls.ledger.scans.setdefault(_which(scan.plan, scan.input.digest), here)
    return (
        []
        if first == here
        else [f"station {scan.input.station}: its scan is that of {first}; is it the right file"]
    )


def _asked_for(
    work: EpochWork, plans: Sequence[PlannedScan]
) -> Iterator[tuple[PlannedScan, str, Pending | None]]:
    """Ask for every scan by its digest, as soon as that is known; one without a digest has its reason there."""
    for plan, (digest, reason) in zip(plans, _digests_of(work, plans), strict=True):
        yield (plan, digest, _ask_for_scan(work, plan, digest)) if reason is None else (plan, reason, None)


def _digests_of(work: EpochWork, plans: Sequence[PlannedScan]) -> Iterator[tuple[str, str | None]]:
    """Digest or reason of the file of each plan; one that several name, as parts of it, is read once."""
    pool = ThreadPoolExecutor(HASHED_AT_ONCE)
    try:
        paths = dict.fromkeys(plan.path for plan in plans)
        found = {path: pool.submit(_digest_or_reason, work, path) for path in paths}
        for plan in plans:
            yield found[plan.path].result()
    except BaseException:  # who interrupts does not wait until gigabytes are hashed
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def _ask_for_scan(work: EpochWork, plan: PlannedScan, digest: str) -> Pending:
    offer_scan(work.workspace, plan.path, digest)
    return work.calls.submit(
        ingest_scan,
        f"ingest {plan.station}",
        path=str(plan.path),
        digest=digest,
        suffix=plan.path.suffix.lower(),
        request=plain(plan.request),
    )


def _digest_or_reason(work: EpochWork, path: Path) -> tuple[str, str | None]:
    """Digest of a file; or why it cannot be read."""
    unfit = _why_no_file(path)
    if unfit is not None:
        if not may_be_unmounted(path):
            return "", f"{path}: {unfit} in the campaign file"
        work.calls.ledger.passing.add(work.epoch.id)
        return (
            "",
            f"{path}: {unfit} in the campaign file; {path.parent} is empty or gone: mount its drive if it has one",
        )
    try:
        return _digest_of(work.calls.ledger, path), None
    except StorageError as fault:
        work.calls.ledger.passing.add(work.epoch.id)
        return "", str(fault)


def _why_no_file(path: Path) -> str | None:
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return "no such file; check the path"
    except OSError as fault:
        return f"cannot be looked at ({fault.strerror}); check the rights of its folders and the path"
    if stat.S_ISDIR(mode):
        return "is a folder; name the scan itself"
    return None if stat.S_ISREG(mode) else "no such file; check the path"


def _digest_of(ledger: RunLedger, path: Path) -> str:
    """SHA-256 of a scan; a run reads a scan that does not change once, however often it asks."""
    stamp = stamp_of(path)
    known = None if stamp is None else ledger.digests.get((path, stamp))
    if known is not None:
        return known
    # asked before it is read: it may be old enough only by the time that takes
    is_told = stamp is not None and would_show_change(stamp)
    digest = file_sha256(path)
    if is_told and stamp is not None and stamp_of(path) == stamp:
        ledger.digests[path, stamp] = digest
    return digest


def _finish_scan(
    work: EpochWork, plan: PlannedScan, digest: str, pending: Pending | None, first_with: dict[str, str]
) -> ReadScan:
    if pending is None:
        return ReadScan(plan, ScanInput(plan.station, None, None, digest), None)
    produced = work.calls.finish(pending)
    refusal = _why_refused(work, plan, produced) or _why_doubled(plan, digest, produced, first_with)
    count = produced.facts.get("n_points")
    n_points = count if isinstance(count, int) else None
    notes = tuple(str(note) for note in cast("list[Json]", produced.facts.get("notes", [])))
    return ReadScan(plan, ScanInput(plan.station, digest, n_points, refusal, notes), produced)


def _why_refused(work: EpochWork, plan: PlannedScan, produced: Produced) -> str | None:
    if produced.refusal is not None:
        return f"{plan.path}: {produced.refusal.removeprefix(f'{plan.path}: ')}"
    too_far = refuse_far_pose(work.campaign, plan, produced.facts)
    return None if too_far is None else f"{plan.path}: {too_far}"


def _why_doubled(
    plan: PlannedScan, digest: str, produced: Produced, first_with: dict[str, str]
) -> str | None:
    """Say that another station has this scan: the same bytes, or another name for the same part of a file."""
    # not the digest of the artifact: equal points of a LAZ and of a PLY file are stored in two ways
    points = str(produced.facts.get("fingerprint", ""))
    for what, key in (("bytes", _which(plan, digest)), ("points", points)):
        first = first_with.setdefault(key, plan.station) if key else plan.station
        if first != plan.station:
            return f"{plan.path}: holds the same {what} as the scan of station {first}; name the right file"
    return None


def _which(plan: PlannedScan, digest: str) -> str:
    """Key of a scan: two stations may name different parts of one file."""
    return digest if plan.request.part is None else f"{digest} part {plan.request.part!r}"
