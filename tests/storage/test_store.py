"""What every store promises, on a folder and on a real S3 server."""

import hashlib
import os
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from storage.artifacts import get_array, get_json, is_whole, map_array, put_array, put_json
from storage.errors import StorageError
from storage.folder_store import FolderStore
from storage.places import IDENTITY, check_store, store_at, workspace_at
from storage.s3_store import S3Store
from storage.scan_files import offer_scan, scan_at
from storage.store import Content, Store
from storage.store_cache import StoreCache, cache_of_machine
from storage.verify import verify_workspace_deeply
from storage.workspace import Workspace, open_workspace
from tests.s3_server import S3Endpoint
from tests.storage.s3_places import new_place, use_endpoint

CONTENT = b"points of a scan" * 1000


def content_of(data: bytes) -> Content:
    return Content(hashlib.sha256(data).hexdigest(), len(data))


def name_of(data: bytes) -> str:
    sha256 = content_of(data).sha256
    return f"artifacts/{sha256[:2]}/{sha256}.npy"


NAME = name_of(CONTENT)


@pytest.fixture
def s3_place(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """An empty prefix on the S3 server, with a cache of its own."""
    endpoint: S3Endpoint = request.getfixturevalue("s3_endpoint")
    use_endpoint(endpoint, tmp_path / "cache", monkeypatch)
    return new_place(endpoint)


@pytest.fixture(params=["folder", "s3"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Store:
    if request.param == "folder":
        return FolderStore(tmp_path / "store")
    return store_at(request.getfixturevalue("s3_place"))


@pytest.fixture
def s3_store(s3_place: str) -> S3Store:
    store = store_at(s3_place)
    assert isinstance(store, S3Store)
    return store


def take(store: Store, data: bytes) -> None:
    store.incoming.parent.mkdir(parents=True, exist_ok=True)
    temp = store.incoming.with_name(f"one.{time.time_ns()}.tmp")
    temp.write_bytes(data)
    store.take(name_of(data), temp, content_of(data))
    assert not temp.exists()


def test_bytes_come_back_under_their_name_and_the_last_ones_count(store: Store) -> None:
    assert store.get("records/one") is None
    store.put("records/one", b"first")
    store.put("records/one", b"second")
    assert store.get("records/one") == b"second"
    assert store.size("records/one") == 6


def test_what_is_not_there_has_no_size_and_may_be_removed(store: Store) -> None:
    assert store.size("records/none") is None
    store.remove("records/none")


def test_what_was_removed_is_gone(store: Store) -> None:
    store.put("records/one", b"x")
    store.remove("records/one")
    assert store.get("records/one") is None
    assert list(store.names("records")) == []


def test_names_are_those_of_the_folder_and_below_in_order(store: Store) -> None:
    for name in ("records/b", "records/a", "artifacts/ab/c.npy", "else"):
        store.put(name, b"x")
    assert list(store.names("records")) == ["records/a", "records/b"]
    assert list(store.names("artifacts")) == ["artifacts/ab/c.npy"]
    assert list(store.names("nowhere")) == []


def test_a_taken_file_is_whole_and_can_be_read_here(store: Store) -> None:
    take(store, CONTENT)
    assert store.is_whole(NAME, content_of(CONTENT))
    assert store.is_whole_by_hash(NAME, content_of(CONTENT))
    assert store.local_path(NAME, content_of(CONTENT)).read_bytes() == CONTENT


def test_a_file_of_ours_stays_where_it_is_when_it_is_copied_in(store: Store, tmp_path: Path) -> None:
    scan = tmp_path / "ST01.laz"
    scan.write_bytes(CONTENT)
    store.put_file(NAME, scan, content_of(CONTENT))
    assert scan.read_bytes() == CONTENT
    assert store.local_path(NAME, content_of(CONTENT)).read_bytes() == CONTENT


def test_a_file_that_changed_since_it_was_hashed_is_refused(store: Store, tmp_path: Path) -> None:
    scan = tmp_path / "ST01.laz"
    scan.write_bytes(CONTENT[::-1])
    with pytest.raises(StorageError, match="changed while it was"):
        store.put_file(NAME, scan, content_of(CONTENT))
    assert store.size(NAME) is None


def test_an_empty_file_is_a_file(store: Store) -> None:
    take(store, b"")
    assert store.is_whole(name_of(b""), content_of(b""))
    assert store.local_path(name_of(b""), content_of(b"")).read_bytes() == b""


def test_content_that_is_absent_short_or_other_is_not_whole(store: Store) -> None:
    assert not store.is_whole(NAME, content_of(CONTENT))
    store.put(NAME, CONTENT[:-1])
    assert not store.is_whole(NAME, content_of(CONTENT))
    store.put(NAME, CONTENT[::-1])
    assert not store.is_whole(NAME, content_of(CONTENT))
    assert not store.is_whole_by_hash(NAME, content_of(CONTENT))


def test_taking_again_heals_what_is_not_whole(store: Store) -> None:
    store.put(NAME, CONTENT[:-1])
    take(store, CONTENT)
    assert store.is_whole_by_hash(NAME, content_of(CONTENT))


def test_absent_content_is_told(store: Store) -> None:
    with pytest.raises(StorageError, match=r"no .*; run again"):
        store.local_path(NAME, content_of(CONTENT))


def test_many_writers_of_one_name_leave_it_whole(store: Store) -> None:
    data = os.urandom(100_000)
    with ThreadPoolExecutor(6) as pool:
        list(pool.map(lambda _: take(store, data), range(18)))
    assert store.is_whole_by_hash(name_of(data), content_of(data))


def test_a_reader_never_sees_a_half_written_object(store: Store) -> None:
    versions = [bytes([n]) * 300_000 for n in range(4)]
    store.put("records/one", versions[0])
    done = threading.Event()

    def write() -> None:
        for version in versions * 3:
            store.put("records/one", version)
        done.set()

    writer = threading.Thread(target=write)
    writer.start()
    seen: set[bytes | None] = set()
    while not done.is_set():
        seen.add(store.get("records/one"))
    writer.join()
    assert seen <= set(versions)


def test_a_download_that_does_not_hold_what_its_name_says_is_removed(s3_store: S3Store) -> None:
    # same size, other bytes, under the label of the right ones
    bad = CONTENT[::-1]
    kind = f"application/octet-stream; sha256={content_of(CONTENT).sha256}"
    with s3_store.filesystem.open_output_stream(
        f"{s3_store.bucket_path}/{NAME}", metadata={"Content-Type": kind}
    ) as file:
        file.write(bad)
    assert s3_store.is_whole(NAME, content_of(CONTENT)), "one request cannot see it"
    assert not s3_store.is_whole_by_hash(NAME, content_of(CONTENT))
    with pytest.raises(StorageError, match=r"is damaged .* and was removed; run again"):
        s3_store.local_path(NAME, content_of(CONTENT))
    assert not s3_store.is_whole(NAME, content_of(CONTENT))
    assert not list(s3_store.incoming.parent.glob("*.tmp"))


def test_an_upload_that_breaks_off_is_not_taken_for_whole(s3_store: S3Store) -> None:
    """Arrow closes what is given up, and what came so far appears: it has the label, and not the size."""
    kind = f"application/octet-stream; sha256={content_of(CONTENT).sha256}"
    stream = s3_store.filesystem.open_output_stream(
        f"{s3_store.bucket_path}/{NAME}", metadata={"Content-Type": kind}
    )
    stream.write(CONTENT[:100])
    assert s3_store.size(NAME) is None, "nothing is seen before the end"
    del stream
    assert s3_store.size(NAME) == 100
    assert not s3_store.is_whole(NAME, content_of(CONTENT))


def test_what_is_in_the_cache_is_not_downloaded_again(s3_store: S3Store) -> None:
    take(s3_store, CONTENT)
    s3_store.remove(NAME)
    assert s3_store.local_path(NAME, content_of(CONTENT)).read_bytes() == CONTENT


def test_a_byte_flipped_in_the_cache_is_downloaded_again(s3_store: S3Store) -> None:
    take(s3_store, CONTENT)
    held = s3_store.local_path(NAME, content_of(CONTENT))
    held.write_bytes(CONTENT[::-1])
    assert s3_store.local_path(NAME, content_of(CONTENT)).read_bytes() == CONTENT


def test_the_cache_keeps_to_its_limit_and_throws_out_what_was_unused_for_longest(tmp_path: Path) -> None:
    cache = StoreCache(tmp_path / "cache", limit_bytes=5000, in_use_s=0.0)
    held = [os.urandom(1000) for _ in range(9)]
    for number, data in enumerate(held):
        temp = tmp_path / "temp"
        temp.write_bytes(data)
        path = cache.take(name_of(data), temp, content_of(data))
        os.utime(path, ns=(number * 10**9, path.stat().st_mtime_ns))
        assert cache.find(name_of(held[0]), content_of(held[0])) is not None, "it is used all the time"
    files = list((tmp_path / "cache").glob("artifacts/*/*"))
    assert sum(path.stat().st_size for path in files) <= 5000
    assert cache.find(name_of(held[1]), content_of(held[1])) is None


def test_the_cache_throws_nothing_out_that_a_stage_may_be_reading(tmp_path: Path) -> None:
    cache = StoreCache(tmp_path / "cache", limit_bytes=1000)
    held = [os.urandom(1000) for _ in range(3)]
    for data in held:
        (tmp_path / "temp").write_bytes(data)
        cache.take(name_of(data), tmp_path / "temp", content_of(data))
    assert all(cache.find(name_of(data), content_of(data)) for data in held)


@pytest.mark.parametrize("text", ["much", "0", "-1", "nan", "inf"])
def test_a_bad_limit_of_the_cache_is_told(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv("TILTWATCH_CACHE_GB", text)
    with pytest.raises(StorageError, match="TILTWATCH_CACHE_GB needs a number of gigabytes above 0"):
        cache_of_machine()


@pytest.fixture(params=["folder", "s3"])
def workspace(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Workspace]:
    folder = open_workspace(tmp_path / "ws")
    if request.param == "folder":
        yield workspace_at(str(folder.root))
    else:
        yield workspace_at(request.getfixturevalue("s3_place"))


def test_artifacts_have_equal_references_and_content_wherever_they_lie(workspace: Workspace) -> None:
    cloud = np.arange(30.0).reshape(10, 3)
    ref = put_array(workspace, "cloud", cloud)
    np.testing.assert_array_equal(get_array(workspace, ref), cloud, strict=True)
    np.testing.assert_array_equal(map_array(workspace, ref), cloud, strict=True)
    assert put_array(workspace, "cloud", cloud) == ref
    note = put_json(workspace, "note", {"a": [1, 2.5]})
    assert get_json(workspace, note) == {"a": [1, 2.5]}
    assert is_whole(workspace, ref)


def test_another_machine_reads_what_this_one_stored(
    s3_place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ref = put_array(workspace_at(s3_place), "cloud", np.arange(6.0))
    monkeypatch.setenv("TILTWATCH_CACHE", str(tmp_path / "elsewhere"))
    np.testing.assert_array_equal(get_array(workspace_at(s3_place), ref), np.arange(6.0))
    assert (tmp_path / "elsewhere" / ref.name).is_file()


def test_deep_verification_reads_the_store_wherever_it_lies(
    s3_store: S3Store, s3_place: str, tmp_path: Path
) -> None:
    here = Workspace(open_workspace(tmp_path / "ws").root, s3_place)
    ref = put_array(here, "cloud", np.arange(6.0))
    assert verify_workspace_deeply(here).faults == ()
    s3_store.put(ref.name, b"other")
    (fault,) = verify_workspace_deeply(here).faults
    assert fault.where == ref.name


def test_a_scan_reaches_another_machine_by_its_digest(
    s3_place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = tmp_path / "ST01.LAZ"
    scan.write_bytes(CONTENT)
    sha256 = content_of(CONTENT).sha256
    offer_scan(workspace_at(s3_place), scan, sha256)
    scan.unlink()
    monkeypatch.setenv("TILTWATCH_CACHE", str(tmp_path / "elsewhere"))
    there = scan_at(workspace_at(s3_place), scan, sha256, ".LAZ")
    assert there.read_bytes() == CONTENT
    assert there.suffix == ".laz"


def test_a_scan_that_a_worker_does_not_see_is_no_verdict_on_the_scan(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="the machine of this worker has no such file"):
        scan_at(Workspace(tmp_path), tmp_path / "ST01.laz", "ab" * 32, ".laz")


def test_a_store_is_marked_once_and_one_of_a_newer_version_is_refused(s3_place: str) -> None:
    check_store(s3_place)
    check_store(s3_place)
    store_at(s3_place).put(IDENTITY, b'{"schema_version": 99}')
    with pytest.raises(StorageError, match="has schema version 99; this tiltwatch reads up to"):
        check_store(s3_place)
    store_at(s3_place).put(IDENTITY, b"{")
    with pytest.raises(StorageError, match="is damaged"):
        check_store(s3_place)


def test_wrong_keys_and_missing_buckets_are_told(s3_place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        StorageError, match=r"cannot use s3://no-such-bucket/x/.* check that the bucket exists"
    ):
        check_store("s3://no-such-bucket/x")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "wrong")
    with pytest.raises(StorageError, match="AWS_SECRET_ACCESS_KEY"):
        check_store(s3_place)


def test_a_server_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:1")
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "x")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "y")
    with pytest.raises(StorageError, match=r"cannot use s3://bucket/x/.* on http://127.0.0.1:1"):
        check_store("s3://bucket/x")


@pytest.mark.parametrize("place", ["s3://", "s3://B", "s3://bucket//x", "s3://bucket/a b"])
def test_a_place_that_names_no_bucket_is_refused(place: str) -> None:
    with pytest.raises(StorageError, match="needs s3://BUCKET/PREFIX"):
        store_at(place)


def test_a_server_without_a_scheme_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_ENDPOINT_URL", "127.0.0.1:9000")
    with pytest.raises(StorageError, match="AWS_ENDPOINT_URL needs http://HOST:PORT"):
        store_at("s3://bucket/x")
