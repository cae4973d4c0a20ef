"""What lies in an inbox, and how it is taken out of it without ever losing anything."""

import errno
import os
from pathlib import Path

import pytest

from storage.digests import file_sha256
from storage.errors import StorageError
from storage.inbox import InboxFile, Settling, is_unfinished, look_into
from storage.take_over import place_copy, place_for_good, remove_placed

CONTENT = b"points\n" * 1000


def only_file(inbox: Path) -> InboxFile:
    (file,) = look_into(inbox)
    return file


def test_files_of_folders_are_seen_and_hidden_folders_are_not(tmp_path: Path) -> None:
    for name in ("ST01.laz", "2026-03/ST02.laz", ".uploads/half.data", "2026-03/.hidden/x.laz"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert [file.name for file in look_into(tmp_path)] == ["2026-03/ST02.laz", "ST01.laz"]


def test_a_link_that_leads_out_of_the_inbox_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "inbox").mkdir()
    (tmp_path / "secret.laz").touch()
    (tmp_path / "inbox" / "ST01.laz").symlink_to(tmp_path / "secret.laz")
    assert look_into(tmp_path / "inbox") == ()


def test_an_inbox_that_is_away_is_said(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="check that the folder or share is there"):
        look_into(tmp_path / "share")


@pytest.mark.parametrize(
    ("name", "unfinished"),
    [
        (".ST01.laz.Xy12Ab", True),  # rsync
        ("ST01.laz.filepart", True),  # WinSCP
        ("ST01.laz.part", True),  # curl, wget, KDE
        ("ST01.laz.1f2e3d4c.partial", True),  # rclone
        ("ST01.laz.tmp", True),
        ("ST01.LAZ.PART", True),
        ("ST01.laz", False),
        ("part.laz", False),
        ("2026-03.complete", False),
    ],
)
def test_names_of_unfinished_files_are_known(tmp_path: Path, name: str, unfinished: bool) -> None:
    (tmp_path / name).touch()
    assert is_unfinished(only_file(tmp_path)) is unfinished


def test_a_file_settles_when_size_and_time_stay_for_so_long(tmp_path: Path) -> None:
    now = [0.0]
    settling = Settling(10.0, clock=lambda: now[0])
    path = tmp_path / "ST01.laz"

    def settled_at(clock_s: float) -> bool:
        now[0] = clock_s
        return settling.settled(look_into(tmp_path)) == {"ST01.laz"}

    path.write_bytes(b"half")
    assert not settled_at(0.0)
    assert not settled_at(9.9)
    path.write_bytes(b"half and more")
    assert not settled_at(10.5)
    assert not settled_at(20.4)
    os.utime(path, ns=(0, 5_000_000_000))
    assert not settled_at(25.0)
    assert settled_at(35.0)
    path.unlink()
    assert not settled_at(36.0)
    path.write_bytes(b"half and more")
    os.utime(path, ns=(0, 5_000_000_000))
    assert not settled_at(37.0), "a file that was away begins anew"


@pytest.mark.parametrize("links", [True, False], ids=["one file system", "another file system"])
def test_a_file_is_moved_only_when_its_copy_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: bool
) -> None:
    if not links:

        def refuse(*_: object) -> None:
            raise OSError(errno.EXDEV, "Invalid cross-device link")

        monkeypatch.setattr(os, "link", refuse)
    inbox, target = tmp_path / "inbox", tmp_path / "scans" / "ST01.laz"
    inbox.mkdir()
    (inbox / "ST01.laz").write_bytes(CONTENT)
    file = only_file(inbox)
    place_for_good(file, target, file_sha256(file.path))
    assert target.read_bytes() == file.path.read_bytes() == CONTENT
    remove_placed(file, target)
    assert look_into(inbox) == ()
    assert [path.name for path in target.parent.iterdir()] == ["ST01.laz"]


def test_a_file_that_changed_since_it_was_hashed_stays(tmp_path: Path) -> None:
    (tmp_path / "ST01.laz").write_bytes(CONTENT)
    file, target = only_file(tmp_path), tmp_path / "scans" / "ST01.laz"
    sha256 = file_sha256(file.path)
    file.path.write_bytes(CONTENT + b"more")
    for place in (place_for_good, place_copy):
        with pytest.raises(StorageError, match="changed while"):
            place(file, target, sha256)
    assert not target.exists()
    file.path.write_bytes(CONTENT)
    file = only_file(tmp_path)
    place_copy(file, target, sha256)
    os.utime(file.path, ns=(0, 1))
    with pytest.raises(StorageError, match="changed while it was taken in"):
        remove_placed(file, target)
    assert file.path.exists()


def test_another_file_in_its_place_is_never_written_over(tmp_path: Path) -> None:
    (tmp_path / "ST01.laz").write_bytes(CONTENT)
    file, target = only_file(tmp_path), tmp_path / "scans" / "ST01.laz"
    target.parent.mkdir()
    target.write_bytes(b"older")
    with pytest.raises(StorageError, match="is there already and holds something else"):
        place_for_good(file, target, file_sha256(file.path))
    with pytest.raises(StorageError, match="no whole copy"):
        remove_placed(file, target)
    assert (target.read_bytes(), file.path.read_bytes()) == (b"older", CONTENT)


def test_the_same_file_in_its_place_serves(tmp_path: Path) -> None:
    """A watch that was killed between the copy and the note goes on where it stopped."""
    (tmp_path / "ST01.laz").write_bytes(CONTENT)
    file, target = only_file(tmp_path), tmp_path / "scans" / "ST01.laz"
    for _ in range(2):
        place_for_good(file, target, file_sha256(file.path))
    remove_placed(file, target)
    assert target.read_bytes() == CONTENT


def test_a_copy_is_not_the_file_itself(tmp_path: Path) -> None:
    """Of a file that stays in the inbox: whoever writes into it there changes nothing here."""
    (tmp_path / "ST01.laz").write_bytes(CONTENT)
    file, target = only_file(tmp_path), tmp_path / "scans" / "ST01.laz"
    place_copy(file, target, file_sha256(file.path))
    with file.path.open("r+b") as out:
        out.write(b"new")
    assert target.read_bytes() == CONTENT
