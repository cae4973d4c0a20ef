"""Results of stages, stored under the SHA-256 of their bytes: artifacts/ab/<sha256>.<ext>.

They lie in the store of the workspace: its own folder, from which they are read without a copy, or a place elsewhere.
"""

import hashlib
import json
import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from storage.atomic import Writer, write_temp
from storage.errors import StorageError
from storage.parquet import encode_rows, read_rows
from storage.places import store_of
from storage.store import Content
from storage.workspace import Workspace

Row = TypeVar("Row")
Number: TypeAlias = np.bool_ | np.integer | np.floating
JsonValue: TypeAlias = bool | int | float | str | Sequence["JsonValue"] | Mapping[str, "JsonValue"] | None


@dataclass(frozen=True, slots=True)
class ArtifactRef:
    """What stands for an artifact between the stages; equal content has an equal digest."""

    kind: str
    sha256: str
    size: int
    ext: str

    def __post_init__(self) -> None:
        # a ref may come from a file; its parts become a path
        if not re.fullmatch(r"[0-9a-f]{64}", self.sha256) or not re.fullmatch(r"[a-z0-9]{1,16}", self.ext):
            raise StorageError(
                f"reference to artifact {self.kind!r} needs a SHA-256 in hex and an extension of letters and "
                f"digits; got {self.sha256!r} and {self.ext!r}"
            )

    @property
    def name(self) -> str:
        """What the store calls it."""
        return f"artifacts/{self.sha256[:2]}/{self.sha256}.{self.ext}"

    @property
    def content(self) -> Content:
        """What the store must hold under that name."""
        return Content(self.sha256, self.size)

    def to_json(self) -> dict[str, str | int]:
        """Plain values, for a stage's result."""
        return {"kind": self.kind, "sha256": self.sha256, "size": self.size, "ext": self.ext}

    @classmethod
    def from_json(cls, value: object) -> "ArtifactRef":
        """Read what ``to_json`` gave.

        Raises
        ------
        StorageError
            If it is something else.
        """
        match value:
            case {"kind": str(kind), "sha256": str(sha256), "size": int(size), "ext": str(ext)}:
                return cls(kind, sha256, size, ext)
        raise StorageError(f"needed a reference with kind, sha256, size and ext; got {value!r}")


def artifact_path(ws: Workspace, ref: ArtifactRef) -> Path:
    """Where the artifact lies or would lie in the folder of the workspace."""
    return ws.root / ref.name


def put_array(ws: Workspace, kind: str, array: NDArray[Number]) -> ArtifactRef:
    """Store an array of numbers as .npy: little-endian, C order, no pickle, so that equal arrays are equal bytes.

    Raises
    ------
    StorageError
        If the array does not hold booleans, integers or floats, or the disk refuses.
    """
    if array.dtype.kind not in "biuf":
        raise StorageError(f"artifact {kind!r} needs an array of numbers; got dtype {array.dtype}")
    plain = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).reshape(array.shape)

    def write(file: BinaryIO) -> None:
        np.lib.format.write_array(file, plain, version=(1, 0), allow_pickle=False)

    return put_written(ws, kind, "npy", write)


def get_array(ws: Workspace, ref: ArtifactRef) -> NDArray[Number]:
    """Load a stored array.

    Raises
    ------
    StorageError
        If it is absent or damaged.
    """
    return _loaded(ws, ref, None)


def map_array(ws: Workspace, ref: ArtifactRef) -> NDArray[Number]:
    """Map a stored array read-only into memory: for clouds of which a stage needs a part.

    Raises
    ------
    StorageError
        If it is absent or damaged.
    """
    return _loaded(ws, ref, "r")


