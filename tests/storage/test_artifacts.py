"""What is stored under a digest comes back, or is known to be damaged."""

import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from storage import folder_store
from storage.artifacts import (
    ArtifactRef,
    artifact_path,
    get_array,
    get_json,
    get_rows,
    is_whole,
    is_whole_by_hash,
    map_array,
    put_array,
    put_file,
    put_json,
    put_rows,
)
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.records import TiltRow
from storage.workspace import Workspace
from tests.storage.campaign import tilt_row

CLOUD = np.arange(30.0).reshape(10, 3)


def flip_a_byte(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize(
    "array",
    [
        CLOUD,
        np.empty((0, 3)),
        np.array(3.5),
        np.array([True, False]),
        np.arange(4, dtype=np.int32),
        CLOUD[:, ::2],
    ],
)
@pytest.mark.parametrize("get", [get_array, map_array])
def test_arrays_come_back_with_shape_and_type(ws: Workspace, array: np.ndarray, get: object) -> None:
    found = get(ws, put_array(ws, "cloud", array))  # type: ignore[operator]
    np.testing.assert_array_equal(found, array, strict=True)


def test_a_mapped_array_cannot_be_written_to(ws: Workspace) -> None:
    mapped = map_array(ws, put_array(ws, "cloud", CLOUD))
    with pytest.raises(ValueError, match="read-only"):
        mapped[0, 0] = 1.0


def test_the_name_is_the_digest_of_the_bytes(ws: Workspace) -> None:
    ref = put_array(ws, "cloud", CLOUD)
    path = artifact_path(ws, ref)
    assert path == ws.artifacts / ref.sha256[:2] / f"{ref.sha256}.npy"
    assert file_sha256(path) == ref.sha256
    assert path.stat().st_size == ref.size


def test_equal_arrays_have_equal_digests_whatever_their_layout(ws: Workspace) -> None:
    layouts = [CLOUD, np.asfortranarray(CLOUD), CLOUD.astype(">f8"), np.repeat(CLOUD, 2, axis=0)[::2]]
    assert len({put_array(ws, "cloud", array).sha256 for array in layouts}) == 1


def test_objects_are_refused(ws: Workspace) -> None:
    with pytest.raises(StorageError, match="needs an array of numbers; got dtype object"):
        put_array(ws, "cloud", np.array([{}]))


def test_json_is_canonical_and_floats_read_back_the_same(ws: Workspace) -> None:
    value = {"b": [0.1 + 0.2, 1e-320, -0.0, 7], "a": None, "ä": "ß"}
    ref = put_json(ws, "pose", value)
    assert get_json(ws, ref) == value
    assert put_json(ws, "pose", dict(reversed(value.items()))) == ref


@pytest.mark.parametrize("value", [math.nan, {"x": math.inf}, {"x": object()}, np.float32(1.0)])
def test_json_refuses_what_it_cannot_say(ws: Workspace, value: object) -> None:
    with pytest.raises(StorageError, match="artifact 'pose' needs plain JSON values"):
        put_json(ws, "pose", value)  # type: ignore[arg-type]


def test_rows_come_back(ws: Workspace) -> None:
    rows = [tilt_row("e0"), tilt_row("e1")]
    ref = put_rows(ws, "axes", TiltRow, rows)
    assert get_rows(ws, ref, TiltRow) == rows
    assert put_rows(ws, "axes", TiltRow, list(rows)) == ref


def test_a_file_is_copied_in(ws: Workspace, tmp_path: Path) -> None:
    (tmp_path / "ST01.LAZ").write_bytes(b"points")
    ref = put_file(ws, "scan", tmp_path / "ST01.LAZ")
    assert ref.ext == "laz"
    assert artifact_path(ws, ref).read_bytes() == b"points"


def test_a_reference_survives_json() -> None:
    ref = ArtifactRef("cloud", "ab" * 32, 12, "npy")
    assert ArtifactRef.from_json(ref.to_json()) == ref


@pytest.mark.parametrize(
    "value", [None, {}, {"kind": "cloud", "sha256": "ab" * 32, "size": "12", "ext": "npy"}]
)
def test_what_is_no_reference_is_refused(value: object) -> None:
    with pytest.raises(StorageError, match="needed a reference with kind, sha256, size and ext"):
        ArtifactRef.from_json(value)


def test_a_reference_cannot_lead_out_of_the_store() -> None:
    with pytest.raises(StorageError, match="needs a SHA-256 in hex"):
        ArtifactRef.from_json({"kind": "cloud", "sha256": "../../x", "size": 1, "ext": "npy"})


def test_an_absent_artifact_is_told(ws: Workspace) -> None:
    ref = put_array(ws, "cloud", CLOUD)
    artifact_path(ws, ref).unlink()
    assert not is_whole(ws, ref)
    with pytest.raises(StorageError, match=r"artifact 'cloud': no .*run again to compute it anew"):
        get_array(ws, ref)


def test_a_torn_artifact_is_told(ws: Workspace) -> None:
    ref = put_array(ws, "cloud", CLOUD)
    os.truncate(artifact_path(ws, ref), ref.size - 8)
    assert not is_whole(ws, ref)
    with pytest.raises(StorageError, match="is damaged"):
        get_array(ws, ref)


def test_a_flipped_byte_is_seen_right_after_the_artifact_was_found_whole(ws: Workspace) -> None:
    ref = put_array(ws, "cloud", CLOUD)
    assert is_whole(ws, ref)
    flip_a_byte(artifact_path(ws, ref))
    assert not is_whole(ws, ref)


def test_a_byte_flipped_behind_an_unchanged_time_is_seen_by_hash(ws: Workspace) -> None:
    ref = put_array(ws, "cloud", CLOUD)
    path = artifact_path(ws, ref)
    stat = path.stat()
    flip_a_byte(path)
    os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert not is_whole_by_hash(ws, ref)
    assert not is_whole(ws, ref), "what was found damaged is not remembered as whole"


def test_storing_again_heals_a_damaged_artifact(ws: Workspace) -> None:
    ref = put_array(ws, "cloud", CLOUD)
    flip_a_byte(artifact_path(ws, ref))
    assert put_array(ws, "cloud", CLOUD) == ref
    assert is_whole_by_hash(ws, ref)


def test_an_unchanged_artifact_is_not_hashed_again(ws: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    ref = put_array(ws, "cloud", CLOUD)
    hashed: list[Path] = []
    monkeypatch.setattr(folder_store, "file_sha256", lambda path: hashed.append(path) or file_sha256(path))
    assert is_whole(ws, ref)
    assert hashed == []
    assert is_whole_by_hash(ws, ref)
    assert len(hashed) == 1


def test_a_wrong_size_in_the_reference_is_not_whole(ws: Workspace) -> None:
    ref = put_array(ws, "cloud", CLOUD)
    assert not is_whole(ws, replace(ref, size=ref.size + 1))


def test_a_torn_memory_of_what_was_verified_costs_a_hash_only(ws: Workspace) -> None:
    ref = put_array(ws, "cloud", CLOUD)
    (ws.artifacts / "verified.txt").write_bytes(b"garbage\n" + f"{ref.sha256}.npy 1 2".encode())
    assert is_whole(ws, ref)


def test_a_write_that_fails_leaves_nothing_in_the_store(ws: Workspace, tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="needs a file; there is none"):
        put_file(ws, "scan", tmp_path / "none.laz")
    assert list(ws.artifacts.iterdir()) == []
