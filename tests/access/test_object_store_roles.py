"""The policies of infra/ suffice for what tiltwatch does in a bucket, and it asks for nothing beyond its prefix."""

import hashlib
from pathlib import Path

import pytest

from storage.errors import StorageError
from storage.places import IDENTITY, check_store, store_at
from storage.s3_inbox import S3Inbox, parse_s3_url, s3_files
from storage.store import Content
from tests.access.policed import Asked, Police, needed_for, policed, policy
from tests.s3_server import S3Endpoint
from tests.storage.s3_places import BUCKET, new_place, use_endpoint

LARGE = b"0123456789abcdef" * (1 << 20)
"""16 MB: more than one part of an upload."""


@pytest.fixture
def place(s3_endpoint: S3Endpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    use_endpoint(s3_endpoint, tmp_path / "cache", monkeypatch)
    return new_place(s3_endpoint)


def prefix_of(place: str) -> str:
    return place.removeprefix(f"s3://{BUCKET}/")


def name_and_content(data: bytes) -> tuple[str, Content]:
    sha256 = hashlib.sha256(data).hexdigest()
    return f"artifacts/{sha256[:2]}/{sha256}.npy", Content(sha256, len(data))


def assert_within(police: Police, place: str) -> None:
    """Nothing beside the prefix was touched or listed, allowed or not."""
    prefix = prefix_of(place)
    for asked in police.asked:
        if asked.action == "s3:ListBucket":
            assert asked.prefix is not None, asked
            assert asked.prefix.startswith(prefix), asked
        else:
            assert asked.resource.startswith(f"arn:aws:s3:::{BUCKET}/{prefix}"), asked


def test_the_writers_role_suffices_for_all_that_a_store_does(
    place: str, s3_endpoint: S3Endpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with policed(s3_endpoint.url, policy("writer", BUCKET, prefix_of(place))) as police:
        monkeypatch.setenv("AWS_ENDPOINT_URL", police.url)
        check_store(place)
        store = store_at(place)
        source = tmp_path / "scan"
        source.write_bytes(LARGE)
        name, content = name_and_content(LARGE)
        store.put_file(name, source, content)
        store.put("records/key", b"{}")
        assert store.get("records/key") == b"{}"
        assert store.get("records/none") is None
        assert store.local_path(name, content).read_bytes() == LARGE
        assert store.is_whole_by_hash(name, content)
        assert list(store.names("records")) == ["records/key"]
        store.remove("records/key")
        assert list(store.names("records")) == []
    assert police.refused == []
    assert_within(police, place)
    used = {asked.action for asked in police.asked}
    assert used >= {"s3:ListBucket", "s3:GetObject", "s3:PutObject", "s3:DeleteObject"}


def test_the_readers_role_reads_and_cannot_write(
    place: str, s3_endpoint: S3Endpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    check_store(place)
    data = b"points"
    name, content = name_and_content(data)
    (tmp_path / "scan").write_bytes(data)
    store_at(place).put_file(name, tmp_path / "scan", content)
    with policed(s3_endpoint.url, policy("reader", BUCKET, prefix_of(place))) as police:
        monkeypatch.setenv("AWS_ENDPOINT_URL", police.url)
        store = store_at(place)
        assert store.local_path(name, content).read_bytes() == data
        assert list(store.names("artifacts")) == [name]
        assert police.refused == []
        with pytest.raises(StorageError, match="ACCESS_DENIED"):
            store.put("records/key", b"{}")
        with pytest.raises(StorageError, match="ACCESS_DENIED"):
            store.remove(name)
    assert_within(police, place)
    monkeypatch.setenv("AWS_ENDPOINT_URL", s3_endpoint.url)
    assert store_at(place).get(IDENTITY) is not None


def test_a_role_of_one_prefix_cannot_use_another(
    place: str, s3_endpoint: S3Endpoint, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = new_place(s3_endpoint)
    check_store(other)
    with policed(s3_endpoint.url, policy("writer", BUCKET, prefix_of(place))) as police:
        monkeypatch.setenv("AWS_ENDPOINT_URL", police.url)
        for use in (lambda: store_at(other).get(IDENTITY), lambda: list(store_at(other).names("artifacts"))):
            with pytest.raises(StorageError, match="ACCESS_DENIED"):
                use()
    assert police.refused


def test_a_watch_needs_no_more_than_the_writers_role_of_its_inbox(
    place: str, s3_endpoint: S3Endpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with policed(s3_endpoint.url, policy("writer", BUCKET, prefix_of(place))) as police:
        monkeypatch.setenv("AWS_ENDPOINT_URL", police.url)
        inbox = S3Inbox(parse_s3_url(place), tmp_path, s3_files())
        assert inbox.fetch().names == ()
        store_at(place).put("ST01.laz", b"points")
        assert inbox.fetch().names == ("ST01.laz",)
        inbox.set_aside("ST01.laz")
        assert inbox.fetch().names == ()
        monkeypatch.setenv("AWS_ENDPOINT_URL", s3_endpoint.url)
        assert store_at(place).get("taken/ST01.laz") == b"points"
    # whether the bucket is there it may not ask, and need not
    assert {asked.action for asked in police.refused} <= {"s3:ListBucket"}


def test_a_sender_can_send_and_neither_read_nor_list_nor_delete(
    place: str, s3_endpoint: S3Endpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with policed(s3_endpoint.url, policy("sender", BUCKET, prefix_of(place))) as police:
        monkeypatch.setenv("AWS_ENDPOINT_URL", police.url)
        store = store_at(place)
        store.put("ST01.laz", b"points")
        assert police.refused == []
        for use in (
            lambda: store.get("ST01.laz"),
            lambda: store.remove("ST01.laz"),
            lambda: list(store.names("x")),
        ):
            with pytest.raises(StorageError, match="ACCESS_DENIED"):
                use()
    monkeypatch.setenv("AWS_ENDPOINT_URL", s3_endpoint.url)
    assert store_at(place).get("ST01.laz") == b"points"


def test_the_police_knows_what_a_request_needs() -> None:
    key = "arn:aws:s3:::b/p/k"
    assert needed_for("PUT", "/b/p/k", {"x-amz-copy-source": "b/q"}) == [
        Asked("s3:PutObject", key),
        Asked("s3:GetObject", "arn:aws:s3:::b/q"),
    ]
    assert needed_for("GET", "/b?list-type=2&prefix=p%2F", {}) == [
        Asked("s3:ListBucket", "arn:aws:s3:::b", "p/")
    ]
    writer = policy("writer", "b", "p")
    for asked, fine in (
        (Asked("s3:GetObject", key), True),
        (Asked("s3:GetObject", "arn:aws:s3:::b/q"), False),
        (Asked("s3:GetObject", "arn:aws:s3:::b/pq"), False),
        (Asked("s3:ListBucket", "arn:aws:s3:::b", "p/"), True),
        (Asked("s3:ListBucket", "arn:aws:s3:::b", ""), False),
        (Asked("s3:ListBucket", "arn:aws:s3:::b"), False),
        (Asked("s3:DeleteBucket", "arn:aws:s3:::b"), False),
    ):
        assert writer.allows(asked) is fine, asked
