"""A folder that is held is missed when its path leads elsewhere; what is mounted is asked of the system."""

import sys
from pathlib import Path

import pytest

from storage.atomic import make_folder
from storage.errors import StorageError
from storage.presence import check_mounted, held_in_place


def _open_folders(folder: Path) -> int:
    """How often this process has a folder open; where the system tells."""
    return sum(path.exists() and path.resolve() == folder for path in Path("/proc/self/fd").iterdir())


def test_nothing_is_made_below_a_folder_that_another_stands_for(tmp_path: Path) -> None:
    root = tmp_path / "ws"
    root.mkdir()
    with held_in_place(root), held_in_place(root):
        make_folder(root / "tables" / "a")
        root.rename(tmp_path / "taken away")
        root.mkdir()
        with pytest.raises(StorageError, match="is gone, or its path leads to another folder"):
            make_folder(root / "tables" / "b")
        make_folder(tmp_path / "elsewhere")
    assert list(root.iterdir()) == []
    make_folder(root / "tables")


@pytest.mark.skipif(sys.platform != "linux", reason="the system does not tell what is open")
def test_a_folder_is_let_go_with_the_last_block(tmp_path: Path) -> None:
    for _ in range(3):
        with held_in_place(tmp_path), held_in_place(tmp_path):
            assert _open_folders(tmp_path) == 1
    assert _open_folders(tmp_path) == 0


def test_a_folder_that_is_gone_already_cannot_be_held(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="is gone"), held_in_place(tmp_path / "none"):
        pass


def test_a_bound_folder_counts_as_mounted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fstab, mounted = tmp_path / "fstab", tmp_path / "mountinfo"
    place = tmp_path / "bound folder"
    place.mkdir()
    fstab.write_text(f"/data {tmp_path}/bound\\040folder none bind 0 0\n", encoding="utf-8")
    mounted.write_text(
        f"36 35 98:0 /data {tmp_path}/bound\\040folder rw shared:1 - ext4 /dev/sda rw\n", encoding="utf-8"
    )
    monkeypatch.setattr("storage.presence.MOUNTED", mounted)
    check_mounted(place / "ws", fstab)
    mounted.write_text("", encoding="utf-8")
    with pytest.raises(StorageError, match="none is mounted there"):
        check_mounted(place / "ws", fstab)
    (tmp_path / "link").symlink_to(place)
    with pytest.raises(StorageError, match="none is mounted there"):
        check_mounted(tmp_path / "link" / "ws", fstab)
