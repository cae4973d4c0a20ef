"""The record of a run while it lasts: who runs it, whether that process lives, and every stage as it happens.

``runs/active/<run>.json`` says who runs it, ``<run>.jsonl`` what was done so far, and ``<run>.lock`` is held as
long as its process lives: the system frees it however the process ends. A lock that is free beside a record that
does not say that it ended tells of a run that was cut short; the next run puts what it did into the ledger.
"""

import importlib
import json
import os
import socket
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any, Final

from filelock import FileLock, Timeout

from storage.atomic import faults_of_the_system, make_folder, write_atomically
from storage.ids import check_id
from storage.locks import publish_lock
from storage.workspace import Workspace

Line = Mapping[str, Any]
"""One thing that happened in a run, as plain JSON."""

START_TOLERANCE_S: Final = 2.0
"""The start of a process is told in ticks of the system's clock; a reused id starts later than this."""


@dataclass(frozen=True, slots=True)
class RunRecord:
    """Who runs a run."""

    run: str
    structure: str
    host: str
    pid: int
    process_started_at: float
    """When that process began, in seconds since ``boot``; since 1970 where that is none: an id may be used again."""
    began_at: str
    server: str
    """Address of the workflow server that knows the flow run; ``own`` where the run started one for itself."""
    flow_run: str | None
    """Id of the flow run of the campaign; none where no server told it."""
    deployment: str | None = None
    """Id of the deployment that asked for it."""
    ended_at: str | None = None
    """When the run came to its own end, well or by an exception; then the ledger has it."""
    finished: bool = False
    """Whether it came to an end with an outcome for every epoch."""
    boot: str | None = None
    """Since when the machine was up, as it names that itself: the clock may be set, and then all starts seem to move."""


@dataclass(slots=True)
class RunJournal:
    """What a run did, a line each, written as it happens; several threads may write."""

    path: Path
    _guard: threading.Lock = field(default_factory=threading.Lock)

    def append(self, line: Line) -> None:
        """Add a line.

        Raises
        ------
        StorageError
            If the system refuses, as for a full disk.
        """
        # the line before may be torn: its writer was killed
        content = b"\n" + json.dumps(line, separators=(",", ":")).encode() + b"\n"
        with self._guard, faults_of_the_system(self.path), self.path.open("ab", buffering=0) as file:
            file.write(content)

    def lines(self, after: int = 0) -> tuple[list[Line], int]:
        """Whole lines from byte ``after`` on, and the byte behind them; a torn line at the end is left out."""
        if not self.path.exists():
            return [], after
        with faults_of_the_system(self.path), self.path.open("rb") as file:
            file.seek(after)
            content = file.read()
        whole = content[: content.rfind(b"\n") + 1]
        return [line for text in whole.splitlines() if (line := _line(text)) is not None], after + len(whole)


def journal_of(ws: Workspace, run: str) -> RunJournal:
    """The journal of a run.

    Raises
    ------
    InputError
        If the id cannot be a file name.
    """
    return RunJournal(_place(ws, run, ".jsonl"))


def record_of_this_process(run: str, structure: str, server: str) -> RunRecord:
    """Make the record of a run that this process begins."""
    began_at = datetime.now(UTC).isoformat(timespec="milliseconds")
    return RunRecord(
        run,
        structure,
        socket.gethostname(),
        os.getpid(),
        _started_at(os.getpid(), _boot()) or 0.0,
        began_at,
        server,
        None,
        boot=_boot(),
    )


@contextmanager
def held_record(ws: Workspace, record: RunRecord) -> Iterator[RunJournal]:
    """Hold the lock of a run as long as the block lasts, and keep its record; the record stays behind.

    Raises
    ------
    StorageError
        If the system refuses.
    """
    make_folder(folder_of(ws))
    with _lock(ws, record.run).acquire():
        write_record(ws, record)
        yield journal_of(ws, record.run)


def write_record(ws: Workspace, record: RunRecord) -> None:
    """Put a record in place whole.

    Raises
    ------
    StorageError
        If the system refuses, or another process publishes for longer than the lock's time-out.
    """
    content = json.dumps(asdict(record), indent=1).encode() + b"\n"
    with publish_lock(ws):  # who holds it sweeps unfinished files away
        write_atomically(_place(ws, record.run, ".json"), content)


