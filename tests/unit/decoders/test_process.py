"""A decoder in a child process: how it is asked, and how it ends."""

import os
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from storage.decoders import pool as pools
from storage.decoders.pool import DecoderPool
from storage.decoders.process import (
    MOST_THREADS,
    DecoderFault,
    DecoderLost,
    DecoderProcess,
    DecoderProgram,
    DecoderRefusal,
    Limits,
)
from tests.unit.decoders.doubles import children_with, pool_of_deeds

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="ends of processes have other names there")
SHORT = Limits(0.3, 60.0)
IMPATIENT = Limits(30.0, 0.3)


@pytest.fixture
def deeds(tmp_path: Path) -> Iterator[DecoderPool]:
    pool = pool_of_deeds(tmp_path)
    yield pool
    pool.end_idle()


@pytest.mark.parametrize(
    ("deed", "limits", "kind", "said"),
    [
        ("segfault", SHORT, DecoderFault, r"crashes or wants more than 256 MiB \(SIGSEGV\)"),
        ("abort", SHORT, DecoderFault, r"crashes or wants more than 256 MiB \(SIGABRT\)"),
        ("leave", SHORT, DecoderFault, r"\(exit code 0\)"),
        ("panic", SHORT, DecoderFault, r"PanicException \(index out of bounds\)"),
        ("lack_threads", SHORT, DecoderLost, "cannot start its threads"),
        ("hunger", Limits(20.0, 20.0), DecoderFault, "wants more than 256 MiB"),
        ("loop", SHORT, DecoderFault, "computes for over 0.3 s"),
        ("wait", IMPATIENT, DecoderLost, "no answer of its decoder in 0.3 s"),
        ("be_killed", SHORT, DecoderLost, r"ended from outside \(SIGKILL\)"),
    ],
)
def test_a_decoder_that_goes_wrong_is_ended_and_the_next_one_is_fresh(
    deeds: DecoderPool, deed: str, limits: Limits, kind: type[Exception], said: str
) -> None:
    with pytest.raises(kind, match=said), deeds.borrowed() as decoder:
        before = decoder.pid
        decoder.ask(deed, limits)
    assert not psutil.pid_exists(before)
    with deeds.borrowed() as decoder:
        assert decoder.pid != before
        assert decoder.ask("hello", SHORT) is None


def test_a_decoder_that_was_stopped_is_ended_by_its_parent(
    deeds: DecoderPool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No signal of its own ends it then."""
    monkeypatch.setattr("storage.decoders.process.GRACE_S", 0.2)
    with pytest.raises(DecoderLost, match="no answer"), deeds.borrowed() as decoder:
        decoder.ask("stop", IMPATIENT)
    assert not psutil.pid_exists(decoder.pid)


def test_a_refusal_in_good_order_is_told_and_costs_no_new_process(deeds: DecoderPool) -> None:
    with pytest.raises(DecoderRefusal, match=r"ValueError \(not like this\)"), deeds.borrowed() as decoder:
        decoder.ask("refuse", SHORT)
    with deeds.borrowed() as again:
        assert again.pid == decoder.pid


def test_what_the_system_refuses_is_told_as_such(deeds: DecoderPool) -> None:
    with pytest.raises(OSError, match="Input/output error"), deeds.borrowed() as decoder:
        decoder.ask("be_refused", SHORT)


def test_what_a_library_prints_is_no_answer(deeds: DecoderPool) -> None:
    with deeds.borrowed() as decoder:
        assert decoder.ask("talk", SHORT) is None
        assert decoder.ask("hello", SHORT) is None


def test_a_decoder_that_was_killed_while_idle_is_replaced(deeds: DecoderPool) -> None:
    with deeds.borrowed() as decoder:
        first = psutil.Process(decoder.pid)
    first.kill()
    with deeds.borrowed() as decoder:
        assert decoder.pid != first.pid


def test_an_idle_decoder_is_ended_after_a_while(deeds: DecoderPool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pools, "IDLE_S", 0.1)
    with deeds.borrowed() as decoder:
        pid = decoder.pid
    until = time.monotonic() + 30.0
    while psutil.pid_exists(pid) and time.monotonic() < until:
        time.sleep(0.05)
    assert not psutil.pid_exists(pid)


def test_a_program_that_does_not_start_is_no_fault_of_a_scan(tmp_path: Path) -> None:
    program = tmp_path / "broken.py"
    program.write_text("import a_module_that_is_not_there")
    with pytest.raises(DecoderLost, match="does not start"):
        DecoderProcess(DecoderProgram("broken", program, 1 << 28))


def test_threads_have_a_decoder_each(deeds: DecoderPool) -> None:
    pids, meet = [], threading.Barrier(3, timeout=60.0)

    def work() -> None:
        with deeds.borrowed() as decoder:
            meet.wait()
            pids.append(decoder.pid)

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(pids)) == 3


def test_a_child_sees_no_secret_of_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TILTWATCH_SECRET", "open sesame")
    with pool_of_deeds(tmp_path).borrowed() as decoder:
        assert "TILTWATCH_SECRET" not in psutil.Process(decoder.pid).environ()
        decoder.end()


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="open files are counted on Linux only")
@pytest.mark.parametrize(("given", "had"), [(None, str(min(os.cpu_count() or 1, MOST_THREADS))), ("3", "3")])
def test_a_child_has_no_more_threads_than_its_memory_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given: str | None, had: str
) -> None:
    monkeypatch.delenv("RAYON_NUM_THREADS", raising=False)
    if given is not None:
        monkeypatch.setenv("RAYON_NUM_THREADS", given)
    with pool_of_deeds(tmp_path).borrowed() as decoder:
        assert psutil.Process(decoder.pid).environ()["RAYON_NUM_THREADS"] == had
        decoder.end()


def test_nothing_of_a_crash_stays_open(deeds: DecoderPool) -> None:
    def crash() -> None:
        with pytest.raises(DecoderFault), deeds.borrowed() as decoder:
            decoder.memory.grow(1 << 20)
            decoder.ask("segfault", SHORT)

    crash()
    before = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(5):
        crash()
    assert len(list(Path("/proc/self/fd").iterdir())) == before
    assert children_with("deeds.py") == []
