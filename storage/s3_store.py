"""A store in a bucket of an S3 server; what is read lies in a cache of this machine, checked by its digest.

Where the server is and who we are comes from the environment alone, as with every other S3 program: ``AWS_ENDPOINT_URL``,
``AWS_ACCESS_KEY_ID``, ``AWS_SECRET_ACCESS_KEY``, ``AWS_SESSION_TOKEN``, ``AWS_REGION``.

Nothing torn is ever taken for whole. An object appears when its last byte has come, and bears the digest that it shall
have: one that a closing program left too short (Arrow closes what was begun, it cannot give it up) has not the size that
its reference names. Every download is hashed.
"""

import hashlib
import mmap
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, Final

import pyarrow as pa
from pyarrow import fs

from storage.atomic import write_temp
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.secrets import has_login, without_login
from storage.store import Content
from storage.store_cache import StoreCache

SCHEME: Final = "s3://"
VARIABLES: Final = (
    "AWS_ENDPOINT_URL_S3",
    "AWS_ENDPOINT_URL",
    "AWS_ACCESS_KEY_ID",
    "AWS_SECRET_ACCESS_KEY",
    "AWS_SESSION_TOKEN",
    "AWS_REGION",
    "AWS_DEFAULT_REGION",
)
"""Of the environment: which server, and who we are there."""

CONNECT_TIMEOUT_S: Final = 5.0
ATTEMPTS: Final = 4
PIECE_BYTES: Final = 8 << 20

# the type of an object is the one thing that Arrow lets us keep beside it
_TYPE: Final = "Content-Type"
_BYTES: Final = "application/octet-stream"


@dataclass(frozen=True, slots=True)
class S3Store:
    """Objects below a prefix of a bucket, and the cache of this machine before it."""

    bucket_path: str
    cache: StoreCache
    filesystem: fs.S3FileSystem = field(repr=False)

    @property
    def place(self) -> str:
        """The bucket and prefix as s3://bucket/prefix."""
        return f"{SCHEME}{self.bucket_path}"

    @property
    def incoming(self) -> Path:
        """A file in the cache, where a temp stays when it was uploaded."""
        return self.cache.incoming

    def put(self, name: str, content: bytes) -> None:
        """Keep bytes under a name."""
        self._upload(name, content, _BYTES)

    def take(self, name: str, temp: Path, content: Content) -> None:
        """Upload a finished temp if need be, and move it to the cache."""
        if not self.is_whole(name, content):
            self._upload_file(name, temp, content)
        self.cache.take(name, temp, content)

    def put_file(self, name: str, source: Path, content: Content) -> None:
        """Upload a file if need be; it is not put into the cache."""
        if self.is_whole(name, content):
            return
        if file_sha256(source) != content.sha256:
            raise StorageError(f"{source} changed while it was taken into {self.place}; run again")
        self._upload_file(name, source, content)

    def get(self, name: str) -> bytes | None:
        """Read an object; None where there is none."""
        with self._faults(name):
            try:
                with self.filesystem.open_input_file(self._key(name)) as file:
                    return bytes(file.read())
            except FileNotFoundError:
                return None

    def local_path(self, name: str, content: Content) -> Path:
        """Give the object in the cache, downloaded and checked if it is not there.

        An object that does not hold what it shall is removed, so that the next run computes it anew.
        """
        held = self.cache.find(name, content)
        return held if held is not None else self._download(name, content)

    def size(self, name: str) -> int | None:
        """Bytes of an object; None where there is none."""
        label = self._label(name)
        return None if label is None else label.size

    def names(self, folder: str) -> Iterator[str]:
        """All names in a folder and below it, sorted."""
        with self._faults(folder):
            found = self.filesystem.get_file_info(
                fs.FileSelector(self._key(folder), recursive=True, allow_not_found=True)
            )
        files = (info.path for info in found if info.type == fs.FileType.File)
        yield from sorted(path.removeprefix(f"{self.bucket_path}/") for path in files)

    def remove(self, name: str) -> None:
        """Forget a name."""
        with self._faults(name):
            try:
                self.filesystem.delete_file(self._key(name))
            except FileNotFoundError:
                return

    def is_whole(self, name: str, content: Content) -> bool:
        """Whether an object of that size and with the label of that digest is there: one request, nothing is read."""
        return self._label(name) == content

    def is_whole_by_hash(self, name: str, content: Content) -> bool:
        """Whether the object is there by its digest: it is read as a whole."""
        return self._label(name) is not None and _digest_of(self._pieces(name)) == content

    def _upload_file(self, name: str, path: Path, content: Content) -> None:
        if content.size == 0:
            self._upload(name, b"", _labelled(content))
            return
        with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
            if len(mapped) != content.size:
                raise StorageError(f"{path} has {len(mapped)} bytes, needed are {content.size}; run again")
            self._upload(name, mapped, _labelled(content))

    def _upload(self, name: str, content: bytes | mmap.mmap, kind: str) -> None:
        """Write all bytes in one call: between two, a signal could close the object half-written."""
        with self._faults(name):
            stream = self.filesystem.open_output_stream(self._key(name), metadata={_TYPE: kind})
            try:
                stream.write(pa.py_buffer(content))
            finally:
                stream.close()

    def _download(self, name: str, content: Content) -> Path:
        came: list[Content] = []

        def write(file: BinaryIO) -> None:
            came.append(_digest_of(self._pieces(name), file.write))

        temp = write_temp(self.cache.incoming, write)
        if came[0] != content:
            temp.unlink()
            self.remove(name)
            raise StorageError(
                f"{self.place}/{name} is damaged (its digest is not the one in its name) and was removed; run again to "
                "compute it anew"
            )
        return self.cache.take(name, temp, content)

    def _pieces(self, name: str) -> Iterator[bytes]:
        with self._faults(name):
            try:
                with self.filesystem.open_input_stream(self._key(name)) as file:
                    while piece := file.read(PIECE_BYTES):
                        yield piece
            except FileNotFoundError as fault:
                raise StorageError(f"no {self.place}/{name}; run again to compute it anew") from fault

    def _label(self, name: str) -> Content | None:
        """Size of an object and the digest that was written beside it, "" where none was; None without the object."""
        with self._faults(name):
            try:
                with self.filesystem.open_input_file(self._key(name)) as file:
                    kind = file.metadata().get(_TYPE, b"").decode("ascii", errors="replace")
                    return Content(_digest_in(kind), file.size())
            except FileNotFoundError:
                return None

    def _key(self, name: str) -> str:
        return f"{self.bucket_path}/{name}"

    @contextmanager
    def _faults(self, name: str) -> Iterator[None]:
        """Turn what Arrow raises into a StorageError that says what to look at."""
        try:
            yield
        except (OSError, pa.ArrowException) as fault:
            server = endpoint_url() or "AWS"
            raise StorageError(
                f"cannot use {self.place}/{name} on {server}: {fault}; check that the bucket exists, AWS_ENDPOINT_URL, "
                "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and the network, and run again"
            ) from fault


