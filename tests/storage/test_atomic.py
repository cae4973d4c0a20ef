"""A write that fails leaves what was there."""

from pathlib import Path
from typing import BinaryIO

import pytest

from storage.atomic import replace_file, write_atomically, write_temp
from storage.errors import StorageError


def test_a_file_is_replaced_whole(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "file.bin"
    write_atomically(path, b"old")
    write_atomically(path, lambda file: file.write(b"new") and None)
    assert path.read_bytes() == b"new"
    assert list(path.parent.iterdir()) == [path]


def test_a_writer_that_fails_leaves_the_old_file_and_no_temp(tmp_path: Path) -> None:
    path = tmp_path / "file.bin"
    path.write_bytes(b"old")

    def fail(file: BinaryIO) -> None:
        file.write(b"half")
        raise KeyError("midway")

    with pytest.raises(KeyError, match="midway"):
        write_atomically(path, fail)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_temp_never_looks_like_a_table(tmp_path: Path) -> None:
    temp = write_temp(tmp_path / "e0.parquet", b"")
    assert temp.parent == tmp_path
    assert temp.suffix != ".parquet"


def test_a_refusal_of_the_system_is_told_with_the_path(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "file").touch()
    temp = write_temp(tmp_path / "x", b"")
    with pytest.raises(StorageError, match=r"cannot write .*folder"):
        replace_file(temp, tmp_path / "folder")


def test_a_target_that_cannot_be_replaced_leaves_no_temp(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(StorageError, match="cannot write"):
        write_atomically(folder, b"content")
    assert list(tmp_path.iterdir()) == [folder]
