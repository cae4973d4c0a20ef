"""An upload goes on where it stopped: after a cut, a restart, a kill."""

import hashlib
import io
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from flows.upload.server import FOLDER
from flows.upload.store import CHECKPOINT_BYTES, UploadStore
from tests.flows.calls import ROOT
from tests.flows.uploads import CONTENT, TOKEN, ask, begun, client, half_a_patch, scan_file, send, serving
from tests.unit.settings.campaign_text import WHOLE


def test_an_upload_goes_on_after_the_server_was_started_again(tmp_path: Path) -> None:
    inbox, path = tmp_path / "inbox", scan_file(tmp_path)
    with serving(inbox) as url:
        uploader = client(url).uploader(
            file_stream=io.BytesIO(path.read_bytes()), chunk_size=100_000, metadata={"filename": "ST01.laz"}
        )
        uploader.upload_chunk()
        place = str(uploader.url)
    # what a kill leaves behind the last offset that is safe is not taken for a part of the file
    (data,) = (inbox / FOLDER).glob("*.data")
    with data.open("ab") as out:
        out.write(b"written, and not counted")
    with serving(inbox) as url:
        resumed = client(url).uploader(
            file_stream=io.BytesIO(path.read_bytes()), chunk_size=100_000, url=url + place.rsplit("/", 1)[1]
        )
        assert resumed.offset == 100_000
        resumed.upload()
    assert (inbox / "ST01.laz").read_bytes() == CONTENT


def test_a_new_connection_takes_over_from_one_that_died_silently(tmp_path: Path) -> None:
    """A modem that gets a new address leaves a connection that no one ends."""
    inbox, path = tmp_path / "inbox", scan_file(tmp_path)
    with serving(inbox) as url:
        place = str(begun(url, len(CONTENT)).getheader("Location"))
        dead = half_a_patch(place, CONTENT[:120_000], len(CONTENT))
        try:
            resumed = client(url).uploader(
                file_stream=io.BytesIO(path.read_bytes()), chunk_size=100_000, url=place
            )
            assert 0 <= resumed.offset <= 120_000
            resumed.upload()
        finally:
            dead.close()
    assert (inbox / "ST01.laz").read_bytes() == CONTENT


def test_an_upload_that_was_received_when_the_server_ended_is_put_into_the_inbox_later(
    tmp_path: Path,
) -> None:
    inbox = tmp_path / "inbox"
    with serving(inbox) as url:
        send(url, scan_file(tmp_path))
    # as if the server had been killed just before the last rename
    (info,) = (inbox / FOLDER).glob("*.json")
    (inbox / "ST01.laz").rename(info.with_suffix(".data"))
    with serving(inbox) as url:
        assert (inbox / "ST01.laz").read_bytes() == CONTENT
        again = ask(url + info.stem, "HEAD", {})
        assert (again.status, again.getheader("Upload-Offset")) == (200, str(len(CONTENT)))


def test_uploads_are_safe_in_steps(tmp_path: Path) -> None:
    """A kill costs what came since the last step and no more; and no offset is ahead of the disk."""
    inbox, body = tmp_path / "inbox", bytes(2 * CHECKPOINT_BYTES + 1_000_000)
    with serving(inbox) as url:
        place = str(begun(url, 2 * len(body)).getheader("Location"))
        store, uid = UploadStore(inbox / FOLDER), place.rsplit("/", 1)[1]
        connection = half_a_patch(place, body, 2 * len(body))
        offset, waited = 0, threading.Event()
        for _ in range(300):
            offset = int((store.info(uid) or {})["offset"])
            assert offset <= store.data(uid).stat().st_size
            if offset >= 2 * CHECKPOINT_BYTES:
                break
            waited.wait(0.1)
        connection.close()
    assert offset >= 2 * CHECKPOINT_BYTES


@contextmanager
def watching(folder: Path) -> Iterator[tuple["subprocess.Popen[bytes]", str]]:
    """The command as a process of its own, and the URL of its uploads; killed at the end."""
    words = ["watch", folder / "c.toml", "--inbox", folder / "inbox", "--json", "--settle-s", "3600"]
    command = [
        sys.executable,
        "-m",
        "flows.cli",
        *words,
        "--listen",
        "127.0.0.1:0",
        "--token-env",
        "UPLOAD_TOKEN",
    ]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "UPLOAD_TOKEN": TOKEN}
    with (folder / "err.txt").open("ab") as err:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=err, env=environment, cwd=folder)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert line, (folder / "err.txt").read_text()
        yield process, f"http://127.0.0.1:{json.loads(line)['upload_port']}/files/"
    finally:
        process.kill()
        process.wait(30)
        process.stdout.close()


def test_an_upload_goes_on_after_the_watch_was_killed_in_the_middle_of_it(tmp_path: Path) -> None:
    content = np.random.default_rng(4).bytes(24_000_000)
    path = scan_file(tmp_path, content)
    (tmp_path / "c.toml").write_text(WHOLE, encoding="utf-8")
    with watching(tmp_path) as (process, url):
        place = str(begun(url, len(content)).getheader("Location"))
        connection = half_a_patch(place, content[:20_000_000], len(content))
        store, uid = UploadStore(tmp_path / "inbox" / FOLDER), place.rsplit("/", 1)[1]
        wait = threading.Event()
        while int((store.info(uid) or {})["offset"]) < CHECKPOINT_BYTES:
            wait.wait(0.05)
        process.send_signal(signal.SIGKILL)
        process.wait(30)
        connection.close()
    with watching(tmp_path) as (process, url):
        resumed = client(url).uploader(
            file_stream=io.BytesIO(path.read_bytes()), chunk_size=5_000_000, url=url + uid
        )
        assert CHECKPOINT_BYTES <= resumed.offset < len(content)
        resumed.upload()
        assert (
            hashlib.sha256((tmp_path / "inbox" / "ST01.laz").read_bytes()).digest()
            == hashlib.sha256(content).digest()
        )
        process.terminate()
        assert process.wait(30) == 130