def end_record(ws: Workspace, run: str, *, finished: bool) -> None:
    """Say that a run came to its own end and is in the ledger; what it did need not be kept twice."""
    record = read_record(ws, run)
    if record is not None:
        write_record(ws, replace(record, ended_at=_now(), finished=finished))
    journal_of(ws, run).path.unlink(missing_ok=True)


def read_record(ws: Workspace, run: str) -> RunRecord | None:
    """The record of a run; none where it is absent or torn."""
    try:
        return RunRecord(**json.loads(_place(ws, run, ".json").read_bytes()))
    except (OSError, ValueError, TypeError):
        return None


def runs_on_record(ws: Workspace) -> list[str]:
    """Ids of all runs that have a record, the oldest first."""
    return sorted(path.stem for path in folder_of(ws).glob("*.json"))


def is_unfinished(ws: Workspace, run: str) -> bool:
    """Whether a run is under way or was killed: its record has no end, or is torn; one that is gone ended."""
    record = read_record(ws, run)
    return _place(ws, run, ".json").exists() if record is None else record.ended_at is None


def remove_record(ws: Workspace, run: str) -> None:
    """Remove all that is kept of a run beside the ledger."""
    for suffix in (".jsonl", ".json", ".lock"):
        with suppress(OSError):  # Windows keeps a lock file that another process has open
            _place(ws, run, suffix).unlink(missing_ok=True)


@contextmanager
def taken_from_dead(ws: Workspace, run: str) -> Iterator[RunRecord | None]:
    """Hold the lock of a run whose process does not hold it any more, so that no one else settles it.

    Gives its record, or None where the run is alive, another settles it, or it was settled meanwhile. Where locks
    cannot be had (some network drives) a process of this host is looked up by its id and start, and that of
    another host counts as alive.
    """
    lock = _lock(ws, run)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        yield None
        return
    except (OSError, NotImplementedError):
        record = read_record(ws, run)
        yield None if record is None or may_live(record) else record
        return
    try:
        yield read_record(ws, run)
    finally:
        lock.release()


def is_at_work(ws: Workspace) -> bool:
    """Whether a run of the workspace may be under way, on this machine or another."""
    records = (read_record(ws, run) for run in runs_on_record(ws))
    return any(record is not None and may_live(record) for record in records)


def may_live(record: RunRecord) -> bool:
    """Whether the process of a run may still be there; on another host nobody can tell."""
    if record.host != socket.gethostname():
        return True
    if record.boot is not None and record.boot != _boot():
        return False
    try:
        started_at = _started_at(record.pid, record.boot)
    except PermissionError:  # it is there, and of somebody else
        return True
    return started_at is not None and abs(started_at - record.process_started_at) < START_TOLERANCE_S


def folder_of(ws: Workspace) -> Path:
    """Where the records of runs under way lie."""
    return ws.runs / "active"


def _place(ws: Workspace, run: str, suffix: str) -> Path:
    return folder_of(ws) / f"{check_id(run, 'a run')}{suffix}"


def _lock(ws: Workspace, run: str) -> FileLock:
    return FileLock(_place(ws, run, ".lock"))


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _started_at(pid: int, boot: str | None) -> float | None:
    """When a process began, seconds since the boot or, without one, 1970; None where there is none, or it is a zombie.

    Raises
    ------
    PermissionError
        If this user may not look at it.
    """
    psutil = importlib.import_module("psutil")
    try:
        process = psutil.Process(pid)
        if process.status() == psutil.STATUS_ZOMBIE:
            return None
        # from the boot on: psutil adds the time of the boot, which the system reckons back from the clock as it is now
        return float(process.create_time()) if boot is None else _since_boot_s(pid)
    except psutil.AccessDenied as fault:
        raise PermissionError(f"cannot look at process {pid}") from fault
    except (psutil.Error, FileNotFoundError, ProcessLookupError):
        return None


def _since_boot_s(pid: int) -> float:
    told = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    # its second part, the name, may hold anything; the start is the 22nd
    return int(told.rpartition(")")[2].split()[19]) / os.sysconf("SC_CLK_TCK")


@cache
def _boot() -> str | None:
    """What tells this time of the machine being up from others; None where the system does not say."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except (OSError, ValueError):
        return None


def _line(text: bytes) -> Line | None:
    try:
        line = json.loads(text)
    except ValueError:
        return None
    return line if isinstance(line, dict) else None
