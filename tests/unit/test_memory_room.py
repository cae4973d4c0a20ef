"""Stages of a process take no more memory together than is allowed, and one that needs more is told so."""

import threading
from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.caching import lasting
from tasks.memory_needs import REGISTERED_POINTS, need_of_ingest, need_of_isolation, need_of_registration
from tasks.memory_room import GIGABYTE, PROGRAM_BYTES, MemoryRoom, Need, bytes_allowed, machine_bytes
from tasks.registration.planar import MOST_POINTS


def test_stages_wait_until_there_is_room_for_them() -> None:
    room, lock = MemoryRoom(10), threading.Lock()
    held, most = 0, 0

    def work(need: int) -> None:
        nonlocal held, most
        with room.held(Need(need, "work", "")):
            with lock:
                held += need
                most = max(most, held)
            threading.Event().wait(0.002)
            with lock:
                held -= need

    threads = [threading.Thread(target=work, args=(need,)) for need in (3, 4, 6, 10, 2) * 8]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=30.0)
    assert not any(thread.is_alive() for thread in threads)
    assert 6 < most <= 10


def test_room_is_given_back_where_the_stage_fails() -> None:
    room = MemoryRoom(10)
    with pytest.raises(ZeroDivisionError), room.held(Need(10, "work", "")):
        raise ZeroDivisionError
    with room.held(Need(10, "work", "")):
        pass


def test_who_asks_first_comes_first_however_much_it_is() -> None:
    room, order = MemoryRoom(10), []
    small_is_in, go_on = threading.Event(), threading.Event()

    def small() -> None:
        with room.held(Need(4, "small", "")):
            small_is_in.set()
            go_on.wait(timeout=10.0)

    def ask(name: str, need: int) -> threading.Thread:
        def work() -> None:
            with room.held(Need(need, name, "")):
                order.append(name)

        thread = threading.Thread(target=work)
        thread.start()
        return thread

    first = threading.Thread(target=small)
    first.start()
    assert small_is_in.wait(timeout=10.0)
    large = ask("large", 9)
    while not room._waiting:
        threading.Event().wait(0.001)
    later = ask("later", 2)
    while len(room._waiting) < 2:
        threading.Event().wait(0.001)
    assert order == []
    go_on.set()
    for thread in (first, large, later):
        thread.join(timeout=10.0)
    assert order == ["large", "later"]


def test_what_is_held_stays_counted_where_more_or_less_is_allowed() -> None:
    room = MemoryRoom(10)
    with room.held(Need(8, "work", "")):
        room.allow(12)
        with room.held(Need(4, "more", "")):
            pass
        room.allow(5)
        with pytest.raises(InputError), room.held(Need(6, "too much", "")):
            pass


def test_what_needs_more_than_there_is_is_refused_with_the_way_out_and_not_remembered() -> None:
    room = MemoryRoom(bytes_allowed(1.0))
    need = need_of_ingest("x.e57", ".e57", 200_000_000)
    told_so = (
        r"reading x\.e57 needs up to 2\.15 GB .*1\.00 GB are allowed.*memory_gb to 2\.15 .*as LAS or LAZ"
    )
    with pytest.raises(InputError, match=told_so) as told, room.held(need):
        raise AssertionError
    with pytest.raises(InputError):
        lasting(told.value)
    with room.held(Need(10, "after it", "")):
        pass


def test_half_of_the_machine_is_allowed_where_nothing_is_stated() -> None:
    whole = machine_bytes()
    assert whole is not None
    assert whole > GIGABYTE
    assert bytes_allowed(None) == max(whole // 2 - PROGRAM_BYTES, PROGRAM_BYTES)
    assert bytes_allowed(2.0) == 2 * GIGABYTE - PROGRAM_BYTES


def test_a_container_has_what_it_is_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limits = [tmp_path / name for name in ("max", "number", "none")]
    limits[0].write_text("max\n")
    limits[1].write_text("1500000000\n")
    monkeypatch.setattr("tasks.memory_room.CONTAINER_LIMITS", tuple(map(str, limits)))
    assert machine_bytes() == 1_500_000_000


def test_needs_do_not_grow_with_scans_beyond_what_is_looked_at() -> None:
    isolations = [need_of_isolation(n, 8_000_000).size for n in (10**8, 10**9)]
    registrations = [need_of_registration([n] * 8).size for n in (10**7, 10**9)]
    assert isolations[0] == isolations[1] < GIGABYTE
    assert registrations[0] == registrations[1] < GIGABYTE
    laz, las, e57 = (
        need_of_ingest("x", end, n).size for end, n in ((".laz", 10**12), (".las", 1), (".e57", 10**6))
    )
    assert laz == las < e57


def test_the_bounds_are_those_of_the_stages() -> None:
    assert REGISTERED_POINTS == MOST_POINTS
