"""One at a time, and whoever waits learns for whom."""

import os
import subprocess
import sys
import threading

import pytest

from storage.errors import StorageError
from storage.locks import epoch_lock, publish_lock, waiting_teller
from storage.workspace import Workspace

HOLD = """
import os, sys
from pathlib import Path
from storage.locks import publish_lock
from storage.workspace import Workspace
with publish_lock(Workspace(Path(sys.argv[1]))):
    print("held", flush=True)
    sys.stdin.readline()
    os._exit(9)
"""


def test_another_process_is_told_who_holds_the_lock_and_gets_it_when_that_dies(ws: Workspace) -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(ws.root)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        with (
            pytest.raises(
                StorageError, match=rf"publish lock .* in use; waited 0.1 s; .*process {holder.pid} on"
            ),
            publish_lock(ws, timeout_s=0.1),
        ):
            pass
    finally:
        holder.communicate("die\n")
    with publish_lock(ws, timeout_s=5.0):
        assert str(os.getpid()) in (ws.locks / "publish.holder.json").read_text()


def test_who_waits_for_long_is_told_for_whom_and_gets_the_lock(
    ws: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("storage.locks.TELL_AFTER_S", 0.1)
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(ws.root)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    told: list[str] = []

    def end_the_holder(line: str) -> None:
        told.append(line)
        holder.communicate("die\n")

    token = waiting_teller.set(end_the_holder)
    try:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        with publish_lock(ws):
            assert len(told) == 1
            assert (
                f"waiting for the publish lock of {ws.root}, last taken by process {holder.pid} on" in told[0]
            )
    finally:
        waiting_teller.reset(token)
        holder.communicate()


def test_the_same_thread_may_take_the_lock_again_inside(ws: Workspace) -> None:
    with publish_lock(ws), publish_lock(ws, timeout_s=0.0):
        pass


def test_another_thread_waits(ws: Workspace) -> None:
    outcomes: list[str] = []

    def try_it() -> None:
        try:
            with publish_lock(ws, timeout_s=0.1):
                outcomes.append("taken")
        except StorageError:
            outcomes.append("refused")

    with publish_lock(ws):
        thread = threading.Thread(target=try_it)
        thread.start()
        thread.join()
    assert outcomes == ["refused"]


def test_two_epochs_are_processed_side_by_side(ws: Workspace) -> None:
    with epoch_lock(ws, "s", "e1", timeout_s=0.0), epoch_lock(ws, "s", "e2", timeout_s=0.0):
        pass
