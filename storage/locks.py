"""Who may write: one publisher a workspace, one processor an epoch."""

import json
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from storage.atomic import faults_of_the_system, make_folder
from storage.errors import StorageError
from storage.ids import check_id
from storage.workspace import Workspace

PUBLISH_TIMEOUT_S: Final = 1800.0
"""Longest wait for the publish lock; it is held for seconds, of a thousand epochs by ``verify`` for minutes."""

EPOCH_TIMEOUT_S: Final = 5.0
"""Longest wait for an epoch that another run processes, which may take an hour: better to say so."""

DELIVERY_TIMEOUT_S: Final = 1800.0
"""Longest wait for another process that sends out alarms; every target has a time limit of its own."""

TELL_AFTER_S: Final = 10.0
"""Who waits longer than this is told for whom."""

waiting_teller: ContextVar[Callable[[str], None]] = ContextVar("waiting_teller", default=lambda _line: None)
"""Told for whom a process waits; the command line shows it."""


@contextmanager
def publish_lock(ws: Workspace, timeout_s: float = PUBLISH_TIMEOUT_S) -> Iterator[None]:
    """Hold the right to change tables and catalog; the same thread may take it again inside.

    The operating system frees the lock when its process ends, however it ends.

    Raises
    ------
    StorageError
        If another process or thread holds it for longer than ``timeout_s`` seconds.
    """
    with _held(ws.locks / "publish.lock", f"the publish lock of {ws.root}", timeout_s):
        yield


@contextmanager
def lock_to_read(ws: Workspace) -> Iterator[None]:
    """Hold the publish lock as long as something is looked at; without it where the workspace cannot be written.

    Nobody publishes on a drive that is read-only.

    Raises
    ------
    StorageError
        If another process or thread holds it for longer than the time-out.
    """
    if is_writable(ws):
        with publish_lock(ws):
            yield
    else:
        yield


def is_writable(ws: Workspace) -> bool:
    """Whether this process may change a workspace: not where it lies on a read-only drive or belongs to others."""
    return os.access(ws.root, os.W_OK) and (not ws.locks.exists() or os.access(ws.locks, os.W_OK))


@contextmanager
def epoch_lock(
    ws: Workspace, structure: str, epoch: str, timeout_s: float = EPOCH_TIMEOUT_S
) -> Iterator[None]:
    """Hold the right to process one epoch of a structure.

    Raises
    ------
    StorageError
        If another process or thread holds it for longer than ``timeout_s`` seconds.
    InputError
        If an id cannot be a file name.
    """
    folder = ws.locks / "epochs" / check_id(structure, "a structure")
    place = folder / f"{check_id(epoch, 'an epoch')}.lock"
    with _held(place, f"epoch {epoch} of {structure} in {ws.root}", timeout_s):
        yield


@contextmanager
def series_lock(ws: Workspace, structure: str, timeout_s: float = PUBLISH_TIMEOUT_S) -> Iterator[None]:
    """Hold the right to make what follows from all epochs of a structure: an older view must not overwrite a newer one.

    Raises
    ------
    StorageError
        If another process or thread holds it for longer than ``timeout_s`` seconds.
    InputError
        If the id cannot be a file name.
    """
    place = ws.locks / "series" / f"{check_id(structure, 'a structure')}.lock"
    with _held(place, f"the series of {structure} in {ws.root}", timeout_s):
        yield


@contextmanager
def watch_lock(ws: Workspace, structure: str, inbox: Path) -> Iterator[None]:
    """Hold the right to take in stations of a structure, and to take files out of an inbox.

    Raises
    ------
    StorageError
        If another watch holds one of them.
    InputError
        If the id cannot be a file name.
    """
    place = ws.locks / f"watch-{check_id(structure, 'a structure')}.lock"
    with (
        _held(place, f"the watch of {structure} in {ws.root}", 0.0),
        _held(inbox / ".tiltwatch.lock", f"the inbox {inbox}", 0.0),
    ):
        yield


@contextmanager
def delivery_lock(ws: Workspace, structure: str, timeout_s: float = DELIVERY_TIMEOUT_S) -> Iterator[None]:
    """Hold the right to send out what happened to the alarms of a structure, so that nothing is sent twice.

    Raises
    ------
    StorageError
        If another process or thread holds it for longer than ``timeout_s`` seconds.
    InputError
        If the id cannot be a file name.
    """
    place = ws.locks / "deliveries" / f"{check_id(structure, 'a structure')}.lock"
    with _held(place, f"the delivery of alarms of {structure} in {ws.root}", timeout_s):
        yield


@contextmanager
def _held(place: Path, what: str, timeout_s: float) -> Iterator[None]:
    make_folder(place.parent)
    # a singleton a path makes the lock re-entrant within a thread; other threads still wait
    lock = FileLock(place, is_singleton=True)
    holder = place.with_suffix(".holder.json")
    outermost = not lock.is_locked
    try:
        _wait_for(lock, what, holder, timeout_s)
    except Timeout as fault:
        raise StorageError(
            f"{what} is in use; waited {timeout_s:g} s; last taken by {_last_holder(holder)}: wait for it to "
            "finish, or end that process, and run again"
        ) from fault
    except OSError:
        with faults_of_the_system(place):
            raise
    try:
        if outermost:
            _write_holder(holder)
        yield
    finally:
        lock.release()


def _wait_for(lock: FileLock, what: str, holder: Path, timeout_s: float) -> None:
    """Take a lock; who waits for long is told for whom.

    Raises
    ------
    Timeout
        If another process or thread holds it for longer than ``timeout_s`` seconds.
    """
    if timeout_s > TELL_AFTER_S:
        try:
            lock.acquire(timeout=TELL_AFTER_S)
        except Timeout:
            waiting_teller.get()(f"waiting for {what}, last taken by {_last_holder(holder)}")
            timeout_s -= TELL_AFTER_S
        else:
            return
    lock.acquire(timeout=timeout_s)


def _write_holder(holder: Path) -> None:
    now = datetime.now(UTC).isoformat(timespec="seconds")
    text = json.dumps({"pid": os.getpid(), "host": socket.gethostname(), "since": now})
    with suppress(OSError):  # a full disk takes the lock away from nobody: this only tells who has it
        holder.write_text(text, encoding="utf-8")


def _last_holder(holder: Path) -> str:
    try:
        told = json.loads(holder.read_bytes())
        return f"process {told['pid']} on {told['host']} since {told['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "an unknown process"