def open_s3_store(place: str, cache: StoreCache) -> S3Store:
    """Open the store at s3://bucket/prefix; nothing is asked of the server yet.

    Raises
    ------
    StorageError
        If the place names no bucket, or the environment no usable server.
    """
    bucket_path = place.removeprefix(SCHEME).rstrip("/")
    if not place.startswith(SCHEME) or not re.fullmatch(
        r"[a-z0-9][a-z0-9.-]{1,61}[a-z0-9](/[^/\s]+)*", bucket_path
    ):
        raise StorageError(f"a store on S3 needs s3://BUCKET/PREFIX; got {place!r}")
    return S3Store(bucket_path, cache, _filesystem())


def endpoint_url() -> str | None:
    """The server that the environment names; None for AWS."""
    return os.environ.get("AWS_ENDPOINT_URL_S3") or os.environ.get("AWS_ENDPOINT_URL") or None


def _filesystem() -> fs.S3FileSystem:
    how: dict[str, Any] = {
        "connect_timeout": CONNECT_TIMEOUT_S,
        "retry_strategy": fs.AwsStandardS3RetryStrategy(max_attempts=ATTEMPTS),
        # a small object is then one request, and appears at once
        "allow_delayed_open": True,
    }
    region = os.environ.get("AWS_REGION") or os.environ.get("AWS_DEFAULT_REGION")
    url = endpoint_url()
    if url is not None and has_login(url):
        raise StorageError(
            f"AWS_ENDPOINT_URL {without_login(url)} carries a login; put it into AWS_ACCESS_KEY_ID and "
            "AWS_SECRET_ACCESS_KEY"
        )
    if url is not None:
        scheme, separator, address = url.partition("://")
        if separator == "" or scheme not in {"http", "https"}:
            raise StorageError(f"AWS_ENDPOINT_URL needs http://HOST:PORT or https://HOST; got {url!r}")
        how |= {"scheme": scheme, "endpoint_override": address.rstrip("/"), "region": region or "us-east-1"}
    elif region:
        how["region"] = region
    return fs.S3FileSystem(**how)


def _labelled(content: Content) -> str:
    return f"{_BYTES}; sha256={content.sha256}"


def _digest_in(kind: str) -> str:
    found = re.search(r"sha256=([0-9a-f]{64})", kind)
    return found[1] if found else ""


def _digest_of(pieces: Iterator[bytes], then: Callable[[bytes], object] = len) -> Content:
    digest, size = hashlib.sha256(), 0
    for piece in pieces:
        digest.update(piece)
        size += len(piece)
        then(piece)
    return Content(digest.hexdigest(), size)
