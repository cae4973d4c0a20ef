"""Results of stages, stored under the SHA-256 of their bytes: artifacts/ab/<sha256>.<ext>."""

import hashlib
import json
import os
import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final, Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from storage.atomic import Writer, faults_of_the_system, make_folder, replace_file, sync_folder, write_temp
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.parquet import encode_rows, read_rows
from storage.verified import forget, is_remembered, remember
from storage.workspace import Workspace

Row = TypeVar("Row")
Number: TypeAlias = np.bool_ | np.integer | np.floating
JsonValue: TypeAlias = bool | int | float | str | Sequence["JsonValue"] | Mapping[str, "JsonValue"] | None

# an artifact is dated back, so that a change in the same tick of the clock still changes its time
_DATED_BACK_NS: Final = 10_000_000_000


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
    """Where the artifact lies or would lie."""
    return ws.artifacts / ref.sha256[:2] / f"{ref.sha256}.{ref.ext}"


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

    return _put(ws, kind, "npy", write)


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
    return _put(ws, kind, "json", content)


def get_json(ws: Workspace, ref: ArtifactRef) -> JsonValue:
    """Load stored plain values.

    Raises
    ------
    StorageError
        If they are absent or damaged.
    """
    path = _present(ws, ref)
    try:
        value: JsonValue = json.loads(path.read_bytes())
    except ValueError as fault:
        raise _damaged(path, str(fault)) from fault
    return value


def put_rows(ws: Workspace, kind: str, record: type[Row], rows: Sequence[Row]) -> ArtifactRef:
    """Store rows of a record class as Parquet.

    Raises
    ------
    StorageError
        If a value may not be stored: see ``storage.parquet.table_from_rows``.
    """
    return _put(ws, kind, "parquet", encode_rows(kind, record, rows))


def get_rows(ws: Workspace, ref: ArtifactRef, record: type[Row]) -> list[Row]:
    """Load stored rows.

    Raises
    ------
    StorageError
        If they are absent, damaged or of another kind.
    """
    return read_rows(_present(ws, ref), ref.kind, record)


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

    return _put(ws, kind, source.suffix.removeprefix(".").lower(), write)


def is_whole(ws: Workspace, ref: ArtifactRef) -> bool:
    """Whether the artifact is there with the right size and digest; one that is unchanged is not hashed again."""
    path = artifact_path(ws, ref)
    if not _has_size(path, ref.size):
        return False
    return is_remembered(ws, path) or is_whole_by_hash(ws, ref)


def is_whole_by_hash(ws: Workspace, ref: ArtifactRef) -> bool:
    """Whether the artifact is there with the right size and digest, whatever was found before."""
    path = artifact_path(ws, ref)
    return _has_size(path, ref.size) and has_its_digest(ws, path)


def has_its_digest(ws: Workspace, path: Path) -> bool:
    """Whether a file of the store holds what its name says; the answer is remembered."""
    if file_sha256(path) != path.name.split(".")[0]:
        forget(ws, path)
        return False
    if not is_remembered(ws, path):
        remember(ws, path)
    return True


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


def _put(ws: Workspace, kind: str, ext: str, content: bytes | Writer) -> ArtifactRef:
    written: list[_HashingFile] = []

    def write(file: BinaryIO) -> None:
        hashing = _HashingFile(file)
        written.append(hashing)
        if isinstance(content, bytes):
            hashing.write(content)
        else:
            content(hashing)  # type: ignore[arg-type]

    temp = write_temp(ws.artifacts / "incoming", write)
    ref = ArtifactRef(kind, written[0].digest.hexdigest(), written[0].size, ext)
    if is_whole(ws, ref):
        temp.unlink()
    else:
        _take_in(ws, temp, artifact_path(ws, ref))
    return ref


def _take_in(ws: Workspace, temp: Path, path: Path) -> None:
    with faults_of_the_system(path):
        stat = temp.stat()
        os.utime(temp, ns=(stat.st_atime_ns, stat.st_mtime_ns - _DATED_BACK_NS))
    make_folder(path.parent)
    replace_file(temp, path)
    sync_folder(path.parent)
    remember(ws, path)


def _has_size(path: Path, size: int) -> bool:
    return path.is_file() and path.stat().st_size == size


def _present(ws: Workspace, ref: ArtifactRef) -> Path:
    path = artifact_path(ws, ref)
    if not path.is_file():
        raise StorageError(f"artifact {ref.kind!r} is absent: no {path}; run again to compute it anew")
    if path.stat().st_size != ref.size:
        raise _damaged(path, f"needed {ref.size} bytes, it has {path.stat().st_size}")
    return path


def _loaded(ws: Workspace, ref: ArtifactRef, mode: Literal["r"] | None) -> NDArray[Number]:
    path = _present(ws, ref)
    try:
        array: NDArray[Number] = np.load(path, mmap_mode=mode, allow_pickle=False)
    except (OSError, ValueError, EOFError) as fault:
        raise _damaged(path, str(fault)) from fault
    return array


def _damaged(path: Path, what: str) -> StorageError:
    return StorageError(f"artifact {path} is damaged ({what}); delete it and run again to compute it anew")
