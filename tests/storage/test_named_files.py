"""What a user names to write to stays what it is: links are followed, pipes and devices written to."""

import os
import threading
from pathlib import Path

import pytest

from storage.errors import StorageError
from storage.named_files import write_named_file


def test_a_folder_is_refused_and_nothing_left_beside_it(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(StorageError, match="it is a folder; name a file in it"):
        write_named_file(folder, b"content")
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.parametrize("there", [True, False])
def test_the_file_behind_a_link_is_written_and_the_link_stays(tmp_path: Path, there: bool) -> None:
    target, link = tmp_path / "target", tmp_path / "link"
    if there:
        target.write_bytes(b"old")
    link.symlink_to(target)
    write_named_file(link, b"new")
    assert (link.is_symlink(), target.read_bytes()) == (True, b"new")


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such pipes")
def test_a_pipe_is_written_to_and_stays_a_pipe(tmp_path: Path) -> None:
    pipe, came = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: came.append(pipe.read_bytes()), daemon=True)
    reader.start()
    whole = bytes(200_000)
    write_named_file(pipe, lambda file: file.write(whole) and None)
    reader.join(10.0)
    assert came == [whole]
    assert pipe.is_fifo()


def test_a_device_stays_a_device() -> None:
    write_named_file(Path(os.devnull), b"content")
    assert Path(os.devnull).is_char_device()


def test_a_path_that_the_system_refuses_is_told(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"cannot write .*File name too long"):
        write_named_file(tmp_path / ("n" * 300), b"content")