def put_json(ws: Workspace, kind: str, value: JsonValue) -> ArtifactRef:
    """Store plain values as canonical JSON: sorted keys, shortest floats that read back the same, no NaN.

    Raises
    ------
    StorageError
        If the value holds something else, NaN or an infinity.
    """
    try:
        text = json.dumps(value, sort_keys=True, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
        content = text.encode()
    except (TypeError, ValueError) as fault:
        raise StorageError(f"artifact {kind!r} needs plain JSON values: {fault}") from fault
    return put_written(ws, kind, "json", content)


def get_json(ws: Workspace, ref: ArtifactRef) -> JsonValue:
    """Load stored plain values.

    Raises
    ------
    StorageError
        If they are absent or damaged.
    """
    path = present_artifact(ws, ref)
    try:
        value: JsonValue = json.loads(path.read_bytes())
    except ValueError as fault:
        raise damaged_artifact(path, str(fault)) from fault
    return value


def put_rows(ws: Workspace, kind: str, record: type[Row], rows: Sequence[Row]) -> ArtifactRef:
    """Store rows of a record class as Parquet.

    Raises
    ------
    StorageError
        If a value may not be stored: see ``storage.parquet.table_from_rows``.
    """
    return put_written(ws, kind, "parquet", encode_rows(kind, record, rows))


def get_rows(ws: Workspace, ref: ArtifactRef, record: type[Row]) -> list[Row]:
    """Load stored rows.

    Raises
    ------
    StorageError
        If they are absent, damaged or of another kind.
    """
    return read_rows(present_artifact(ws, ref), ref.kind, record)


def put_file(ws: Workspace, kind: str, source: Path) -> ArtifactRef:
    """Store a copy of a file.

    Raises
    ------
    StorageError
        If the file cannot be read or has no plain extension.
    """
    if not source.is_file():
        raise StorageError(f"artifact {kind!r} needs a file; there is none at {source}")

    def write(file: BinaryIO) -> None:
        with source.open("rb") as content:
            shutil.copyfileobj(content, file, 1 << 20)

    return put_written(ws, kind, source.suffix.removeprefix(".").lower(), write)


def is_whole(ws: Workspace, ref: ArtifactRef) -> bool:
    """Whether the artifact is there with the right size and digest; one that is unchanged is not hashed again."""
    return store_of(ws).is_whole(ref.name, ref.content)


def is_whole_by_hash(ws: Workspace, ref: ArtifactRef) -> bool:
    """Whether the artifact is there with the right size and digest, whatever was found before."""
    return store_of(ws).is_whole_by_hash(ref.name, ref.content)


class _HashingFile:
    """A file that hashes and counts what is written to it; NumPy writes to it in pieces."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.digest = hashlib.sha256()
        self.size = 0

    def write(self, content: bytes) -> int:
        self.digest.update(content)
        self.size += len(content)
        return self._file.write(content)


def put_written(ws: Workspace, kind: str, ext: str, content: bytes | Writer) -> ArtifactRef:
    """Store bytes, or what a function writes to the file that it is given; the digest is computed on the way.

    Raises
    ------
    StorageError
        If the disk refuses; whatever the function raises goes through, and nothing is stored.
    """
    written: list[_HashingFile] = []

    def write(file: BinaryIO) -> None:
        hashing = _HashingFile(file)
        written.append(hashing)
        if isinstance(content, bytes):
            hashing.write(content)
        else:
            content(hashing)  # type: ignore[arg-type]

    store = store_of(ws)
    temp = write_temp(store.incoming, write)
    try:
        ref = ArtifactRef(kind, written[0].digest.hexdigest(), written[0].size, ext)
        store.take(ref.name, temp, ref.content)
    finally:
        temp.unlink(missing_ok=True)
    return ref


def present_artifact(ws: Workspace, ref: ArtifactRef) -> Path:
    """File of an artifact on this machine, of the right size.

    Raises
    ------
    StorageError
        If it is absent or of another size.
    """
    try:
        return store_of(ws).local_path(ref.name, ref.content)
    except StorageError as fault:
        raise StorageError(f"artifact {ref.kind!r}: {fault}") from fault


def _loaded(ws: Workspace, ref: ArtifactRef, mode: Literal["r"] | None) -> NDArray[Number]:
    path = present_artifact(ws, ref)
    try:
        array: NDArray[Number] = np.load(path, mmap_mode=mode, allow_pickle=False)
    except (OSError, ValueError, EOFError) as fault:
        raise damaged_artifact(path, str(fault)) from fault
    return array


def damaged_artifact(path: Path, what: str) -> StorageError:
    """Fault of an artifact that is not what was stored, with the way out."""
    return StorageError(f"artifact {path} is damaged ({what}); delete it and run again to compute it anew")
