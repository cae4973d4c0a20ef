"""The lines of a run's journal: a stage was asked for, a stage ended, an epoch ended."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any

from flows.outcome import EpochOutcome
from storage.records import StageRunRow
from storage.run_record import Line


@dataclass(frozen=True, slots=True)
class StageAsked:
    """A stage was asked for."""

    epoch: str
    stage: str
    asked_at: datetime
    cache_key: str
    code_version: str


@dataclass(frozen=True, slots=True)
class ScansSeen:
    """Digest of every scan that the run has seen, and whose it was first."""

    scans: Mapping[str, str]


def asked_line(asked: StageAsked) -> Line:
    """Line of a stage that begins."""
    return {"asked": {**asdict(asked), "asked_at": asked.asked_at.isoformat()}}


def row_line(row: StageRunRow) -> Line:
    """Line of a stage that ended."""
    return {"row": {**asdict(row), "started_at": row.started_at.isoformat()}}


def outcome_line(outcome: EpochOutcome) -> Line:
    """Line of an epoch that ended."""
    return {"outcome": asdict(outcome)}


def scans_line(scans: Mapping[str, str]) -> Line:
    """Line of the scans that were seen so far."""
    return {"scans": dict(scans)}


Told = StageAsked | StageRunRow | EpochOutcome | ScansSeen


def read_line(line: Line) -> Told | None:
    """What a line tells; nothing where it is of another version of tiltwatch."""
    try:
        return _read(line)
    except (KeyError, TypeError, ValueError):
        return None


def _read(line: Line) -> Told | None:
    match line:
        case {"asked": dict(told)}:
            return StageAsked(**_with_time(told, "asked_at"))
        case {"row": dict(told)}:
            return StageRunRow(**_with_time(told, "started_at"))
        case {"outcome": dict(told)}:
            return EpochOutcome(
                **{**told, "reasons": tuple(told["reasons"]), "notes": tuple(told.get("notes", ()))}
            )
        case {"scans": dict(told)}:
            return ScansSeen(told)
    return None


def _with_time(told: dict[str, Any], name: str) -> dict[str, Any]:
    return {**told, name: datetime.fromisoformat(told[name])}
