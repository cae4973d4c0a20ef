"""A scan that cannot be looked at refuses its station; each file is hashed once; an interrupt does not wait."""

import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from flows import scan_steps
from storage.errors import InputError, StorageError
from storage.verified import stamp_of
from tasks.ingest import describe_scan


@dataclass
class Ledger:
    digests: dict[Any, str] = field(default_factory=dict)
    passing: set[str] = field(default_factory=set)


@dataclass
class Calls:
    ledger: Ledger = field(default_factory=Ledger)


@dataclass
class Epoch:
    id: str = "e1"


@dataclass
class Work:
    """What hashing asks of an epoch's work: the run's ledger and which epoch it is."""

    calls: Calls = field(default_factory=Calls)
    epoch: Epoch = field(default_factory=Epoch)


@dataclass(frozen=True)
class Plan:
    path: Path


def digests(*paths: Path, work: Work | None = None) -> list[tuple[str, str | None]]:
    return list(scan_steps._digests_of(work or Work(), [Plan(path) for path in paths]))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "why"),
    [("n" * 300 + ".laz", "cannot be looked at (File name too long)"), ("a\0b.laz", "no such file")],
)
def test_a_name_that_no_file_can_have_is_a_reason(tmp_path: Path, name: str, why: str) -> None:
    sound = tmp_path / "sound.laz"
    sound.write_bytes(b"points")
    (digest, none), (empty, reason) = digests(sound, tmp_path / name)
    assert (len(digest), none, empty) == (64, None, "")
    assert why in str(reason)
    assert stamp_of(tmp_path / name) is None


def test_a_folder_that_may_not_be_searched_is_a_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_path: Path, **_how: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "stat", refuse)
    ((_, reason),) = digests(tmp_path / "closed" / "a.laz")
    assert "cannot be looked at (Permission denied); check the rights of its folders" in str(reason)
    assert stamp_of(tmp_path / "a.laz") is None


def test_the_check_tells_of_a_name_that_no_file_can_have(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be looked at .File name too long"):
        describe_scan(tmp_path / ("n" * 300 + ".laz"))


def test_parts_of_one_file_hash_it_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, hashed = tmp_path / "parts.e57", []
    file.write_bytes(b"points")
    monkeypatch.setattr(scan_steps, "file_sha256", lambda path: hashed.append(path) or "digest")
    assert digests(file, file, file) == [("digest", None)] * 3
    assert hashed == [file]


def test_who_is_interrupted_does_not_wait_for_files_in_the_queue(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    go_on, hashed = threading.Event(), []

    def hash_slowly(_ledger: object, path: Path) -> tuple[str, None]:
        if path.name != "0":
            go_on.wait(10.0)
        hashed.append(path.name)
        return "digest", None

    monkeypatch.setattr(scan_steps, "_digest_or_reason", hash_slowly)
    found = scan_steps._digests_of(Ledger(), [Plan(tmp_path / str(n)) for n in range(9)])  # type: ignore[arg-type]
    assert next(found) == ("digest", None)
    with pytest.raises(KeyboardInterrupt):
        found.throw(KeyboardInterrupt())  # type: ignore[attr-defined]
    assert hashed == ["0"]
    go_on.set()


def test_a_drive_that_fails_while_hashing_is_told_as_passing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(path: Path) -> str:
        raise StorageError(f"{path}: cannot be read (Input/output error)")

    monkeypatch.setattr(scan_steps, "file_sha256", fail)
    (tmp_path / "a.laz").write_bytes(b"points")
    work = Work()
    ((digest, reason),) = digests(tmp_path / "a.laz", work=work)
    assert (digest, work.calls.ledger.passing) == ("", {"e1"})
    assert "Input/output error" in str(reason)
