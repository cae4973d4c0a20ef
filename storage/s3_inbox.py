"""A prefix of an S3 bucket as an inbox: its objects are fetched, whole, into a folder that is watched like any other."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

from pyarrow import fs

from storage.atomic import write_atomically
from storage.errors import StorageError, UsageError
from storage.secrets import has_login, without_login

SCHEME: Final = "s3://"
TAKEN: Final = "taken"
"""Folder below the prefix to which objects go that were taken in, where they are to be moved."""

LEDGER: Final = ".fetched.json"
CHUNK_BYTES: Final = 4 * 1024 * 1024
CONNECT_S: Final = 10.0
REQUEST_S: Final = 60.0
DEFAULT_REGION: Final = "us-east-1"


@dataclass(frozen=True, slots=True)
class S3Place:
    """A bucket and what the names of its objects begin with, without slashes at the ends."""

    bucket: str
    prefix: str

    @property
    def path(self) -> str:
        """Bucket and prefix."""
        return f"{self.bucket}/{self.prefix}" if self.prefix else self.bucket


@dataclass(frozen=True, slots=True)
class Fetched:
    """What a look at the prefix brought: names that are new in the folder, and lines on what could not be had."""

    names: tuple[str, ...]
    faults: tuple[str, ...]


def is_s3_url(text: str) -> bool:
    """Whether a text names a place on S3."""
    return text.startswith(SCHEME)


def parse_s3_url(url: str) -> S3Place:
    """Take ``s3://bucket/prefix`` apart.

    Raises
    ------
    UsageError
        If it names no bucket.
    """
    bucket, _, prefix = url.removeprefix(SCHEME).partition("/")
    if not url.startswith(SCHEME) or not bucket:
        raise UsageError(f"needed s3://BUCKET/PREFIX, got {url!r}")
    return S3Place(bucket, prefix.strip("/"))


def s3_files() -> fs.FileSystem:
    """The object store that the usual environment names.

    ``AWS_ENDPOINT_URL_S3`` or ``AWS_ENDPOINT_URL`` (Amazon's where neither is set), ``AWS_REGION`` or
    ``AWS_DEFAULT_REGION``, and the credentials as Amazon's own tools find them.

    Raises
    ------
    UsageError
        If the address carries a login, which errors would show.
    """
    endpoint = os.environ.get("AWS_ENDPOINT_URL_S3") or os.environ.get("AWS_ENDPOINT_URL")
    region = os.environ.get("AWS_REGION") or os.environ.get("AWS_DEFAULT_REGION") or DEFAULT_REGION
    limits = {"connect_timeout": CONNECT_S, "request_timeout": REQUEST_S, "region": region}
    if endpoint is None:
        return fs.S3FileSystem(**limits)
    if has_login(endpoint):
        raise UsageError(
            f"AWS_ENDPOINT_URL {without_login(endpoint)} carries a login; put it into AWS_ACCESS_KEY_ID and "
            "AWS_SECRET_ACCESS_KEY"
        )
    scheme, _, host = endpoint.rpartition("://")
    return fs.S3FileSystem(endpoint_override=host.rstrip("/"), scheme=scheme or "https", **limits)


class S3Inbox:
    """The objects under a prefix, fetched into ``folder``; which ones were fetched is remembered there.

    The objects themselves are left alone, or moved to ``taken/`` by ``set_aside``.
    """

    def __init__(self, place: S3Place, folder: Path, files: fs.FileSystem) -> None:
        self._place = place
        self._folder = folder
        self._files = files

    def fetch(self) -> Fetched:
        """Fetch the objects that are new or changed since they were fetched; one that fails does not stop the others.

        Raises
        ------
        StorageError
            If the prefix cannot be listed, or the folder cannot be written.
        """
        known, names, faults = self._known(), [], []
        for name, info in self._objects():
            stamp = [info.size, info.mtime_ns]
            if known.get(name) == stamp:
                continue
            if not _is_safe(name):
                faults.append(f"object {name!r} cannot be the name of a file here; rename it")
                continue
            try:
                self._fetch_one(name, info)
            except StorageError as fault:
                faults.append(str(fault))
                continue
            known[name] = stamp
            write_atomically(self._folder / LEDGER, json.dumps(known, indent=0).encode())
            names.append(name)
        return Fetched(tuple(names), tuple(faults))

    def set_aside(self, name: str) -> None:
        """Move an object that was taken in below ``taken/``; it goes only when the copy there is as large.

        Raises
        ------
        StorageError
            If the store refuses, or the copy is not as large.
        """
        source = f"{self._place.path}/{name}"
        target = f"{self._place.path}/{TAKEN}/{name}"
        with _faults_of_the_store(source):
            size = self._files.get_file_info(source).size
            self._files.copy_file(source, target)
            if self._files.get_file_info(target).size != size:
                raise StorageError(
                    f"the copy {SCHEME}{target} is not as large as {SCHEME}{source}, which stays"
                )
            self._files.delete_file(source)

    def _objects(self) -> Iterator[tuple[str, fs.FileInfo]]:
        root = self._place.path
        with _faults_of_the_store(root):
            infos = self._files.get_file_info(fs.FileSelector(root, allow_not_found=True, recursive=True))
            # a prefix without any object yet is an empty inbox; a bucket that is not there is a mistake
            if not infos and self._is_missing(self._place.bucket):
                raise StorageError(f"no bucket {self._place.bucket!r}; check --inbox and AWS_ENDPOINT_URL")
        for info in sorted(infos, key=lambda info: info.path):
            name = info.path.removeprefix(f"{root}/")
            if info.type == fs.FileType.File and not name.startswith(f"{TAKEN}/"):
                yield name, info

    def _is_missing(self, bucket: str) -> bool:
        """Whether there is no such bucket; who may see his prefix alone is not told, and it is there."""
        try:
            return bool(self._files.get_file_info(bucket).type == fs.FileType.NotFound)
        except OSError as fault:
            if "ACCESS_DENIED" in str(fault):
                return False
            raise

    def _fetch_one(self, name: str, info: fs.FileInfo) -> None:
        fetched = 0

        def write(out: BinaryIO) -> None:
            nonlocal fetched
            with _faults_of_the_store(info.path), self._files.open_input_stream(info.path) as stream:
                while chunk := stream.read(CHUNK_BYTES):
                    fetched += out.write(chunk)
            if fetched != info.size:
                raise StorageError(
                    f"{SCHEME}{info.path}: needed {info.size} bytes, came {fetched}; it is fetched again"
                )

        write_atomically(self._folder / name, write)

    def _known(self) -> dict[str, list[int]]:
        try:
            content = json.loads((self._folder / LEDGER).read_bytes())
        except (OSError, ValueError):
            # without it everything is fetched again, and known by its digest
            return {}
        return content if isinstance(content, dict) else {}


def _is_safe(name: str) -> bool:
    """Whether the name of an object stays inside the folder, on every system."""
    parts = name.split("/")
    return all(part not in {"", ".", ".."} and not set(part) & set('\\:\0<>"|?*') for part in parts)


@contextmanager
def _faults_of_the_store(path: str) -> Iterator[None]:
    try:
        yield
    except OSError as fault:
        what = str(fault).splitlines()[0]
        raise StorageError(
            f"{SCHEME}{path}: {what}; check AWS_ENDPOINT_URL, AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and the network"
        ) from fault
